//! Events: `event ground: y - r, falling, terminal;`.

use super::{Event, family_follows, is_punct, skip, skip_declaration, words};
use crate::diagnostics::{Errors, did_you_mean, plain};
use proc_macro2::{Ident, TokenTree};
use syn::ext::IdentExt;
use syn::parse::ParseStream;
use syn::{Attribute, BinOp, Expr, Token, bracketed};

/// Direction of the roots that count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
    Rising,
    Falling,
    #[default]
    Either,
}

/// Words that may follow the function of an event.
pub const OPTIONS: [&str; 3] = ["rising", "falling", "terminal"];

/// Words that other languages have for them.
const OTHER_OPTIONS: [(&str, &str); 10] = [
    ("up", "rising"),
    ("increasing", "rising"),
    ("positive", "rising"),
    ("down", "falling"),
    ("decreasing", "falling"),
    ("negative", "falling"),
    ("stop", "terminal"),
    ("end", "terminal"),
    ("final", "terminal"),
    ("isterminal", "terminal"),
];

/// Reads what follows `event`.
pub fn event(input: ParseStream, attributes: Vec<Attribute>, errors: &mut Errors) -> syn::Result<Event> {
    let name = words::name(input, "expected the name of the event", errors)?;
    let mut event =
        Event { attributes, name, value: None, length: None, direction: Direction::Either, terminal: false };
    let name = &event.name;
    if OPTIONS.contains(&name.to_string().as_str()) && input.peek(Ident::peek_any) {
        let message = format!(
            "an option stands behind the function of an event\nhelp: write `event ground: y, {name};`"
        );
        return Err(syn::Error::new(name.span(), message));
    }
    let Ok(sign) = input.parse::<TokenTree>() else {
        let message = format!("an event needs its function\nhelp: write `event {name}: y;`");
        return Err(syn::Error::new(name.span(), message));
    };
    if is_punct(&sign, '=') {
        errors.push(&sign, format!("a colon follows the name of an event\nhelp: write `event {name}: …;`"));
    } else if !is_punct(&sign, ':') {
        errors.push(&event.name, format!("expected `:` after this\nhelp: write `event {name}: y;`"));
        skip(input)?;
        return Ok(event);
    }
    let equals = if family_follows(input)? {
        let length;
        bracketed!(length in input);
        event.length = Some(length.parse()?);
        Some(input.parse::<Token![=]>()?)
    } else {
        None
    };
    let value: Expr = input.parse()?;
    let mut directed = None;
    while input.peek(Token![,]) {
        input.parse::<Token![,]>()?;
        if input.is_empty() || input.peek(Token![;]) {
            break;
        }
        option(input, &mut event, &mut directed, errors)?;
    }
    match (&event.length, equals) {
        (Some(length), Some(equals)) => {
            errors.push(equals, family(&event, length, &value));
        }
        _ => event.value = function(&event, directed, value, errors),
    }
    Ok(event)
}

/// The message for `event hit: [N] = |i| …;`: events of an index are an array of functions.
fn family(event: &Event, length: &Expr, value: &Expr) -> String {
    let functions = match value {
        Expr::Closure(of) => {
            format!("(0..{}).map(|{}| {})", plain(length), plain(&of.inputs), plain(&of.body))
        }
        _ => plain(value),
    };
    let options = options(event.direction, event.terminal);
    format!(
        "events have no family: an array of functions is an array of events\nhelp: write `event {}: {functions}{options};`",
        event.name
    )
}

/// The options of an event as they are written.
fn options(direction: Direction, terminal: bool) -> String {
    let direction = match direction {
        Direction::Either => "",
        Direction::Falling => ", falling",
        Direction::Rising => ", rising",
    };
    format!("{direction}{}", if terminal { ", terminal" } else { "" })
}

/// The function of an event with these options, unless a comparison stands in its place.
fn function(event: &Event, directed: Option<Direction>, value: Expr, errors: &mut Errors) -> Option<Expr> {
    if let Expr::Assign(equation) = &value {
        let comparison = Expr::Binary(syn::ExprBinary {
            attrs: Vec::new(),
            left: equation.left.clone(),
            op: BinOp::Eq(Token![==](equation.eq_token.span)),
            right: equation.right.clone(),
        });
        return function(event, directed, comparison, errors);
    }
    let Expr::Binary(comparison) = &value else { return Some(value) };
    let meant = match comparison.op {
        BinOp::Eq(_) | BinOp::Ne(_) => Direction::Either,
        BinOp::Lt(_) | BinOp::Le(_) => Direction::Falling,
        BinOp::Gt(_) | BinOp::Ge(_) => Direction::Rising,
        _ => return Some(value),
    };
    let options = options(directed.unwrap_or(meant), event.terminal);
    let (left, right) = (plain(&comparison.left), plain(&comparison.right));
    let difference = match &*comparison.right {
        Expr::Lit(_) if right.trim_end_matches('0').trim_end_matches('.').is_empty() => left,
        Expr::Binary(_) => format!("{left} - ({right})"),
        _ => format!("{left} - {right}"),
    };
    let message = format!(
        "an event is where a function passes zero, and this is a condition\nhelp: write `event {}: {difference}{options};`",
        event.name
    );
    errors.push(comparison.op, message);
    None
}

/// `rising`, `falling` or `terminal`.
fn option(
    input: ParseStream,
    event: &mut Event,
    directed: &mut Option<Direction>,
    errors: &mut Errors,
) -> syn::Result<()> {
    let help = "options of an event are `rising` or `falling`, and `terminal`: `event ground: y, falling, terminal;`";
    let Ok(word) = input.call(Ident::parse_any) else {
        let other: TokenTree = input.parse()?;
        errors.push(other, format!("expected an option\nhelp: {help}"));
        return skip_declaration(input);
    };
    let text = word.to_string();
    if (input.peek(Token![=]) || input.peek(Token![:])) && OPTIONS.contains(&text.as_str()) {
        let sign: TokenTree = input.parse()?;
        errors.push(sign, format!("an option of an event has no value\nhelp: write `{text}` alone"));
        return skip_declaration(input);
    }
    let direction = match text.as_str() {
        "rising" => Direction::Rising,
        "falling" => Direction::Falling,
        "terminal" if event.terminal => {
            errors.push(word, "`terminal` is written twice\nhelp: remove one of them");
            return Ok(());
        }
        "terminal" => {
            event.terminal = true;
            return Ok(());
        }
        other => {
            let small = other.to_lowercase();
            let known = OTHER_OPTIONS.iter().find(|(other, _)| *other == small);
            let hint = match known {
                Some((_, meant)) => format!("; did you mean `{meant}`?"),
                None => did_you_mean(&small, OPTIONS),
            };
            let help = match other {
                "either" | "both" => "an event without a direction is one of both: remove this",
                _ => help,
            };
            errors.push(word, format!("`{text}` is no option of an event{hint}\nhelp: {help}"));
            return skip_declaration(input);
        }
    };
    match directed {
        Some(before) if *before == direction => {
            errors.push(word, format!("`{text}` is written twice\nhelp: remove one of them"));
        }
        Some(_) => {
            errors.push(
                word,
                "an event has one direction\nhelp: one of both directions has neither `rising` nor `falling`",
            );
        }
        None => (event.direction, *directed) = (direction, Some(direction)),
    }
    Ok(())
}
