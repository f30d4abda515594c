//! MathML.
