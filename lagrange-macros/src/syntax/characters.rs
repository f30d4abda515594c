//! Characters of formulas that are no tokens of Rust, such as `²` and `½`. rustc refuses each of them, leaves it out,
//! and gives the rest to the macro, so this finds them in the text of the source.

use super::words::flatten;
use crate::diagnostics::Errors;
use proc_macro2::{LineColumn, Span, TokenStream, TokenTree};

/// Returns what is written instead of this character, if it is no token of Rust.
pub fn written(c: char) -> Option<&'static str> {
    Some(match c {
        '²' => "a square is written `x.powi(2)`",
        '³' => "a cube is written `x.powi(3)`",
        '¹' | '⁰' | '⁴'..='⁹' | '⁺' | '⁻' | 'ⁿ' => {
            "a power is written `x.powi(4)`, with any exponent `x.powf(y)`"
        }
        '₀'..='₉' => "an index is part of a name, `x1`, or the element of an array, `x[0]`",
        '½' => "one half is written `0.5`",
        '¼' => "one quarter is written `0.25`",
        '¾' => "three quarters are written `0.75`",
        '⅓' => "one third is written `1.0 / 3.0`",
        '⅔' => "two thirds are written `2.0 / 3.0`",
        '×' | '·' | '∙' | '⋅' | '•' => "a product is written `a * b`",
        '÷' => "a quotient is written `a / b`",
        '−' | '–' => "a difference is written `a - b`",
        '√' => "a square root is written `sqrt(x)`",
        '°' => "degrees become radians by `to_radians(x)`",
        '≤' => "write `<=`",
        '≥' => "write `>=`",
        '≠' => "write `!=`",
        '′' | '’' => "the time derivative is written `dot(x)`",
        '∂' | '∇' => {
            "derivatives by coordinates are taken by the compiler; the time derivative is written `dot(x)`"
        }
        '∑' => "a sum over a range is written `(0..N).map(|i| …).sum()`",
        '\\' => "a function is written by its name, such as `dot(x)`",
        _ => return None,
    })
}

/// Returns what is written instead of the command of LaTeX whose name begins this text.
fn of_latex(text: &str) -> Option<&'static str> {
    let name: String = text.chars().take_while(char::is_ascii_alphabetic).collect();
    Some(match name.as_str() {
        "frac" | "dfrac" | "tfrac" => "a quotient is written `a / b`",
        "cdot" | "times" => "a product is written `a * b`",
        "sqrt" => "a square root is written `sqrt(x)`",
        "dot" => "the time derivative is written `dot(x)`",
        "ddot" => "accelerations follow from the energies, and are not written; the velocity is `dot(x)`",
        "left" | "right" => "remove it: brackets have one size",
        "pi" => "this number is `PI`",
        _ if super::words::GREEK.iter().any(|(_, greek)| *greek == name) => {
            "a Greek letter is written as it is, `θ`, or by its name, `theta`"
        }
        _ => return None,
    })
}

/// Records such characters of this text, which starts at this place and has these tokens. Returns whether there are
/// any.
pub fn check(text: &str, start: LineColumn, tokens: &TokenStream, errors: &mut Errors) -> bool {
    // They may stand in strings, which only attributes have.
    if text.contains(['"', '\'']) || !text.contains(|c| written(c).is_some()) {
        return false;
    }
    let mut all = Vec::new();
    flatten(tokens.clone().into_iter(), &mut all);
    let (mut place, mut found) = (start, false);
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else {
            c.len_utf8()
        };
        let latex = if c == '\\' { of_latex(&rest[1..]) } else { None };
        // `·` is a letter to Rust within a name: `k·x` is one, and is unknown.
        let is_letter = |token: &TokenTree| matches!(token, TokenTree::Ident(name) if (name.span().start()..name.span().end()).contains(&place));
        let is_read = || length > c.len_utf8() || all.iter().any(is_letter);
        if let Some(help) = latex.or_else(|| written(c))
            && !is_read()
        {
            let ended = all.iter().map(TokenTree::span).filter(|span| span.end() <= place);
            let before = ended.max_by_key(Span::end);
            let message = format!("`{c}` is no token of Rust\nhelp: {help}");
            errors.record(syn::Error::new(before.unwrap_or(Span::call_site()), message));
            found = true;
        }
        for passed in rest[..length].chars() {
            match passed {
                '\n' => place = LineColumn { line: place.line + 1, column: 0 },
                _ => place.column += 1,
            }
        }
        rest = &rest[length..];
    }
    found
}

/// Returns this text without such characters, as rustc gives it to the macro: all but those within a name.
#[cfg(test)]
pub fn without(text: &str) -> String {
    let mut is_name = false;
    let kept = |c: char| {
        is_name = c.is_alphabetic() || c.is_ascii_digit() || c == '_' || (is_name && c == '·');
        if is_name || written(c).is_none() { c } else { ' ' }
    };
    text.chars().map(kept).collect()
}

/// Returns the length of the comment, with comments inside, that begins this text.
fn block_comment(text: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < text.len() {
        let rest = &text[at..];
        match (rest.starts_with("/*"), rest.starts_with("*/")) {
            (true, _) => depth += 1,
            (_, true) => depth -= 1,
            _ => {
                at += rest.chars().next().map_or(1, char::len_utf8);
                continue;
            }
        }
        at += 2;
        if depth == 0 {
            break;
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(text: &str) -> Vec<String> {
        let tokens: TokenStream = without(text).parse().expect("tokens of Rust");
        let mut errors = Errors::default();
        check(text, LineColumn { line: 1, column: 0 }, &tokens, &mut errors);
        errors.said().into_iter().map(|(at, _)| at.source_text().unwrap_or_default()).collect()
    }

    #[test]
    fn characters_are_refused_behind_the_token_before_them() {
        assert_eq!(places("T = (x\n + ẋ)² + θ³;"), ["(x\n + ẋ)", "θ"]);
    }

    #[test]
    fn comments_and_strings_may_hold_any_character() {
        assert!(places("// x²\n/* ½ /* ½ */ ½ */ /// θ²\nT = x;").is_empty());
        assert!(places("#[doc = \"x²\"] T = x;").is_empty());
        assert_eq!(places("T = k·x · y;"), ["k·x"]);
        assert_eq!(places("/* ½ */ T = x²; // ½"), ["x"]);
    }
}
