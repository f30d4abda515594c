//! Notation of books and of other languages that Rust does not read, with what is written instead: `sin x`, `sin^2(x)`, `|x|`,
//! `d/dt x`, `0,5`, `1 < t < 2`.

use super::words::is_keyword;
use super::{choices, is_punct};
use crate::diagnostics::plain;
use proc_macro2::{Delimiter, LineColumn, Literal, Spacing, TokenStream, TokenTree};

/// Functions that books write without parentheses, and with an exponent behind their names.
const FUNCTIONS: [&str; 17] = [
    "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp",
    "ln", "sqrt", "abs", "dot",
];

/// The function whose name ends these tokens.
fn function(tokens: &[TokenTree]) -> Option<String> {
    let (TokenTree::Ident(name), before) = tokens.split_last()? else { return None };
    let name = name.to_string();
    let is_method = before.last().is_some_and(|before| is_punct(before, '.'));
    (FUNCTIONS.contains(&name.as_str()) && !is_method).then_some(name)
}

/// The help for a power of the function that ends `before`: `sin^2(x)`. `after` begins with the exponent.
pub fn power_of_function(before: &[TokenTree], after: &[TokenTree]) -> Option<String> {
    let name = function(before)?;
    let (sign, after) = match after {
        [minus, rest @ ..] if is_punct(minus, '-') => ("-", rest),
        _ => ("", after),
    };
    let exponent = match after {
        [TokenTree::Literal(n), ..] => format!("{sign}{n}"),
        _ => "2".into(),
    };
    let argument = match after {
        [_, TokenTree::Group(argument), ..] if argument.delimiter() == Delimiter::Parenthesis => {
            plain(argument.stream())
        }
        [_, TokenTree::Ident(argument), ..] if !is_keyword(&argument.to_string()) => argument.to_string(),
        _ => "x".into(),
    };
    let inverse = ["sin", "cos", "tan", "sinh", "cosh", "tanh"].contains(&name.as_str());
    Some(match (name.as_str(), exponent.as_str()) {
        ("exp", _) => "a power of Euler's number is written `exp(x)`".into(),
        (_, "-1") if inverse => {
            format!(
                "the inverse function is written `a{name}({argument})`, the reciprocal `1 / {name}({argument})`"
            )
        }
        _ => {
            let power = if exponent.parse::<i32>().is_ok() { "powi" } else { "powf" };
            format!("a power of a function is written `{name}({argument}).{power}({exponent})`")
        }
    })
}

/// An error of the parser's own, where the notation explains it.
pub fn explained(error: &syn::Error, tokens: &[TokenTree]) -> Option<syn::Error> {
    let message = error.to_string();
    if message.contains("help:") {
        return None;
    }
    let (level, i) = found(tokens, error.span().start())?;
    let (at, message) = if message == "comparison operators cannot be chained" {
        chained(&level, i, tokens)?
    } else {
        meant(&level, i)?
    };
    Some(syn::Error::new_spanned(at.iter().cloned().collect::<TokenStream>(), message))
}

/// The tokens among which one starts at this place, and its index; their number where the closing bracket does.
fn found(tokens: &[TokenTree], place: LineColumn) -> Option<(Vec<TokenTree>, usize)> {
    tokens.iter().enumerate().find_map(|(i, token)| match token {
        TokenTree::Group(group) if group.span_open().start() != place => {
            let inside: Vec<TokenTree> = group.stream().into_iter().collect();
            match group.span_close().start() == place {
                true => Some((inside.clone(), inside.len())),
                false => found(&inside, place),
            }
        }
        token => (token.span().start() == place).then(|| (tokens.to_vec(), i)),
    })
}

/// The meaning of notation that the parser does not read on at token `i`, and the tokens that have to change.
pub fn meant(tokens: &[TokenTree], i: usize) -> Option<(&[TokenTree], String)> {
    if let Some((bars, help)) = absolute_value(tokens, i) {
        return Some((
            bars,
            format!("`|…|` is not the absolute value: `|x|` begins a closure\nhelp: write {help}"),
        ));
    }
    if let Some(choice) = choices::meant(tokens, i) {
        return Some(choice);
    }
    let before = i.checked_sub(1)?;
    match (&tokens[before], tokens.get(i)?) {
        (TokenTree::Literal(whole), comma) if is_punct(comma, ',') => {
            let Some(TokenTree::Literal(digits)) = tokens.get(i + 1) else { return None };
            let is_integer = |literal: &Literal| literal.to_string().bytes().all(|c| c.is_ascii_digit());
            (is_integer(whole) && is_integer(digits)).then(|| {
                let message = format!(
                    "a decimal fraction is written with a point, not with a comma\nhelp: write `{whole}.{digits}`"
                );
                (&tokens[before..i + 2], message)
            })
        }
        (dot, operator) if is_punct(dot, '.') && ["*", "/", "^"].contains(&operator.to_string().as_str()) => {
            let help = match operator.to_string().as_str() {
                "^" => "a power is written `x.powi(2)`".into(),
                operator => format!("write `{operator}`"),
            };
            let message = format!("`.{operator}` is no operator of Rust\nhelp: {help}");
            Some((&tokens[before..=i], message))
        }
        (left, right) if ends_operand(left) && begins_operand(right) => Some(side_by_side(tokens, i)),
        _ => None,
    }
}

pub fn ends_operand(token: &TokenTree) -> bool {
    match token {
        TokenTree::Ident(word) => !is_keyword(&word.to_string()),
        TokenTree::Group(group) => group.delimiter() == Delimiter::Parenthesis,
        other => matches!(other, TokenTree::Literal(_)),
    }
}

pub fn begins_operand(token: &TokenTree) -> bool {
    match token {
        TokenTree::Ident(word) => !is_keyword(&word.to_string()),
        other => matches!(other, TokenTree::Literal(_)),
    }
}

/// Operands `i - 1` and `i` have nothing between them.
fn side_by_side(tokens: &[TokenTree], i: usize) -> (&[TokenTree], String) {
    let (before, right) = (&tokens[..i], &tokens[i]);
    let both = &tokens[i - 1..=i];
    if let [.., d, over, dt] = before
        && d.to_string() == "d"
        && is_punct(over, '/')
        && dt.to_string() == "dt"
    {
        let message =
            format!("a derivative is not a quotient\nhelp: the time derivative is written `dot({right})`");
        return (&tokens[i - 3..=i], message);
    }
    if let Some(name) = function(before) {
        let message = format!("the argument of a function is in parentheses\nhelp: write `{name}({right})`");
        return (both, message);
    }
    match before {
        [.., point, TokenTree::Ident(name)] if is_punct(point, '.') => {
            let message =
                format!("the argument of a method is in parentheses\nhelp: write `.{name}({right})`");
            (both, message)
        }
        [.., left @ (TokenTree::Ident(_) | TokenTree::Literal(_))] => {
            let message = format!("expected an operator before this\nhelp: a product is `{left} * {right}`");
            (&both[1..], message)
        }
        _ => (&both[1..], "expected an operator before this\nhelp: a product is `a * b`".into()),
    }
}

/// The bars that token `i` stands between or behind, with what is written instead.
fn absolute_value(tokens: &[TokenTree], i: usize) -> Option<(&[TokenTree], String)> {
    let mut bars = (0..tokens.len()).filter(|&at| {
        let is_or = |at: usize| matches!(&tokens[at], TokenTree::Punct(p) if p.spacing() == Spacing::Joint);
        let joined = at > 0 && is_punct(&tokens[at - 1], '|') && is_or(at - 1)
            || tokens.get(at + 1).is_some_and(|next| is_punct(next, '|')) && is_or(at);
        is_punct(&tokens[at], '|') && !joined
    });
    while let (Some(open), Some(close)) = (bars.next(), bars.next()) {
        // A keyword alone was meant as the name of a closure's argument.
        let is_name =
            |token: &TokenTree| matches!(token, TokenTree::Ident(word) if is_keyword(&word.to_string()));
        if (open + 1..=close + 1).contains(&i) && !(close == open + 2 && is_name(&tokens[open + 1])) {
            let inside: TokenStream = tokens[open + 1..close].iter().cloned().collect();
            return Some((&tokens[open..=close], format!("`abs({})`", plain(inside))));
        }
    }
    None
}

/// `a < b < c`, with the second comparison at token `i`.
fn chained<'a>(
    level: &'a [TokenTree],
    i: usize,
    statement: &[TokenTree],
) -> Option<(&'a [TokenTree], String)> {
    let is_comparison = |token: &TokenTree| "<>=!".chars().any(|c| is_punct(token, c));
    let ends = |token: &TokenTree| match token {
        TokenTree::Ident(word) => is_keyword(&word.to_string()),
        TokenTree::Punct(p) => ",;|&=!:".contains(p.as_char()),
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        TokenTree::Literal(_) => false,
    };
    level.get(i)?;
    let length = |at: usize| 1 + usize::from(level.get(at + 1).is_some_and(is_comparison));
    let last = level[..i].iter().rposition(is_comparison)?;
    let first = if last > 0 && is_comparison(&level[last - 1]) { last - 1 } else { last };
    let start = level[..first].iter().rposition(ends).map_or(0, |boundary| boundary + 1);
    let right = i + length(i);
    let stop = level[right..].iter().position(ends).map_or(level.len(), |boundary| right + boundary);
    let part = |from: usize, to: usize| plain(level[from..to].iter().cloned().collect::<TokenStream>());
    let operator = |at: usize| level[at..at + length(at)].iter().map(ToString::to_string).collect::<String>();
    // `x > 0 & t < 1`
    let is_single = |at: &usize| {
        let is = |at: usize| "&|".chars().any(|c| is_punct(&level[at], c));
        is(*at) && !is(at - 1) && !is(at + 1)
    };
    if let Some(at) = (last + 2..i).find(is_single) {
        let operator = &level[at];
        let message = format!(
            "`{operator}` binds more strongly than comparisons\nhelp: conditions are joined by `{operator}{operator}`"
        );
        return Some((&level[at..=at], message));
    }
    let middle = part(last + 1, i);
    let help = match statement.first() {
        Some(TokenTree::Ident(word)) if word == "constraint" => {
            "write two constraints, `constraint a: f == g; constraint b: g == h;`".into()
        }
        _ => format!(
            "write `{} {} {middle} && {middle} {} {}`",
            part(start, first),
            operator(first),
            operator(i),
            part(right, stop)
        ),
    };
    Some((&level[start..stop], format!("comparisons are not chained\nhelp: {help}")))
}
