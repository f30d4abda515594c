//! Systems that are derived from another one: `restriction Planar: phi = 0;` holds coordinates,
//! `simplified Small: lock x = 0, neglect m2;` changes energies.

use super::Header;
use crate::diagnostics::{closest, plain};
use proc_macro2::{Ident, TokenStream, TokenTree};
use quote::ToTokens;
use syn::ext::IdentExt;
use syn::parse::ParseStream;
use syn::{Expr, Token, token};

/// A second type, and the moves that lead to it.
#[derive(Clone)]
pub struct Submodel {
    pub header: Header,
    /// Is it a restriction, which has to be proved?
    pub exact: bool,
    pub moves: Vec<Move>,
}

/// One of the changes that make a system smaller, with its tokens.
#[derive(Clone)]
pub struct Move {
    pub tokens: TokenStream,
    pub change: Change,
}

#[derive(Clone)]
pub enum Change {
    /// `coordinate = value`, `lock coordinate = value`
    Hold { coordinate: Expr, value: Expr },
    /// `neglect name`
    Neglect(Ident),
    /// `expand coordinates to order about values`
    Expand(Box<Expansion>),
    /// `inertia at coordinates = values`
    Inertia { coordinates: Expr, values: Expr },
    /// `quasistatic coordinates`
    Quasistatic(Expr),
    /// `average phase`
    Average(Expr),
}

/// `coordinates to order about values`
#[derive(Clone)]
pub struct Expansion {
    pub coordinates: Expr,
    pub order: Expr,
    pub about: Expr,
}

impl Change {
    /// The coordinates that leave.
    pub fn removed(&self) -> Option<&Expr> {
        match self {
            Change::Hold { coordinate, .. } | Change::Quasistatic(coordinate) => Some(coordinate),
            _ => None,
        }
    }
}

/// The moves, with their forms.
const MOVES: [(&str, &str); 6] = [
    ("lock", "lock x = 0"),
    ("neglect", "neglect name"),
    ("expand", "expand theta to 2 about 0"),
    ("inertia", "inertia at theta = 0"),
    ("quasistatic", "quasistatic x"),
    ("average", "average omega * t"),
];

/// Words of books and other languages for these moves.
const OTHER_WORDS: [(&str, &str); 21] = [
    ("hold", "lock"),
    ("held", "lock"),
    ("fix", "lock"),
    ("fixed", "lock"),
    ("freeze", "lock"),
    ("rigid", "lock"),
    ("drop", "neglect"),
    ("ignore", "neglect"),
    ("omit", "neglect"),
    ("remove", "neglect"),
    ("without", "neglect"),
    ("linearize", "expand"),
    ("linearise", "expand"),
    ("linear", "expand"),
    ("small", "expand"),
    ("taylor", "expand"),
    ("static", "quasistatic"),
    ("massless", "quasistatic"),
    ("condense", "quasistatic"),
    ("mean", "average"),
    ("averaged", "average"),
];

/// The move that a word means, under its own name or another one, with its form.
fn meant(word: &str) -> Option<(&'static str, &'static str)> {
    let other = OTHER_WORDS.iter().find(|(other, _)| *other == word);
    let own = other.map_or(word, |(_, own)| own);
    MOVES.into_iter().find(|(name, _)| *name == own)
}

/// Reads what follows the name of the type.
pub fn submodel(header: Header, exact: bool, input: ParseStream) -> syn::Result<Submodel> {
    let name = &header.name;
    if !input.peek(Token![:]) {
        let message = match exact {
            true => format!(
                "a restriction says which coordinates are held\nhelp: write `restriction {name}: phi = 0;`, with as many as there are"
            ),
            false => format!(
                "a simplified system says what is simplified\nhelp: write `simplified {name}: {};`, with as many moves as there are; they are {}",
                MOVES[0].1,
                forms()
            ),
        };
        return Err(syn::Error::new(name.span(), message));
    }
    input.parse::<Token![:]>()?;
    let mut moves: Vec<Move> = Vec::new();
    loop {
        let before: Vec<TokenTree> = input.fork().parse::<TokenStream>()?.into_iter().collect();
        let change = match exact {
            true => restricted(input, name, &moves)?,
            false => change(input, moves.last())?,
        };
        let left = input.fork().parse::<TokenStream>()?.into_iter().count();
        let read = before.len() - left;
        separated(input, &before[..read], exact)?;
        moves.push(Move { tokens: before.into_iter().take(read).collect(), change });
        if !input.peek(Token![,]) {
            break;
        }
        input.parse::<Token![,]>()?;
        if is_end(input) {
            break;
        }
    }
    Ok(Submodel { header, exact, moves })
}

/// Does nothing more follow in this move?
fn is_end(input: ParseStream) -> bool {
    input.is_empty() || input.peek(Token![;]) || input.peek(Token![,])
}

/// Refuses what follows a move without a comma, unless it goes on with an expression, in which other rules know what
/// is missing.
fn separated(input: ParseStream, read: &[TokenTree], exact: bool) -> syn::Result<()> {
    if is_end(input) {
        return Ok(());
    }
    let rest: Vec<TokenTree> = input.fork().parse::<TokenStream>()?.into_iter().collect();
    if super::begins_statement(&rest) {
        return Ok(());
    }
    let word = rest[0].to_string();
    let follows = matches!(&rest[..], [_, TokenTree::Ident(_), ..]);
    if super::assigns(&rest) || meant(&word).is_some() && follows || word == "and" {
        let parts = if exact { "coordinates that are held" } else { "moves" };
        return Err(input.error(format!("expected `,` before this\nhelp: {parts} are separated by commas")));
    }
    let form = match meant(&read[0].to_string()) {
        Some((_, form)) if !exact => form,
        _ => "x = 0",
    };
    let of_places = ["at", "about", "to", "over", "around"].contains(&word.as_str());
    let takes_no_value = matches!(&read[0], TokenTree::Ident(word) if word == "quasistatic");
    if of_places || takes_no_value || rest[0].to_string() == "=" {
        let message = format!("expected `,` or `;` before this\nhelp: the form is `{form}`");
        return Err(input.error(message));
    }
    Ok(())
}

fn forms() -> String {
    MOVES.map(|(_, form)| format!("`{form}`")).join(", ")
}

/// A coordinate that a restriction holds: a restriction has no other moves, and no words for them.
fn restricted(input: ParseStream, name: &Ident, before: &[Move]) -> syn::Result<Change> {
    let ahead = input.fork();
    let word = ahead.call(Ident::parse_any);
    if let Ok(word) = word
        && let Some((own, form)) = meant(&word.to_string())
        && (ahead.peek(Ident::peek_any) || ahead.peek(token::Bracket) && !indexes(&ahead))
    {
        let rest: Vec<TokenTree> = ahead.parse::<TokenStream>()?.into_iter().collect();
        let of_this = rest.iter().take_while(|token| !",;".contains(&token.to_string()));
        let rest = plain(of_this.cloned().collect::<TokenStream>());
        let message = if own == "lock" {
            let held = if rest.contains('=') { rest } else { format!("{rest} = 0") };
            format!(
                "a restriction holds coordinates without the word `{word}`\nhelp: write `{held}`, or, where motions leave this set, `simplified {name}: lock {held};`"
            )
        } else {
            let held = before.iter().map(|m| format!("lock {}, ", plain(&m.tokens)));
            let held: String = held.collect();
            let this = if word == own { format!("{word} {rest}") } else { form.into() };
            format!(
                "`{word}` is no word of a restriction, which holds coordinates and is exact: moves that change energies are those of `simplified`\nhelp: write `simplified {name}: {held}{this};`"
            )
        };
        return Err(syn::Error::new(word.span(), message));
    }
    hold(input, "")
}

/// Do brackets and `=` follow, as behind the name of an array of coordinates?
fn indexes(input: ParseStream) -> bool {
    let ahead = input.fork();
    ahead.parse::<TokenTree>().is_ok() && ahead.peek(Token![=])
}

/// A move by its word, after another one.
fn change(input: ParseStream, before: Option<&Move>) -> syn::Result<Change> {
    let start = input.fork();
    let Ok(word) = input.call(Ident::parse_any) else {
        return Err(input.error(format!("expected a move\nhelp: moves are {}", forms())));
    };
    let text = word.to_string();
    match text.as_str() {
        "lock" => hold(input, "lock "),
        "neglect" => neglect(input),
        "expand" => {
            let form =
                "write `expand theta to 2 about 0`, or of several at once `expand [theta, phi] to 2 about 0`";
            let coordinates = operand(input, "the coordinates of the expansion", form)?;
            follows(input, "to", "the order of the energies", form)?;
            let order = operand(input, "the order of the energies", form)?;
            follows(input, "about", "the values of the coordinates", form)?;
            let about = operand(input, "the values of the coordinates", form)?;
            Ok(Change::Expand(Box::new(Expansion { coordinates, order, about })))
        }
        "inertia" => {
            follows(input, "at", "the place of the inertia matrix", "write `inertia at theta = 0`")?;
            let [coordinates, values] = held(input, "inertia at ")?;
            Ok(Change::Inertia { coordinates, values })
        }
        "quasistatic" => {
            let whole = expression(input, "the coordinates that follow", "write `quasistatic x`")?;
            let Expr::Assign(assign) = &whole else { return Ok(Change::Quasistatic(whole)) };
            let (left, right) = (plain(&assign.left), plain(&assign.right));
            let message = format!(
                "the value of `{left}` follows from statics\nhelp: write `quasistatic {left}`, or hold it by `lock {left} = {right}`"
            );
            Err(syn::Error::new_spanned(whole, message))
        }
        "average" => {
            let form = "write `average omega * t`, with the rate of the sines and cosines of the motion";
            if input.peek(Ident::peek_any)
                && input.peek2(Ident::peek_any)
                && input.fork().parse::<Ident>()? == "over"
            {
                return Err(input.error(format!("the phase stands behind `average`\nhelp: {form}")));
            }
            Ok(Change::Average(operand(input, "the phase of a fast motion", form)?))
        }
        _ => {
            let equals = start.parse::<Expr>().is_ok_and(|e| matches!(e, Expr::Assign(_)));
            let again = before.map(|m| &m.change).filter(|_| is_end(input));
            let close = closest(&text, MOVES.map(|(word, _)| word)).and_then(meant);
            let (hint, help) = match (meant(&text).or(close), again) {
                _ if equals && matches!(before.map(|m| &m.change), Some(Change::Inertia { .. })) => (
                    String::new(),
                    format!("at a place of several coordinates it is `inertia at [theta, {text}] = [0, …]`"),
                ),
                _ if equals => (String::new(), format!("a coordinate that is held is `lock {text} = …`")),
                (Some((word, form)), _) => (format!("; did you mean `{word}`?"), format!("write `{form}`")),
                (None, Some(Change::Neglect(_))) => {
                    (String::new(), format!("each term has a move of its own, `neglect {text}`"))
                }
                (None, Some(Change::Quasistatic(other))) => {
                    (String::new(), format!("write `quasistatic [{}, {text}]`", plain(other)))
                }
                (None, _) => (String::new(), format!("moves are {}", forms())),
            };
            Err(syn::Error::new(word.span(), format!("`{text}` is no move{hint}\nhelp: {help}")))
        }
    }
}

/// `neglect name`
fn neglect(input: ParseStream) -> syn::Result<Change> {
    if let Ok(Expr::Array(list)) = input.fork().parse::<Expr>() {
        let each = list.elems.iter().map(|name| format!("`neglect {}`", plain(name)));
        let message = format!(
            "one term is neglected by a move\nhelp: write a move for each, {}",
            each.collect::<Vec<_>>().join(", ")
        );
        return Err(syn::Error::new_spanned(list, message));
    }
    let name = input.parse::<Ident>().map_err(|error| {
        let message = "expected the name of a parameter or of a `let`, `dissipation` or `gyroscopic`\nhelp: name a term, `let coupling = …;`, and write `neglect coupling`";
        syn::Error::new(error.span(), message)
    })?;
    if input.peek(Token![=]) && !input.peek(Token![==]) {
        return Err(input.error(format!("a term that is neglected is 0\nhelp: write `neglect {name}`")));
    }
    let rest: Vec<TokenTree> = input.fork().parse::<TokenStream>()?.into_iter().collect();
    let is_operator = matches!(rest.first(), Some(TokenTree::Punct(_) | TokenTree::Group(_)));
    if !is_end(input) && is_operator && !super::begins_statement(&rest) {
        let message = "a term is neglected by its name, and this is an expression\nhelp: name it, `let small = …;`, write `small` in the energy, and `neglect small`";
        return Err(input.error(message));
    }
    Ok(Change::Neglect(name))
}

/// A part of a move; `x = 0` is none.
fn operand(input: ParseStream, what: &str, form: &str) -> syn::Result<Expr> {
    let found = expression(input, what, form)?;
    match found {
        Expr::Assign(assign) => {
            let message = format!("expected {what} alone\nhelp: {form}");
            Err(syn::Error::new_spanned(assign, message))
        }
        found => Ok(found),
    }
}

fn expression(input: ParseStream, what: &str, form: &str) -> syn::Result<Expr> {
    if is_end(input) {
        return Err(input.error(format!("expected {what}\nhelp: {form}")));
    }
    input.parse()
}

/// The word between two parts of a move.
fn follows(input: ParseStream, word: &str, what: &str, form: &str) -> syn::Result<()> {
    let found = input.fork().parse::<Ident>();
    if !found.is_ok_and(|found| found == word) {
        return Err(input.error(format!("expected `{word}` and {what}\nhelp: {form}")));
    }
    input.parse::<Ident>().map(drop)
}

fn hold(input: ParseStream, word: &str) -> syn::Result<Change> {
    held(input, word).map(|[coordinate, value]| Change::Hold { coordinate, value })
}

/// `coordinate = value` behind a word.
fn held(input: ParseStream, word: &str) -> syn::Result<[Expr; 2]> {
    let what = match word {
        "inertia at " => "a coordinate and its value",
        _ => "a coordinate and the value that it is held at",
    };
    let ahead = input.fork();
    let first = ahead.parse::<Ident>();
    let second = ahead.parse::<Ident>();
    if let (Ok(first), Ok(second)) = (&first, second) {
        // `x at 0`, or a word before the coordinate.
        let preposition = ["at", "to", "is", "as"].iter().any(|word| second == word);
        let target = if preposition { first } else { &second };
        let message = format!("expected {what}\nhelp: write `{word}{target} = 0`");
        return Err(syn::Error::new(first.span(), message));
    }
    let whole = expression(input, what, &format!("write `{word}x = 0`"))?;
    match bare(whole) {
        Expr::Assign(assign) => Ok([bare(*assign.left), *assign.right]),
        other => {
            let target = match &other {
                Expr::Binary(binary) => plain(&binary.left),
                other => plain(other),
            };
            let several = match input.peek(Token![,]) && input.peek2(Ident::peek_any) && first.is_ok() {
                true => format!(", of several at once `{word}[{target}, …] = 0`"),
                false => String::new(),
            };
            let message = format!("expected {what}\nhelp: write `{word}{target} = 0`{several}");
            Err(syn::Error::new_spanned(other.to_token_stream(), message))
        }
    }
}

/// The expression in parentheses.
fn bare(expression: Expr) -> Expr {
    match expression {
        Expr::Paren(inside) => bare(*inside.expr),
        other => other,
    }
}
