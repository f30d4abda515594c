//! Notation of books and of other languages that Rust does not read, with what is written instead: `sin x`,
//! `sin^2(x)`, `|x|`, `d/dt x`, `0,5`, `1 < t < 2`.

use super::events::OPTIONS;
use super::words::{begins_operand, ends_operand, is_keyword};
use super::{choices, is_punct, signs};
use crate::diagnostics::plain;
use proc_macro2::{Delimiter, LineColumn, Literal, Spacing, TokenStream, TokenTree};
use quote::ToTokens;

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
    let place = error.span().start();
    if let Some((at, message)) = holder(tokens, place).and_then(|(outer, at)| in_brackets(&outer, at, place))
    {
        return Some(syn::Error::new_spanned(at, message));
    }
    let (level, i) = found(tokens, place)?;
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

/// The tokens among which the brackets around this place stand, and the index of these brackets.
fn holder(tokens: &[TokenTree], place: LineColumn) -> Option<(Vec<TokenTree>, usize)> {
    tokens.iter().enumerate().find_map(|(i, token)| {
        let TokenTree::Group(group) = token else { return None };
        let inside: Vec<TokenTree> = group.stream().into_iter().collect();
        let is_here =
            group.span_close().start() == place || inside.iter().any(|token| token.span().start() == place);
        if is_here { Some((tokens.to_vec(), i)) } else { holder(&inside, place) }
    })
}

/// The meaning of brackets whose content is not read on at this place: `x[0, 1]`, `x[0:2]`, `x{1}`, `{a, b}`,
/// `[f(i) for i in range(3)]`.
fn in_brackets(outer: &[TokenTree], at: usize, place: LineColumn) -> Option<(TokenStream, String)> {
    let TokenTree::Group(group) = outer.get(at)? else { return None };
    let inside: Vec<TokenTree> = group.stream().into_iter().collect();
    let text = |tokens: &[TokenTree]| plain(tokens.iter().cloned().collect::<TokenStream>());
    let before = at.checked_sub(1).map(|before| &outer[before]);
    let name = before.filter(|token| matches!(token, TokenTree::Ident(_)) && ends_operand(token));
    let i = inside.iter().position(|token| token.span().start() == place).unwrap_or(inside.len());
    let here = inside.get(i);
    let is_here = |c: char| here.is_some_and(|token| is_punct(token, c));
    let all = group.stream();
    match (group.delimiter(), name) {
        (Delimiter::Parenthesis | Delimiter::Bracket, _)
            if here.is_some_and(|word| word.to_string() == "for") =>
        {
            let (index, range) = match &inside[i + 1..] {
                [index, _, range, TokenTree::Group(n)] if range.to_string() == "range" => {
                    let n = plain(n.stream());
                    (
                        index.to_string(),
                        if n.contains(',') { n.replacen(", ", "..", 1) } else { format!("0..{n}") },
                    )
                }
                [index, _, range @ ..] if !range.is_empty() => {
                    (index.to_string(), text(range).replace(" . . ", ".."))
                }
                _ => ("i".into(), "0..N".into()),
            };
            let sum = if group.delimiter() == Delimiter::Parenthesis { ".sum()" } else { "" };
            let message = format!(
                "`for` makes no list in an expression\nhelp: write `({range}).map(|{index}| {}){sum}`",
                text(&inside[..i])
            );
            Some((here.into_iter().cloned().collect(), message))
        }
        (Delimiter::Bracket, None) if is_here(',') && outer[0].to_string() == "input" => {
            let message = format!(
                "an input is declared without its limits\nhelp: limits are where it is used, `u.clamp({})`",
                text(&inside)
            );
            Some((all, message))
        }
        (Delimiter::Bracket, Some(name))
            if is_here(',') && ["D", "Diff"].contains(&name.to_string().as_str()) =>
        {
            let message = format!(
                "unknown function `{name}`\nhelp: the time derivative is `dot({})`",
                text(&inside[..i])
            );
            Some((name.clone().into(), message))
        }
        (Delimiter::Bracket, Some(name)) if is_here(',') => {
            if name.to_string() == "Q" {
                let each = inside.split(|token| is_punct(token, ','));
                let each: Vec<String> = each.map(|x| format!("`Q[{}] = …;`", text(x))).collect();
                let message =
                    format!("a generalized force acts on one coordinate\nhelp: write {}", each.join(" "));
                return Some((all, message));
            }
            let indices: String = inside
                .split(|token| is_punct(token, ','))
                .map(|index| format!("[{}]", text(index)))
                .collect();
            let message =
                format!("an index is one integer\nhelp: an element of a matrix is `{name}{indices}`");
            Some((all, message))
        }
        (Delimiter::Bracket, Some(name)) if is_here(':') => {
            let end = if i + 1 < inside.len() { text(&inside[i + 1..]) } else { "N".into() };
            let start = if i == 0 { "0".into() } else { text(&inside[..i]) };
            let message = format!(
                "an index is one integer\nhelp: a part of an array is `({start}..{end}).map(|i| {name}[i])`"
            );
            Some((all, message))
        }
        (Delimiter::Brace, Some(name)) if name.to_string().ends_with('_') => {
            let message = format!("an index is part of a name\nhelp: write `{name}{}`", text(&inside));
            Some((group.clone().into_token_stream(), message))
        }
        (Delimiter::Brace, Some(name)) if inside.len() == 1 => {
            let message = format!(
                "an index is in brackets\nhelp: an element of an array is `{name}[{}]`",
                text(&inside)
            );
            Some((group.clone().into_token_stream(), message))
        }
        (Delimiter::Brace, None) if is_here(',') => {
            let message = format!("an array is in brackets\nhelp: write `[{}]`", text(&inside));
            Some((group.clone().into_token_stream(), message))
        }
        _ => None,
    }
}

/// The meaning of notation that the parser does not read on at token `i`, and the tokens that have to change.
pub fn meant(tokens: &[TokenTree], i: usize) -> Option<(&[TokenTree], String)> {
    if let Some((bars, help)) = absolute_value(tokens, i) {
        return Some((
            bars,
            format!("`|…|` is not the absolute value: `|x|` begins a closure\nhelp: write {help}"),
        ));
    }
    if let Some(known) = choices::meant(tokens, i).or_else(|| signs::meant(tokens, i)) {
        return Some(known);
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
        // The first word begins the statement.
        (TokenTree::Ident(word), _) if before == 0 && super::STATEMENTS.iter().any(|first| word == first) => {
            None
        }
        (left, right) if ends_operand(left) && begins_operand(right) => Some(side_by_side(tokens, i)),
        _ => None,
    }
}

/// Operands `i - 1` and `i` have nothing between them.
fn side_by_side(tokens: &[TokenTree], i: usize) -> (&[TokenTree], String) {
    let (before, right) = (&tokens[..i], &tokens[i]);
    let both = &tokens[i - 1..=i];
    let is_integer = |token: &TokenTree| {
        matches!(token, TokenTree::Literal(_)) && token.to_string().bytes().all(|c| c.is_ascii_digit())
    };
    if is_integer(&tokens[i - 1]) && is_integer(right) {
        let message = format!("a number has no spaces in it\nhelp: write `{}{right}`", tokens[i - 1]);
        return (both, message);
    }
    if let [.., d, over, dt] = before
        && d.to_string() == "d"
        && is_punct(over, '/')
        && dt.to_string() == "dt"
    {
        let message =
            format!("a derivative is not a quotient\nhelp: the time derivative is written `dot({right})`");
        return (&tokens[i - 3..=i], message);
    }
    if let [event, .., option] = before
        && event.to_string() == "event"
        && OPTIONS.contains(&option.to_string().as_str())
    {
        let message = format!(
            "an option follows the function of an event, behind a comma\nhelp: write `{right}, {option}`"
        );
        return (both, message);
    }
    if before[0].to_string() == "event" && OPTIONS.contains(&right.to_string().as_str()) {
        let message = format!("a comma stands before an option of an event\nhelp: write `, {right}`");
        return (&both[1..], message);
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
        [.., left @ (TokenTree::Ident(_) | TokenTree::Literal(_))]
            if ["deg", "degree", "degrees"].contains(&right.to_string().as_str()) =>
        {
            (both, format!("an angle is in radians\nhelp: degrees become radians by `to_radians({left})`"))
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
