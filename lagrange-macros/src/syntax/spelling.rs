//! Refuses tokens that mean in Rust something else than in a formula: `x**2`, which Rust reads as `x * (*2)`,
//! suffixes such as `5kg`, and attributes of expressions. They are found in all tokens of a statement, evaluated or
//! not.

use super::words::is_keyword;
use super::{is_punct, notation};
use crate::diagnostics::Errors;
use proc_macro2::{Spacing, TokenStream, TokenTree};
use syn::Lit;

/// Types whose names Rust accepts after the digits of an integer.
pub const INTEGERS: [&str; 12] =
    ["i8", "i16", "i32", "i64", "i128", "isize", "u8", "u16", "u32", "u64", "u128", "usize"];
/// Symbols that are read as units.
pub const UNITS: [&str; 40] = [
    "kg", "g", "mg", "t", "m", "km", "cm", "mm", "um", "nm", "µm", "s", "ms", "us", "min", "h", "N", "kN",
    "mN", "J", "kJ", "W", "kW", "Hz", "kHz", "rad", "deg", "Pa", "kPa", "MPa", "GPa", "bar", "V", "mV", "A",
    "mA", "C", "K", "T", "rpm",
];

/// Records every such token of a statement. Returns whether the rest of it means what was meant, so that it can be
/// read: after `**` it does not.
pub fn check(tokens: &[TokenTree], errors: &mut Errors) -> bool {
    let mut rest = tokens;
    while let [TokenTree::Punct(hash), TokenTree::Group(_), after @ ..] = rest
        && hash.as_char() == '#'
    {
        rest = after;
    }
    let declares = matches!(rest.first(), Some(TokenTree::Ident(word)) if word == "param" || word == "input" || word == "coord" || word == "state");
    level(rest, declares, errors)
}

/// `declares`: may what follows a comma have attributes?
fn level(tokens: &[TokenTree], declares: bool, errors: &mut Errors) -> bool {
    let (mut readable, mut attributed) = (true, false);
    for (i, token) in tokens.iter().enumerate() {
        let previous = i.checked_sub(1).map(|i| &tokens[i]);
        if let Some(message) = previous.and_then(|previous| prime(previous, &tokens[i..])) {
            errors.push(previous, message);
            return false;
        }
        match token {
            TokenTree::Literal(literal) => literal_suffix(&Lit::new(literal.clone()), errors),
            TokenTree::Group(_) if previous.is_some_and(|p| is_punct(p, '#')) => continue,
            TokenTree::Group(group) => {
                readable &= level(&group.stream().into_iter().collect::<Vec<_>>(), false, errors);
            }
            TokenTree::Punct(p) if p.as_char() == '*' && p.spacing() == Spacing::Joint => {
                if let Some(star) = tokens.get(i + 1).filter(|next| is_punct(next, '*')) {
                    let at: TokenStream = [token.clone(), star.clone()].into_iter().collect();
                    let help = power(&tokens[..i], &tokens[i + 2..]);
                    errors.push(at, format!("`**` is no operator of Rust\nhelp: {help}"));
                    readable = false;
                }
            }
            TokenTree::Punct(p) if p.as_char() == '^' => {
                // Any other base is known once it is evaluated.
                if let Some(help) = notation::power_of_function(&tokens[..i], &tokens[i + 1..]) {
                    errors.push(token, format!("`^` is exclusive or in Rust\nhelp: {help}"));
                    readable = false;
                }
            }
            TokenTree::Punct(p)
                if p.as_char() == '#' && !matches!(tokens.get(i + 1), Some(TokenTree::Group(_))) =>
            {
                let help = match &tokens[i + 1..] {
                    [define, TokenTree::Ident(name), ..] if define.to_string() == "define" => {
                        format!(
                            "a number is declared by `param {name} = …;`, any other name by `let {name} = …;`"
                        )
                    }
                    _ => "a comment begins with `//`".into(),
                };
                errors.push(token, format!("`#` begins an attribute\nhelp: {help}"));
                readable = false;
            }
            TokenTree::Punct(p) if p.as_char() == '#' => {
                attributed = declares && (attributed || previous.is_some_and(|p| is_punct(p, ',')));
                if !attributed {
                    let at: TokenStream = tokens[i..].iter().take(2).cloned().collect();
                    errors.push(at, "an attribute has no effect in an expression\nhelp: remove it");
                }
                continue;
            }
            _ => {}
        }
        attributed = false;
    }
    readable
}

/// The message for a name with primes, `x'` and `x''`, if rustc gives the primes to the macro: as a character where
/// there is another one in the line, which it refuses as well, and as a lifetime before a word.
fn prime(previous: &TokenTree, after: &[TokenTree]) -> Option<String> {
    let TokenTree::Ident(name) = previous else { return None };
    if is_keyword(&name.to_string()) {
        return None;
    }
    let is_second = match after {
        [TokenTree::Literal(character), ..] if character.to_string().starts_with('\'') => {
            character.to_string().starts_with("''")
        }
        [quote, TokenTree::Ident(_), ..] if is_punct(quote, '\'') => false,
        _ => return None,
    };
    Some(match is_second {
        true => format!(
            "accelerations follow from the energies, and are not written\nhelp: the velocity of `{name}` is `dot({name})`"
        ),
        false => format!("`'` is no derivative in Rust\nhelp: the velocity of `{name}` is `dot({name})`"),
    })
}

/// The help for `base**exponent`. `after` begins with the exponent.
fn power(before: &[TokenTree], after: &[TokenTree]) -> String {
    if let Some(help) = notation::power_of_function(before, after) {
        return help;
    }
    let base = match before {
        // Part of a path, a field or a call.
        [.., TokenTree::Punct(p), TokenTree::Ident(_)] if matches!(p.as_char(), '.' | ':') => None,
        [.., TokenTree::Ident(_), TokenTree::Group(_)] => None,
        [.., last @ (TokenTree::Ident(_) | TokenTree::Group(_))] => Some(last.to_string()),
        _ => None,
    };
    let base = base.as_deref().unwrap_or("x");
    let integer = |t: &TokenTree| matches!(t, TokenTree::Literal(l) if l.to_string().parse::<i32>().is_ok());
    let written = match after.first() {
        Some(n) if integer(n) && before.last().is_some_and(|base| base.to_string() == "10") => {
            format!("1e{n}")
        }
        Some(n) if integer(n) => format!("{base}.powi({n})"),
        Some(x @ TokenTree::Literal(_)) => format!("{base}.powf({x})"),
        _ => format!("{base}.powi(2)`, with any exponent `{base}.powf(y)"),
    };
    format!("a power is written `{written}`")
}

/// Does Rust accept the suffix of this literal, if it has one, beside numbers of the system?
pub fn has_known_suffix(literal: &Lit) -> bool {
    match literal {
        Lit::Int(int) => match int.suffix() {
            "" => true,
            "f64" => !has_base(&int.to_string()),
            suffix => INTEGERS.contains(&suffix),
        },
        Lit::Float(float) => matches!(float.suffix(), "" | "f64"),
        _ => true,
    }
}

/// Is this literal hexadecimal, octal or binary?
fn has_base(digits: &str) -> bool {
    ["0x", "0o", "0b"].iter().any(|base| digits.starts_with(base))
}

fn literal_suffix(literal: &Lit, errors: &mut Errors) {
    let (written, suffix) = match literal {
        _ if has_known_suffix(literal) => return,
        Lit::Int(int) => (int.to_string(), int.suffix()),
        Lit::Float(float) => (float.to_string(), float.suffix()),
        _ => return,
    };
    let digits = written.strip_suffix(suffix).unwrap_or(&written).trim_end_matches('_');
    let message = match suffix {
        "f32" => format!(
            "Rust does not mix an `f32` with other numbers\nhelp: write `{digits}`, which takes the type of the system's numbers"
        ),
        "f64" => format!("Rust has no literals of floats in this base\nhelp: write `{digits} as f64`"),
        _ if INTEGERS.contains(&suffix) => {
            format!("`{suffix}` is a type of integers, and this is none\nhelp: write `{digits}`")
        }
        "f" | "F" => format!(
            "`{written}` is not a number: Rust has no suffix `{suffix}`\nhelp: write `{digits}`; a product is `{digits} * {suffix}`"
        ),
        "π" => format!("`{written}` is not a number\nhelp: a product is `{digits} * PI`"),
        _ if UNITS.contains(&suffix) => format!(
            "`{written}` is not a number: a literal has no unit\nhelp: write `{digits}`, with all values in units that fit together, such as kg, m and s; a product is `{digits} * {suffix}`"
        ),
        _ => format!(
            "`{written}` is not a number: Rust has no suffix `{suffix}`\nhelp: a product is `{digits} * {suffix}`"
        ),
    };
    errors.push(literal, message);
}
