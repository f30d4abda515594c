//! Conditions and choices of other languages, with what is written instead: `a if c else b`, `c ? a : b`,
//! `if c: a else: b`, `c and d`, `x ~= y`, `t in 1..2`.

use super::is_punct;
use super::words::{CHOICE, begins_operand, ends_operand};
use crate::diagnostics::plain;
use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

/// The meaning of a condition that the parser does not read on at token `i`, and the tokens that have to change.
pub fn meant(tokens: &[TokenTree], i: usize) -> Option<(&[TokenTree], String)> {
    let next = tokens.get(i)?;
    let previous = i.checked_sub(1).map(|i| &tokens[i]);
    let after_operand = previous.is_some_and(ends_operand);
    if let Some((at, operator)) = operator(tokens, i) {
        let written: String = at.iter().map(ToString::to_string).collect();
        return Some((at, format!("`{written}` is no operator of Rust\nhelp: write `{operator}`")));
    }
    let here = &tokens[i..=i];
    match next.to_string().as_str() {
        "if" if after_operand => {
            let message = format!(
                "a choice begins with its condition\nhelp: write `{}`",
                conditional(&tokens[start(tokens, i)..stop(tokens, i)])
            );
            return Some((here, message));
        }
        joint @ ("and" | "or") if after_operand => {
            let operator = if joint == "and" { "&&" } else { "||" };
            let message =
                format!("`{joint}` is no operator of Rust\nhelp: conditions are joined by `{operator}`");
            return Some((here, message));
        }
        "is" if after_operand => {
            let (length, operator) = match tokens.get(i + 1) {
                Some(not) if is_word(not, "not") => (2, "!="),
                _ => (1, "=="),
            };
            let written = text(&tokens[i..i + length]);
            let message = format!("`{written}` is no operator of Rust\nhelp: write `{operator}`");
            return Some((&tokens[i..i + length], message));
        }
        word @ ("elif" | "elseif" | "elsif") if previous.is_some_and(is_brace) => {
            let message = format!("`{word}` is no word of Rust\nhelp: write `else if`");
            return Some((here, message));
        }
        "in" if after_operand => {
            return Some((here, format!("`in` is no operator\nhelp: {}", range(tokens, i)?)));
        }
        _ => {}
    }
    if previous.is_some_and(|word| is_word(word, "else")) && i > 1 && is_brace(&tokens[i - 2]) {
        let value = text(&tokens[i..stop(tokens, i)]);
        let message = format!("the values of an `if` are in braces\nhelp: write `else {{ {value} }}`");
        return Some((here, message));
    }
    if previous.is_some_and(|not| is_word(not, "not")) && begins_operand(next) {
        let end = tokens[i..].iter().position(ends_condition).map_or(tokens.len(), |length| i + length);
        let message = format!("`not` is no operator of Rust\nhelp: write `!({})`", text(&tokens[i..end]));
        return Some((&tokens[i - 1..i], message));
    }
    ternary(tokens, i).or_else(|| without_braces(tokens, i))
}

/// An operator of another language before or at token `i`, and the one of Rust.
fn operator(tokens: &[TokenTree], i: usize) -> Option<(&[TokenTree], &'static str)> {
    let pair = |at: usize, left: char, right: char| {
        tokens.get(at).is_some_and(|token| is_punct(token, left))
            && tokens.get(at + 1).is_some_and(|token| is_punct(token, right))
    };
    let joint = |at: &usize| matches!(&tokens[*at], TokenTree::Punct(p) if p.spacing() == Spacing::Joint);
    if pair(i, '~', '=') {
        return Some((&tokens[i..i + 2], "!="));
    }
    if is_punct(&tokens[i], '~') {
        return Some((&tokens[i..=i], "!"));
    }
    if pair(i, '=', '>') {
        return Some((&tokens[i..i + 2], ">="));
    }
    if let Some(at) = i.checked_sub(1).filter(|at| pair(*at, '<', '>') && joint(at)) {
        return Some((&tokens[at..=i], "!="));
    }
    let backwards = (0..i).rev().find(|at| pair(*at, '=', '<') && joint(at))?;
    Some((&tokens[backwards..backwards + 2], "<="))
}

/// `c ? a : b`, of which token `i` is the first of `a`, or the colon.
fn ternary(tokens: &[TokenTree], i: usize) -> Option<(&[TokenTree], String)> {
    let (start, stop) = (start(tokens, i), stop(tokens, i));
    let mark = (start..i).find(|at| is_punct(&tokens[*at], '?'))?;
    if mark + 1 != i && !is_punct(&tokens[i], ':') {
        return None;
    }
    let colon = (i..stop).find(|at| is_colon(tokens, *at));
    let help = match colon {
        Some(colon) => format!(
            "a number that depends on a condition is `{}`",
            written(&tokens[start..mark], &tokens[mark + 1..colon], &tokens[colon + 1..stop])
        ),
        None => CHOICE.into(),
    };
    let message = format!("`?` does not choose\nhelp: {help}");
    Some((&tokens[mark..=mark], message))
}

/// `if c: a else: b`, `if c then a else b`, `if (c) a else b`, where token `i` follows the condition.
fn without_braces(tokens: &[TokenTree], i: usize) -> Option<(&[TokenTree], String)> {
    let keyword = tokens[..i].iter().rposition(|token| is_word(token, "if"))?;
    let stop = stop(tokens, i);
    let is_separate = is_punct(&tokens[i], ':') || is_word(&tokens[i], "then");
    let is_of_c = keyword + 2 == i && matches!(tokens[i - 1], TokenTree::Group(_));
    let compares = |token: &TokenTree| "<>=!".chars().any(|c| is_punct(token, c));
    // `if x > 0 k else 0 end`
    let is_bare = ends_operand(&tokens[i - 1])
        && begins_operand(&tokens[i])
        && tokens[keyword..i].iter().any(compares)
        && tokens[i..stop].iter().any(|token| is_word(token, "else"));
    if i == keyword + 1 || !(is_separate || is_of_c || is_bare) || tokens[keyword..stop].iter().any(is_brace)
    {
        return None;
    }
    let condition = match &tokens[keyword + 1..i] {
        [TokenTree::Group(group)] => group.stream().into_iter().collect(),
        tokens => tokens.to_vec(),
    };
    let first = if is_separate { i + 1 } else { i };
    let (yes, no) = match (first..stop).find(|at| is_word(&tokens[*at], "else")) {
        Some(at) => (&tokens[first..at], &tokens[at + 1..stop]),
        None => (&tokens[first..stop], &tokens[..0]),
    };
    let is_value = |colon: &TokenTree| !is_punct(colon, ':');
    let no = no.iter().position(is_value).map_or(&no[..0], |first| &no[first..]);
    let no = match no {
        [rest @ .., last] if is_word(last, "end") => rest,
        no => no,
    };
    let message =
        format!("the values of an `if` are in braces\nhelp: write `{}`", written(&condition, yes, no));
    Some((&tokens[i..=i], message))
}

/// The help for `x in a..b`, where `in` is token `i`.
fn range(tokens: &[TokenTree], i: usize) -> Option<String> {
    let first = tokens[..i].iter().rposition(ends_condition).map_or(0, |boundary| boundary + 1);
    let last = tokens[i..].iter().position(ends_condition).map_or(tokens.len(), |length| i + length);
    let (name, within) = (text(&tokens[first..i]), &tokens[i + 1..last]);
    if tokens.get(last).is_some_and(|comma| is_punct(comma, ',')) {
        return Some(format!("a sum over a range is `({}).map(|{name}| …).sum()`", text(within)));
    }
    between(&name, within)
}

/// The comparisons that hold for a number `name` in `a..b`, `a..=b` or `[a, b]`.
pub fn between(name: &str, within: &[TokenTree]) -> Option<String> {
    let inside: Vec<TokenTree>;
    let (at, within, length) = match within {
        [TokenTree::Group(group)] => {
            inside = group.stream().into_iter().collect();
            match inside.iter().position(|token| is_punct(token, ',')) {
                Some(comma) => (comma, &inside[..], 1),
                None => return between(name, &inside),
            }
        }
        _ => (within.windows(2).position(|dots| dots.iter().all(|dot| is_punct(dot, '.')))?, within, 2),
    };
    let after = &within[at + length..];
    let (end, after) = match after {
        [equals, rest @ ..] if is_punct(equals, '=') => ("<=", rest),
        _ => (if length == 1 { "<=" } else { "<" }, after),
    };
    Some(format!("write `{name} >= {} && {name} {end} {}`", text(&within[..at]), text(after)))
}

/// `a if c else b`, as Rust has it.
fn conditional(tokens: &[TokenTree]) -> String {
    let place = |word| tokens.iter().position(|token| is_word(token, word));
    match (place("if"), place("else")) {
        (Some(at), Some(otherwise)) if at < otherwise => {
            let no = conditional(&tokens[otherwise + 1..]);
            format!("if {} {{ {} }} else {{ {no} }}", text(&tokens[at + 1..otherwise]), text(&tokens[..at]))
        }
        (Some(at), _) => written(&tokens[at + 1..], &tokens[..at], &[]),
        _ => text(tokens),
    }
}

fn written(condition: &[TokenTree], yes: &[TokenTree], no: &[TokenTree]) -> String {
    let no = if no.is_empty() { "…".into() } else { text(no) };
    format!("if {} {{ {} }} else {{ {no} }}", text(condition), text(yes))
}

fn text(tokens: &[TokenTree]) -> String {
    let text = plain(tokens.iter().cloned().collect::<TokenStream>());
    text.strip_prefix("- ").map_or(text.clone(), |rest| format!("-{rest}"))
}

fn is_brace(token: &TokenTree) -> bool {
    matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace)
}

fn is_word(token: &TokenTree, word: &str) -> bool {
    matches!(token, TokenTree::Ident(found) if found == word)
}

/// A colon that is not part of `::`.
fn is_colon(tokens: &[TokenTree], at: usize) -> bool {
    let joint = |at: usize| matches!(&tokens[at], TokenTree::Punct(p) if p.as_char() == ':' && p.spacing() == Spacing::Joint);
    is_punct(&tokens[at], ':') && !joint(at) && !(at > 0 && joint(at - 1))
}

/// The first token of the expression that goes on at token `i`: it follows `=`, a colon or a comma.
fn start(tokens: &[TokenTree], i: usize) -> usize {
    let compares = |at: usize| matches!(&tokens[at], TokenTree::Punct(p) if p.spacing() == Spacing::Joint && "=<>!".contains(p.as_char()));
    let ends = |at: &usize| {
        let token = &tokens[*at];
        let assigns = is_punct(token, '=') && !compares(*at) && !(*at > 0 && compares(at - 1));
        assigns || is_punct(token, ',') || is_colon(tokens, *at)
    };
    (0..i).rev().find(ends).map_or(0, |boundary| boundary + 1)
}

/// The end of the expression that goes on at token `i`.
fn stop(tokens: &[TokenTree], i: usize) -> usize {
    let ends = |token: &TokenTree| is_punct(token, ',') || is_punct(token, ';');
    tokens[i..].iter().position(ends).map_or(tokens.len(), |length| i + length)
}

/// Does a condition end before this token, or begin after it?
fn ends_condition(token: &TokenTree) -> bool {
    match token {
        TokenTree::Ident(_) => {
            ["if", "else", "and", "or", "not", "then"].iter().any(|word| is_word(token, word))
        }
        TokenTree::Punct(p) => ",;|&!:=".contains(p.as_char()),
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        TokenTree::Literal(_) => false,
    }
}
