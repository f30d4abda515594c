//! Systems that are derived from another one: `restriction Planar: phi = 0;` holds coordinates,
//! `simplified Small: lock x = 0, neglect m2;` changes energies.

use super::Header;
use crate::diagnostics::{closest, plain};
use proc_macro2::{Ident, TokenStream, TokenTree};
use quote::ToTokens;
use syn::parse::ParseStream;
use syn::{Expr, Token};

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
    let mut moves = Vec::new();
    loop {
        let before: Vec<TokenTree> = input.fork().parse::<TokenStream>()?.into_iter().collect();
        let change = if exact { hold(input)? } else { change(input)? };
        let left = input.fork().parse::<TokenStream>()?.into_iter().count();
        let read = before.len() - left;
        moves.push(Move { tokens: before.into_iter().take(read).collect(), change });
        if !input.peek(Token![,]) {
            break;
        }
        input.parse::<Token![,]>()?;
        if input.is_empty() || input.peek(Token![;]) {
            break;
        }
    }
    Ok(Submodel { header, exact, moves })
}

fn forms() -> String {
    MOVES.map(|(_, form)| format!("`{form}`")).join(", ")
}

/// A move by its word.
fn change(input: ParseStream) -> syn::Result<Change> {
    let start = input.fork();
    let Ok(word) = input.parse::<Ident>() else {
        return Err(input.error(format!("expected a move\nhelp: moves are {}", forms())));
    };
    let text = word.to_string();
    match text.as_str() {
        "lock" => hold(input),
        "neglect" => {
            let name = input.parse::<Ident>().map_err(|error| {
                let message = "expected the name of a parameter or of a `let`, `dissipation` or `gyroscopic`\nhelp: name a term, `let coupling = …;`, and write `neglect coupling`";
                syn::Error::new(error.span(), message)
            })?;
            Ok(Change::Neglect(name))
        }
        "expand" => {
            let form =
                "write `expand theta to 2 about 0`, or of several at once `expand [theta, phi] to 2 about 0`";
            let coordinates = input.parse()?;
            follows(input, "to", "the order of the energies", form)?;
            let order = input.parse()?;
            follows(input, "about", "the values of the coordinates", form)?;
            Ok(Change::Expand(Box::new(Expansion { coordinates, order, about: input.parse()? })))
        }
        "inertia" => {
            follows(input, "at", "the place of the inertia matrix", "write `inertia at theta = 0`")?;
            let [coordinates, values] = held(input)?;
            Ok(Change::Inertia { coordinates, values })
        }
        "quasistatic" => Ok(Change::Quasistatic(input.parse()?)),
        "average" => Ok(Change::Average(input.parse()?)),
        _ => {
            let hint = closest(&text, MOVES.map(|(word, _)| word))
                .map_or(String::new(), |word| format!("; did you mean `{word}`?"));
            let equals = start.parse::<Expr>().is_ok_and(|e| matches!(e, Expr::Assign(_)));
            let help = match equals {
                true => format!("a coordinate that is held is `lock {text} = …`"),
                false => format!("moves are {}", forms()),
            };
            Err(syn::Error::new(word.span(), format!("`{text}` is no move{hint}\nhelp: {help}")))
        }
    }
}

/// The word between two parts of a move.
fn follows(input: ParseStream, word: &str, what: &str, form: &str) -> syn::Result<()> {
    let found = input.fork().parse::<Ident>();
    if !found.is_ok_and(|found| found == word) {
        return Err(input.error(format!("expected `{word}` and {what}\nhelp: {form}")));
    }
    input.parse::<Ident>().map(drop)
}

fn hold(input: ParseStream) -> syn::Result<Change> {
    held(input).map(|[coordinate, value]| Change::Hold { coordinate, value })
}

/// `coordinate = value`
fn held(input: ParseStream) -> syn::Result<[Expr; 2]> {
    let whole: Expr = input.parse()?;
    match whole {
        Expr::Assign(assign) => Ok([*assign.left, *assign.right]),
        other => {
            let target = match &other {
                Expr::Binary(binary) => plain(&binary.left),
                other => plain(other),
            };
            let message =
                format!("expected a coordinate and the value that it is held at\nhelp: write `{target} = 0`");
            Err(syn::Error::new_spanned(other.to_token_stream(), message))
        }
    }
}
