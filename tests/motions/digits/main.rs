//! Properties of methods of all families.

mod digits;
mod within;
