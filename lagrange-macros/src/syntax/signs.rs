//! Signs of other languages that Rust does not read, with what is written instead: `.5`, `5%`, `+x`, `x++`, `3!`,
//! `||x||`, `===`, `:=`.

use super::is_punct;
use super::words::ends_operand;
use crate::diagnostics::plain;
use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// The meaning of a sign that the parser does not read on at token `i`, and the tokens that have to change.
pub fn meant(tokens: &[TokenTree], i: usize) -> Option<(&[TokenTree], String)> {
    let next = tokens.get(i);
    let is_next = |c: char| next.is_some_and(|token| is_punct(token, c));
    let is = |at: usize, c: char| tokens.get(at).is_some_and(|token| is_punct(token, c));
    let is_before = |back: usize, c: char| i.checked_sub(back).is_some_and(|at| is(at, c));
    let ends = |at: Option<usize>| at.is_some_and(|at| is_operand(&tokens[at]));
    let after_operand = ends(i.checked_sub(1));
    if let Some(at) = (i.saturating_sub(2)..=i).find(|&at| (at..at + 3).all(|at| is(at, '.'))) {
        let message = "a statement goes on in the next line by itself\nhelp: remove `...`";
        return Some((&tokens[at..at + 3], message.into()));
    }
    if let (true, false, Some(TokenTree::Literal(digits))) = (is_next('.'), after_operand, tokens.get(i + 1))
    {
        let message = format!("a number begins with a digit\nhelp: write `0.{digits}`");
        return Some((&tokens[i..i + 2], message));
    }
    if let (true, Some(TokenTree::Literal(number))) =
        (is_before(1, '%'), i.checked_sub(2).map(|at| &tokens[at]))
        && let Some(fraction) = hundredth(&number.to_string())
    {
        let message =
            format!("`%` is the remainder of a division, not a percentage\nhelp: write `{fraction}`");
        return Some((&tokens[i - 2..i], message));
    }
    if is_next('$') {
        return Some((&tokens[i..=i], "`$` is no part of a formula\nhelp: remove it".into()));
    }
    if is_next('@') && after_operand {
        let message = "`@` is no operator of Rust\nhelp: the inner product of arrays is `a.dot(b)`";
        return Some((&tokens[i..=i], message.into()));
    }
    if is_next('!') && after_operand && !is(i + 1, '=') {
        let n = tokens[i - 1].to_string().parse().ok().filter(|n: &u64| *n <= 20);
        let help = n.map_or_else(
            || "the product of the first integers is `(1..=n).product()`".into(),
            |n| format!("write `{}`", (1..=n).product::<u64>()),
        );
        return Some((&tokens[i - 1..=i], format!("`!` is not the factorial\nhelp: {help}")));
    }
    if is_next('=') && is_before(1, '=') && (is_before(2, '=') || is_before(2, '!')) {
        let operator = if is_before(2, '!') { "!=" } else { "==" };
        let message = format!("`{operator}=` is no operator of Rust\nhelp: write `{operator}`");
        return Some((&tokens[i - 2..=i], message));
    }
    if is_next('=') && (is_before(1, '=') || is_before(1, ':')) {
        let written: String = tokens[i - 1..=i].iter().map(ToString::to_string).collect();
        let message = format!("a definition has one `=`, not `{written}`\nhelp: write `=`");
        return Some((&tokens[i - 1..=i], message));
    }
    if is_next('+') && is_before(1, '+') && !tokens.get(i + 1).is_some_and(is_operand) {
        let left = if ends(i.checked_sub(2)) { tokens[i - 2].to_string() } else { "x".into() };
        let message = format!("nothing is counted up in an expression\nhelp: write `{left} + 1`");
        return Some((&tokens[i - 1..=i], message));
    }
    if is_next('+') && !after_operand {
        return Some((&tokens[i..=i], "Rust has no `+` before a term\nhelp: remove it".into()));
    }
    norm(tokens, i).or_else(|| half_a_comparison(tokens, i)).or_else(|| missing(tokens, i))
}

fn is_operand(token: &TokenTree) -> bool {
    ends_operand(token) || matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Bracket)
}

/// `||x||`, which ends before token `i`.
fn norm(tokens: &[TokenTree], i: usize) -> Option<(&[TokenTree], String)> {
    let is_double =
        |at: usize| tokens.get(at..at + 2).is_some_and(|bars| bars.iter().all(|bar| is_punct(bar, '|')));
    let close = i.checked_sub(2).filter(|close| is_double(*close))?;
    let open = (0..close).rev().find(|open| is_double(*open) && *open + 2 < close)?;
    if open.checked_sub(1).is_some_and(|before| is_operand(&tokens[before])) {
        return None;
    }
    let inside = plain(tokens[open + 2..close].iter().cloned().collect::<TokenStream>());
    let message = format!(
        "`||…||` is not the length of a vector\nhelp: the length of an array is `{inside}.norm()`, the absolute value of a number `abs({inside})`"
    );
    Some((&tokens[open..i], message))
}

/// `x > 0 && < 1`
fn half_a_comparison(tokens: &[TokenTree], i: usize) -> Option<(&[TokenTree], String)> {
    let is = |at: usize, signs: &str| {
        tokens.get(at).is_some_and(|token| signs.chars().any(|c| is_punct(token, c)))
    };
    let first =
        [i.checked_sub(2), i.checked_sub(1), Some(i)].into_iter().flatten().find(|at| is(*at, "<>"))?;
    let right = first + 1 + usize::from(is(first + 1, "="));
    let joined = first.checked_sub(2).filter(|at| is(*at, "&|") && is(at + 1, "&|"))?;
    let compared = tokens[..joined].iter().rposition(|token| "<>=!".chars().any(|c| is_punct(token, c)))?;
    let compared = if compared > 0 && is(compared - 1, "<>=!") { compared - 1 } else { compared };
    let ends = |token: &TokenTree| match token {
        TokenTree::Ident(word) => super::words::is_keyword(&word.to_string()),
        TokenTree::Punct(p) => "&|;,=".contains(p.as_char()),
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        TokenTree::Literal(_) => false,
    };
    let start = tokens[..compared].iter().rposition(ends).map_or(0, |at| at + 1);
    let stop = tokens[right..].iter().position(ends).map_or(tokens.len(), |length| right + length);
    let part = |from: usize, to: usize| plain(tokens[from..to].iter().cloned().collect::<TokenStream>());
    let operator: String = tokens[first..right].iter().map(ToString::to_string).collect();
    let message = format!(
        "a comparison has two sides\nhelp: write `{} {operator} {}`",
        part(start, compared),
        part(right, stop)
    );
    Some((&tokens[first..right], message))
}

/// An operator or an `=` without anything behind it.
fn missing(tokens: &[TokenTree], i: usize) -> Option<(&[TokenTree], String)> {
    let at = i.checked_sub(1)?;
    let TokenTree::Punct(last) = &tokens[at] else { return None };
    let is_end = tokens.get(i).is_none_or(|next| is_punct(next, ';') || is_punct(next, ','));
    let message = match last.as_char() {
        operator @ ('*' | '/' | '+' | '-') if is_end => {
            format!(
                "the right side of this `{operator}` is missing\nhelp: write it, or remove the `{operator}`"
            )
        }
        '=' if is_end && at > 0 && is_operand(&tokens[at - 1]) => {
            let none = if tokens[0].to_string() == "V" { "; without a potential write `V = 0;`" } else { "" };
            format!("the value is missing\nhelp: write it behind the `=`{none}")
        }
        _ => return None,
    };
    Some((&tokens[at..i], message))
}

/// A hundredth of this number, as it is written.
pub fn hundredth(number: &str) -> Option<String> {
    let percent: f64 = number.parse().ok()?;
    // Division by a power of ten is correctly rounded, so that the shortest digits are those of the author.
    Some((percent / 100.0).to_string())
}
