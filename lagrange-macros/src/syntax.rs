//! The language as written: statements between the braces of `system Name { … }`, each ended by `;`.
//!
//! ```text
//! const N = 8;                                   compile-time integer
//! param m, g = 9.81, k: [N];                     parameters, with optional lengths and defaults
//! input u, tau: [N];                             inputs: held in a step, changed between steps; 0 by default
//! coord theta: angle, x: [N];                    generalized coordinates, with optional kinds and lengths
//! coord phi = omega * t;                         prescribed coordinate
//! state i: [M] = 0.0;                            states of first order, with optional lengths and initial values
//! rate(i) = …;                                   their rates
//! fn gust(s) = a * (-s * s).exp();               named function
//! extern fn mu(t);                               function of the user's, generic over the scalar
//! extern wind: Curve(t);                         function with data: a field of this type
//! let y = -l * theta.cos();                      kinematics; `let y: [N] = |i| …;` a family
//! T = …;  V = …;   or   L = …;                   energies
//! D = …;                                         Rayleigh dissipation function
//! Q[theta] = …;                                  generalized force
//! force [fx, fy] at [x, y];                      applied force, by virtual work
//! couple [mx, my, mz] on link;                   applied couple, in the axes of a frame
//! constraint rod: x * x + y * y == l * l;        constraint on positions, or on velocities
//! constraint rods: [N] = |i| x[i] == y[i];       a family of constraints
//! redundant constraint c: x == y;                a constraint that may follow from others
//! impulse blow at [x, y];                        where impulses act
//! observe tip = [x, y];                          named output
//! event ground: y, falling, terminal;            where a function passes zero
//! routhian Reduced;                              the system without its ignorable coordinates, as a second type
//! restriction Planar: phi = 0;                   the system on an invariant set, as a type of its own
//! simplified Small: lock x = 0, neglect m;       a system with simpler energies, likewise
//! ```
//!
//! Expressions are Rust expressions. One bad statement does not hide the others: parsing resumes after its `;`.

mod attributes;
pub mod characters;
pub mod choices;
mod constraints;
mod declarations;
mod events;
mod forces;
mod functions;
mod limits;
pub mod notation;
pub mod signs;
pub mod spelling;
mod submodels;
pub mod words;

use crate::diagnostics::{Errors, closest, plain};
use attributes::Kept;
use declarations::{declaration, declarations};
pub use events::Direction;
use proc_macro2::{Delimiter, Ident, Punct, Spacing, Span, TokenStream, TokenTree};
pub use submodels::{Change, Expansion, Move, Submodel};
use syn::ext::IdentExt;
use syn::parse::{ParseStream, Parser};
use syn::{Attribute, Expr, Token, Type, Visibility, bracketed};

/// `pub system Name { statements }`
pub struct Definition {
    /// Path of the runtime crate, as the user's crate sees it.
    pub runtime: TokenStream,
    pub header: Header,
    pub statements: Vec<Statement>,
}

/// The head of a generated type.
#[derive(Clone)]
pub struct Header {
    pub attributes: Vec<Attribute>,
    pub visibility: Visibility,
    pub name: Ident,
}

impl Header {
    pub fn is_public(&self) -> bool {
        matches!(self.visibility, Visibility::Public(_))
    }
}

/// `name`, `name: kind`, `name: [length]`, `name: [kind; length]`, each also with `= value`.
#[derive(Clone)]
pub struct Declaration {
    pub attributes: Vec<Attribute>,
    pub name: Ident,
    pub kind: Kind,
    pub length: Option<Expr>,
    pub value: Option<Expr>,
    /// Declared by `input`, so that it may change between steps.
    pub input: bool,
}

impl Declaration {
    /// A name alone.
    pub fn named(name: Ident) -> Declaration {
        let (kind, attributes) = (Kind::Plain, Vec::new());
        Declaration { attributes, name, kind, length: None, value: None, input: false }
    }
}

/// The quantity that a coordinate measures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    Angle,
    Length,
    /// An attitude in space, of three coordinates.
    Rotation,
    /// A point of the unit sphere, by its three components.
    Direction,
    #[default]
    Plain,
    /// The time integral of a state of first order, which has no name.
    State,
}

impl Kind {
    /// Coordinates that one of this kind has.
    pub fn coordinates(self) -> usize {
        if matches!(self, Kind::Rotation | Kind::Direction) { 3 } else { 1 }
    }
}

/// The words for the kinds of coordinates.
const KINDS: [(&str, Kind); 4] = [
    ("angle", Kind::Angle),
    ("length", Kind::Length),
    ("rotation", Kind::Rotation),
    ("direction", Kind::Direction),
];

#[derive(Clone)]
pub enum Statement {
    Const(Declaration),
    Param(Vec<Declaration>),
    Coord(Vec<Declaration>),
    /// `state name = initial value`
    State(Vec<Declaration>),
    Let(Declaration),
    Function {
        name: Ident,
        arguments: Vec<Ident>,
        body: Expr,
    },
    Extern {
        name: Ident,
        arguments: Vec<Ident>,
        data: Option<Data>,
    },
    /// `T`, `V`, `L` or `D`
    Energy {
        keyword: Ident,
        value: Expr,
    },
    /// `Q[coordinate] = value`, or `rate(state) = value`
    Applied {
        keyword: Ident,
        coordinate: Expr,
        value: Expr,
    },
    Force {
        force: Expr,
        at: Expr,
    },
    /// `couple M on frame`
    Couple {
        couple: Expr,
        on: Expr,
    },
    Observe(Declaration),
    /// `constraint name: left == right`, or `constraint name: [N] = |i| left == right`, whose sides are closures of
    /// the index; without sides where they could not be read, which has been reported.
    Constraint {
        declared: Box<Declaration>,
        sides: Option<(Expr, Expr)>,
        /// May it follow from others?
        redundant: bool,
    },
    /// `impulse name at point`; likewise.
    Impulse {
        attributes: Vec<Attribute>,
        name: Ident,
        at: Option<Expr>,
    },
    /// `event name: function, options`
    Event(Event),
    /// `routhian Name`
    Routhian(Header),
    /// `restriction Name: moves`, `simplified Name: moves`
    Submodel(Submodel),
    /// The words of a statement that could not be read; the error has been reported.
    Unread(Vec<Ident>),
}

impl Statement {
    /// Parameters and inputs that it declares.
    pub fn parameters(&self) -> &[Declaration] {
        if let Statement::Param(list) = self { list } else { &[] }
    }

    /// Coordinates that it declares, prescribed ones among them.
    pub fn coordinates(&self) -> &[Declaration] {
        if let Statement::Coord(list) = self { list } else { &[] }
    }

    /// States of first order that it declares.
    pub fn states(&self) -> &[Declaration] {
        if let Statement::State(list) = self { list } else { &[] }
    }
}

/// The field that holds the data of a function.
#[derive(Clone)]
pub struct Data {
    pub attributes: Vec<Attribute>,
    pub ty: Type,
}

/// A function of the state whose roots are events.
#[derive(Clone)]
pub struct Event {
    pub attributes: Vec<Attribute>,
    pub name: Ident,
    /// None where it could not be read, which has been reported.
    pub value: Option<Expr>,
    /// The length of a family that stands in its place.
    pub length: Option<Expr>,
    pub direction: Direction,
    pub terminal: bool,
}

impl Event {
    /// The name of its constant.
    pub fn constant(&self) -> String {
        self.name.to_string().to_uppercase()
    }
}

/// Words that begin a statement, with what they may be mistaken for.
const STATEMENTS: [&str; 19] = [
    "const",
    "param",
    "input",
    "coord",
    "state",
    "rate",
    "let",
    "fn",
    "extern",
    "force",
    "couple",
    "observe",
    "event",
    "constraint",
    "redundant",
    "impulse",
    "routhian",
    "restriction",
    "simplified",
];
const ENERGIES: [&str; 4] = ["T", "V", "L", "D"];
/// Letters that other books use: of Landau and Lifshitz, and of lectures.
const OTHER_LETTERS: [(&str, &str); 12] = [
    ("U", "V"),
    ("Ep", "V"),
    ("Epot", "V"),
    ("E_p", "V"),
    ("E_pot", "V"),
    ("PE", "V"),
    ("K", "T"),
    ("Ek", "T"),
    ("Ekin", "T"),
    ("E_k", "T"),
    ("E_kin", "T"),
    ("KE", "T"),
];

/// Words that other languages have for statements.
const OTHER_WORDS: [(&str, &str); 9] = [
    ("variable", "coord"),
    ("variables", "coord"),
    ("var", "coord"),
    ("dof", "coord"),
    ("function", "fn"),
    ("def", "fn"),
    ("output", "observe"),
    ("control", "input"),
    ("controls", "input"),
];
/// The help for the start of a motion.
const START: &str =
    "where a motion starts is said when it is integrated, `State::new(t, [q, …], [velocity, …])`";

/// Reads `@crate [path] attributes visibility system Name { … }`. The header may be known even where the rest is not.
pub fn parse(input: TokenStream, errors: &mut Errors) -> Option<Definition> {
    let parser = |input: ParseStream| {
        input.parse::<Token![@]>()?;
        input.parse::<Token![crate]>()?;
        let path;
        bracketed!(path in input);
        let runtime: TokenStream = path.parse()?;
        let header = header(input, errors)?;
        if !input.peek(syn::token::Brace) {
            let rest: Vec<TokenTree> = input.fork().parse::<TokenStream>()?.into_iter().collect();
            let name = match &rest[..] {
                [TokenTree::Ident(word), ..] => format!("{}{word}", header.name),
                [hyphen, TokenTree::Ident(word), ..] if is_punct(hyphen, '-') => {
                    format!("{}{word}", header.name)
                }
                _ => header.name.to_string(),
            };
            let message = format!(
                "expected `{{ … }}`\nhelp: a definition is `system {name} {{ coord …; T = …; V = …; }}`"
            );
            errors.record(input.error(message));
            input.parse::<TokenStream>()?;
            return Ok((runtime, header, None));
        }
        let body;
        let braces = syn::braced!(body in input).span;
        let body: TokenStream = body.parse()?;
        // What is left without them means something else.
        let is_read = !braces
            .join()
            .source_text()
            .is_some_and(|text| characters::check(&text, braces.open().start(), &body, errors));
        if !input.is_empty() {
            let message = "one system to a `lagrangian!`\nhelp: put this into a macro call of its own";
            errors.record(input.error(message));
            input.parse::<TokenStream>()?;
        }
        Ok((runtime, header, is_read.then_some(body)))
    };
    match parser.parse2(input) {
        Ok((runtime, header, body)) => {
            let statements = match body {
                Some(body) => statements(body, errors),
                None => vec![Statement::Unread(Vec::new())],
            };
            Some(Definition { runtime, header, statements })
        }
        Err(error) => {
            errors.record(error);
            None
        }
    }
}

fn header(input: ParseStream, errors: &mut Errors) -> syn::Result<Header> {
    let written: TokenStream = input.fork().parse()?;
    let is_body = |t: &TokenTree| matches!(t, TokenTree::Group(g) if g.delimiter() == Delimiter::Brace);
    let before: Vec<TokenTree> = written.into_iter().take_while(|t| !is_body(t)).collect();
    limits::check(&before).map_err(|error| {
        let message = "what stands before the braces of a system is nested too deeply, or too long\nhelp: put attributes that need this in front of `lagrangian!`";
        syn::Error::new(error.span(), message)
    })?;
    let attributes = attributes::of_system(input.call(Attribute::parse_outer)?, errors);
    let visibility = input.parse()?;
    let start = "expected `system Name { … }`\nhelp: a definition begins `pub system Pendulum { param …; coord …; T = …; V = …; }`";
    let Ok(keyword) = input.call(Ident::parse_any) else { return Err(input.error(start)) };
    if keyword != "system" {
        let error = syn::Error::new(keyword.span(), start);
        if !input.peek(syn::Ident) {
            return Err(error);
        }
        errors.record(error);
    }
    let name = type_name(input, errors)?;
    if input.peek(Token![<]) {
        let generics: syn::Generics = input.parse()?;
        let message = "a system has no generics of its own\nhelp: every system is generic over its numbers already; a length is `const N = …;` inside the braces";
        errors.push(generics, message);
    }
    Ok(Header { attributes, visibility, name })
}

/// The name of a system.
fn type_name(input: ParseStream, errors: &mut Errors) -> syn::Result<Ident> {
    let name = words::name(input, "expected the name of the system", errors)?;
    let text = name.to_string();
    let reason = match text.as_str() {
        "S" => "every system calls the type of its numbers so",
        _ if words::is_primitive(&text) => "this is a type of Rust",
        _ => return Ok(name),
    };
    // What follows is read as that of a system with another name.
    errors.push(&name, format!("a system cannot be called `{name}`: {reason}\nhelp: choose another name"));
    Ok(Ident::new(&format!("Named{}", text.to_uppercase()), name.span()))
}

const COMMA: &str = "a statement ends in `;`\nhelp: write `;` instead of `,`";

/// Splits the body at its semicolons and reads each statement by itself.
fn statements(body: TokenStream, errors: &mut Errors) -> Vec<Statement> {
    let mut statements = Vec::new();
    let mut current = Vec::new();
    for token in body {
        let end = is_punct(&token, ';');
        current.push(token);
        if end {
            read(std::mem::take(&mut current), &mut statements, errors);
        }
    }
    let is_end = matches!(&current[..], [TokenTree::Ident(word)] if word == "end");
    let is_block = is_end
        || current.len() > 1
            && matches!(current.last(), Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace)
            && words::statement_of_rust(&current[0].to_string()).is_some();
    if is_block {
        // There is no such statement, which is an error already.
        let mut semicolon = Punct::new(';', Spacing::Alone);
        semicolon.set_span(end(&current[current.len() - 1]));
        current.push(semicolon.into());
        read(current, &mut statements, errors);
    } else if let Some(last) = current.last().map(end) {
        let comma = current.pop_if(|last| is_punct(last, ',')).is_some();
        errors.record(syn::Error::new(last, if comma { COMMA } else { "expected `;` after this" }));
        let mut semicolon = Punct::new(';', Spacing::Alone);
        semicolon.set_span(last);
        current.push(semicolon.into());
        read(current, &mut statements, errors);
    }
    statements
}

/// Reads the tokens of a statement with its `;`: of several statements, where one was forgotten.
fn read(mut tokens: Vec<TokenTree>, statements: &mut Vec<Statement>, errors: &mut Errors) {
    if let Err(error) = limits::check(&tokens) {
        errors.record(error);
        return statements.push(Statement::Unread(words(tokens)));
    }
    if !spelling::check(&tokens, errors) {
        return statements.push(Statement::Unread(words(tokens)));
    }
    loop {
        let parser = |input: ParseStream| Ok((statement(input, errors), input.parse::<TokenStream>()?));
        let (found, rest) = match parser.parse2(tokens.iter().cloned().collect()) {
            Ok((Ok(statement), rest)) => (statement, rest),
            Ok((Err(error), _)) | Err(error) => {
                let known =
                    notation::explained(&error, &tokens).or_else(|| words::keyword_at(&error, &tokens));
                errors.record(known.unwrap_or_else(|| with_form(error, &tokens[0])));
                return statements.push(Statement::Unread(words(tokens)));
            }
        };
        statements.push(found);
        let rest: Vec<TokenTree> = rest.into_iter().collect();
        let read = tokens.len() - rest.len();
        match rest.first() {
            None => return,
            Some(semicolon) if rest.len() == 1 && is_punct(semicolon, ';') => return,
            Some(_) if read > 0 && (begins_statement(&rest) || assigns(&rest)) => {
                errors.record(syn::Error::new(end(&tokens[read - 1]), "expected `;` after this"));
                tokens = rest;
            }
            Some(comma) if is_punct(comma, ',') && begins_statement(&rest[1..]) => {
                errors.push(comma, COMMA);
                tokens = rest[1..].to_vec();
            }
            Some(other) => {
                let is_value = matches!(tokens[..read].last(), Some(TokenTree::Ident(_)))
                    && !tokens[..read].iter().any(|token| is_punct(token, '='));
                let declared = ["const", "let", "observe"].iter().any(|word| tokens[0].to_string() == *word);
                if is_value && declared {
                    errors.record(with_form(
                        syn::Error::new(other.span(), "expected `=` before this"),
                        &tokens[0],
                    ));
                } else if let [comma, name @ TokenTree::Ident(_), equals, ..] = rest.as_slice()
                    && is_punct(comma, ',')
                    && is_punct(equals, '=')
                    && declared
                {
                    let message = format!(
                        "each has a statement of its own\nhelp: write `{} {name} = …;`, behind `;`",
                        tokens[0]
                    );
                    errors.push(name, message);
                } else if let [comma, word, ..] = rest.as_slice()
                    && is_punct(comma, ',')
                    && word.to_string() == "redundant"
                {
                    let message = "`redundant` stands before the word `constraint`\nhelp: write `redundant constraint name: …;`";
                    errors.push(word, message);
                } else if let Some((at, message)) = notation::meant(&tokens, read) {
                    errors.push(at.iter().cloned().collect::<TokenStream>(), message);
                } else {
                    errors.push(other, "expected an operator or `;` before this\nhelp: a product is `a * b`");
                }
                // Half of an expression would give errors of its own.
                use Statement::{Applied, Const, Couple, Energy, Event, Force, Let, Observe};
                if let Some(
                    Energy { .. }
                    | Applied { .. }
                    | Force { .. }
                    | Couple { .. }
                    | Const(_)
                    | Let(_)
                    | Observe(_)
                    | Event(_),
                ) = statements.last()
                {
                    statements.pop();
                    statements.push(Statement::Unread(words(tokens)));
                }
                return;
            }
        }
    }
}

/// An error of the parser's own, with the form of the statement.
fn with_form(error: syn::Error, keyword: &TokenTree) -> syn::Error {
    let message = error.to_string();
    let form = match keyword.to_string().as_str() {
        "const" => "const N = 8;",
        "param" => "param m, g = 9.81, k: [N];",
        "input" => "input u, tau: [N];",
        "coord" => "coord theta, x: [N];",
        "state" => "state i = 0.0, z: [N];",
        "rate" => "rate(i) = …;",
        "routhian" | "pub" => "pub routhian Reduced;",
        "restriction" => "pub restriction Planar: phi = 0;",
        "simplified" => "pub simplified Small: expand theta to 2 about 0;",
        "let" => "let y = …;",
        "fn" => "fn name(x) = …;",
        "extern" => "extern fn name(t);`, or for a function with data `extern name: Curve(t);",
        "T" => "T = …;",
        "V" => "V = …;",
        "L" => "L = …;",
        "D" => "D = …;",
        "Q" => "Q[theta] = …;",
        "force" => "force [fx, fy] at [x, y];",
        "couple" => "couple [mx, my, mz] on link;",
        "observe" => "observe name = …;",
        "event" => "event ground: y, falling, terminal;",
        "constraint" => "constraint name: f == 0;",
        "redundant" => "redundant constraint name: f == 0;",
        "impulse" => "impulse name at [x, y];",
        _ => return error,
    };
    if message.contains("help:") {
        return error;
    }
    syn::Error::new(error.span(), format!("{message}\nhelp: the form of this statement is `{form}`"))
}

fn is_punct(token: &TokenTree, c: char) -> bool {
    matches!(token, TokenTree::Punct(p) if p.as_char() == c)
}

/// The end of a token.
fn end(token: &TokenTree) -> Span {
    match token {
        TokenTree::Group(group) => group.span_close(),
        other => other.span(),
    }
}

/// The identifiers among tokens.
fn words(tokens: impl IntoIterator<Item = TokenTree>) -> Vec<Ident> {
    let mut all = Vec::new();
    let mut rest: Vec<TokenTree> = tokens.into_iter().collect();
    while let Some(token) = rest.pop() {
        match token {
            TokenTree::Ident(word) => all.push(word),
            TokenTree::Group(group) => rest.extend(group.stream()),
            _ => {}
        }
    }
    all
}

fn begins_statement(tokens: &[TokenTree]) -> bool {
    let Some(TokenTree::Ident(word)) = tokens.first() else { return false };
    match (word.to_string().as_str(), tokens.get(1)) {
        ("T" | "V" | "L" | "D", Some(next)) => is_punct(next, '='),
        ("Q", Some(TokenTree::Group(group))) => group.delimiter() == Delimiter::Bracket,
        ("pub", Some(_)) => true,
        (word, Some(TokenTree::Ident(_) | TokenTree::Group(_))) => STATEMENTS.contains(&word),
        _ => false,
    }
}

/// `y = …`: after an operand, this is another statement.
fn assigns(tokens: &[TokenTree]) -> bool {
    match tokens {
        [TokenTree::Ident(_), TokenTree::Punct(p), ..] => p.as_char() == '=' && p.spacing() == Spacing::Alone,
        _ => false,
    }
}

fn statement(input: ParseStream, errors: &mut Errors) -> syn::Result<Statement> {
    let attributes = input.call(Attribute::parse_outer)?;
    let visibility: Visibility = input.parse()?;
    let Ok(keyword) = input.call(Ident::parse_any) else {
        return Err(input.error(no_statement(input)));
    };
    let text = known_keyword(&keyword, input, errors)?;
    if text == "routhian" {
        let attributes = attributes::of_system(attributes, errors);
        let name = type_name(input, errors)?;
        if input.peek(Token![:]) || input.peek(syn::token::Brace) {
            let message =
                format!("a Routhian leaves out each ignorable coordinate\nhelp: write `routhian {name};`");
            return Err(input.error(message));
        }
        return Ok(Statement::Routhian(Header { attributes, visibility, name }));
    }
    if let "restriction" | "simplified" = text {
        let attributes = attributes::of_system(attributes, errors);
        let header = Header { attributes, visibility, name: type_name(input, errors)? };
        return Ok(Statement::Submodel(submodels::submodel(header, text == "restriction", input)?));
    }
    if visibility != Visibility::Inherited {
        let message = "only a type has a visibility\nhelp: remove it; parameters and outputs are public";
        errors.push(visibility, message);
    }
    let attributes = attributes::of_statement(attributes, kept(text), errors);
    Ok(match text {
        "const" => Statement::Const(declaration(input, attributes, text, errors)?),
        "param" | "input" => Statement::Param(declarations(input, attributes, text, errors)?),
        "coord" => Statement::Coord(declarations(input, attributes, text, errors)?),
        "state" => Statement::State(declarations(input, attributes, text, errors)?),
        "observe" => Statement::Observe(declaration(input, attributes, text, errors)?),
        "event" => Statement::Event(events::event(input, attributes, errors)?),
        "let" => {
            if let Some(mutable) = input.parse::<Option<Token![mut]>>()? {
                errors.push(mutable, "nothing is assigned to a binding later\nhelp: remove `mut`");
            }
            Statement::Let(declaration(input, attributes, text, errors)?)
        }
        "fn" => functions::function(input, errors)?,
        "extern" => functions::external(input, attributes, errors)?,
        "Q" => forces::generalized(input, keyword)?,
        "rate" => forces::rate(input, &keyword)?,
        "force" => forces::force(input, &keyword)?,
        "couple" => forces::couple(input, &keyword)?,
        "constraint" | "redundant" => constraints::constraint(input, &keyword, text == "redundant", errors)?,
        "impulse" => constraints::impulse(input, attributes, errors)?,
        energy => {
            equals(input, energy)?;
            Statement::Energy { keyword: Ident::new(energy, keyword.span()), value: input.parse()? }
        }
    })
}

/// The message for a statement that does not begin with a word.
fn no_statement(input: ParseStream) -> String {
    let is_comment = input.peek(Token![%])
        || input.peek(Token![-])
        || input.peek(syn::LitStr)
        || input.peek(syn::token::Paren);
    let help = if is_comment {
        "\nhelp: a comment begins with `//`"
    } else if input.peek(Token![;]) {
        "\nhelp: remove this `;`"
    } else if input.peek(Token![@]) {
        "\nhelp: parameters are declared by `param m, k;`, coordinates by `coord x;`"
    } else {
        ""
    };
    format!("expected a statement, such as `coord theta;` or `T = …;`{help}")
}

/// Passes over the rest of a statement.
fn skip(input: ParseStream) -> syn::Result<()> {
    while !input.is_empty() && !input.peek(Token![;]) {
        input.parse::<TokenTree>()?;
    }
    Ok(())
}

/// Skips the rest of a declaration in a list of them.
fn skip_declaration(input: ParseStream) -> syn::Result<()> {
    while !(input.is_empty() || input.peek(Token![,]) || input.peek(Token![;])) {
        input.parse::<TokenTree>()?;
    }
    Ok(())
}

/// Returns whether `[N] = |i| …` follows.
fn family_follows(input: ParseStream) -> syn::Result<bool> {
    let ahead = input.fork();
    if !ahead.peek(syn::token::Bracket) {
        return Ok(false);
    }
    ahead.parse::<TokenTree>()?;
    Ok(ahead.peek(Token![=]) && !ahead.peek(Token![==]))
}

/// Destination of the attributes of a statement that begins with this word.
fn kept(word: &str) -> Kept {
    match word {
        "param" | "input" | "extern" => Kept::OnField,
        "observe" | "impulse" | "event" => Kept::OnFunction,
        _ => Kept::Nowhere,
    }
}

/// The keyword as it was meant, so that what follows can be read.
fn known_keyword(keyword: &Ident, input: ParseStream, errors: &mut Errors) -> syn::Result<&'static str> {
    let text = keyword.to_string();
    let known = || STATEMENTS.into_iter().chain(ENERGIES).chain(["Q"]);
    if let Some(exact) = known().find(|k| *k == text) {
        return Ok(exact);
    }
    let equals = input.peek(Token![=]) && !input.peek(Token![==]);
    let letter =
        OTHER_LETTERS.into_iter().find(|(other, _)| equals && *other == text).map(|(_, meant)| meant);
    let small = text.to_lowercase();
    let word = || OTHER_WORDS.into_iter().find(|(other, _)| *other == small).map(|(_, meant)| meant);
    let meant = letter.or_else(|| if equals { None } else { word().or_else(|| closest(&small, STATEMENTS)) });
    if let Some(message) = rate_by_dot(&text, input) {
        return Err(syn::Error::new(keyword.span(), message));
    }
    let other = words::statement_of_rust(&text)
        .or_else(|| words::statement_elsewhere(&text).filter(|_| !equals))
        .or_else(|| meant.is_none().then(|| words::equation(input))?);
    if let Some(message) = other {
        return Err(syn::Error::new(keyword.span(), message));
    }
    let rest: Vec<TokenTree> = input.fork().parse::<TokenStream>()?.into_iter().collect();
    if let [first, second, ..] = &rest[..]
        && (is_punct(first, ':') && is_punct(second, '=') || is_punct(first, '<') && is_punct(second, '-'))
    {
        let help = match ENERGIES.contains(&text.as_str()) {
            true => format!("write `{text} = …;`"),
            false => format!("a definition is `let {text} = …;`"),
        };
        let message = format!("`{text}` does not begin a statement\nhelp: {help}");
        return Err(syn::Error::new(keyword.span(), message));
    }
    if let (None, Some(message)) = (meant, value_of_name(&text, &rest)) {
        return Err(syn::Error::new(keyword.span(), message));
    }
    let hint = meant.map_or(String::new(), |meant| format!("; did you mean `{meant}`?"));
    let help = if let (Some(meant), false) = (meant, equals) {
        format!("write `{meant}`")
    } else if let (true, Some(coordinate)) = (equals, force_along(&text)) {
        let dissipation = if text == "F" { ", Rayleigh's dissipation function is `D = …;`" } else { "" };
        format!(
            "the force along a coordinate is `Q[{coordinate}] = …;`{dissipation}; any other name is defined by `let {text} = …;`"
        )
    } else if equals && text == "t" {
        "`t` is time; energies have capital letters, `T = …;`".into()
    } else if equals && ["H", "E"].contains(&text.as_str()) {
        format!(
            "the total energy is the function `energy` of the system; any other name is defined by `let {text} = …;`"
        )
    } else if equals {
        format!(
            "energies are `T`, `V` and `D`, or a whole `L`; any other name is defined by `let {text} = …;`"
        )
    } else {
        "statements are `param`, `input`, `coord`, `state`, `rate(…) =`, `const`, `let`, `fn`, `extern fn`, `T =`, `V =`, `L =`, `D =`, `Q[…] =`, `force … at`, `couple … on`, `constraint`, `redundant constraint`, `impulse … at`, `observe`, `event`, `routhian`, `restriction`, `simplified`".to_string()
    };
    let error =
        syn::Error::new(keyword.span(), format!("`{text}` does not begin a statement{hint}\nhelp: {help}"));
    match meant {
        Some(meant) => {
            errors.record(error);
            Ok(meant)
        }
        None => Err(error),
    }
}

/// The message for a statement `dot(z) = …`.
fn rate_by_dot(word: &str, input: ParseStream) -> Option<String> {
    let rest: Vec<TokenTree> = input.fork().parse::<TokenStream>().ok()?.into_iter().collect();
    let ("dot", [TokenTree::Group(argument), equals, ..]) = (word, &rest[..]) else { return None };
    is_punct(equals, '=').then(|| {
        let name = plain(argument.stream());
        format!(
            "`dot` does not begin a statement\nhelp: the rate of a state (`state {name};`) is `rate({name}) = …;`; accelerations of coordinates follow from the energies"
        )
    })
}

/// The message for a statement `x = 1`, `x(0) = 1`, `f(x) = …` or `a, b = …`.
fn value_of_name(name: &str, rest: &[TokenTree]) -> Option<String> {
    let is_literal = |tokens: &[TokenTree]| match tokens {
        [minus, TokenTree::Literal(_), ..] => is_punct(minus, '-'),
        tokens => matches!(tokens, [TokenTree::Literal(_), ..]),
    };
    match rest {
        [equals, value @ ..]
            if is_punct(equals, '=')
                && is_literal(value)
                && value.len() <= 2 + usize::from(is_punct(&value[0], '-'))
                && force_along(name).is_none() =>
        {
            Some(format!(
                "`{name}` does not begin a statement\nhelp: a value is given by `param {name} = …;` or `let {name} = …;`; {START}"
            ))
        }
        [TokenTree::Group(argument), equals, ..] if is_punct(equals, '=') => {
            let is_force = name == "F" && argument.delimiter() == Delimiter::Bracket;
            let argument: Vec<TokenTree> = argument.stream().into_iter().collect();
            Some(match is_literal(&argument) {
                _ if is_force => format!(
                    "`{name}` does not begin a statement\nhelp: the force along a coordinate is `Q[{}] = …;`",
                    plain(argument.into_iter().collect::<TokenStream>())
                ),
                true => format!("a system does not say where its motion starts\nhelp: {START}"),
                false => format!(
                    "`{name}` does not begin a statement\nhelp: a function is `fn {name}({}) = …;`",
                    plain(argument.into_iter().collect::<TokenStream>())
                ),
            })
        }
        [comma, TokenTree::Ident(other), ..] if is_punct(comma, ',') => Some(format!(
            "`{name}` does not begin a statement\nhelp: parameters are declared by `param {name}, {other};`, coordinates by `coord {name}, {other};`"
        )),
        _ => None,
    }
}

/// The coordinate that a name such as `Q_x`, `Fx` or `F` says a force acts along.
fn force_along(name: &str) -> Option<&str> {
    let index = name.strip_prefix(['Q', 'F'])?;
    match index.strip_prefix('_') {
        Some(coordinate) if !coordinate.is_empty() => Some(coordinate),
        None if index.is_empty() => Some("x"),
        None if index.chars().count() == 1 => Some(index),
        _ => None,
    }
}

fn equals(input: ParseStream, after: &str) -> syn::Result<()> {
    if input.peek(Token![+=]) || input.peek(Token![-=]) {
        let message = format!(
            "nothing is added to `{after}` later\nhelp: write all terms in one statement, `{after} = … + …;`"
        );
        return Err(input.error(message));
    }
    let wrong = match (input.peek(Token![==]), input.peek(Token![=])) {
        (false, true) => return input.parse::<Token![=]>().map(drop),
        (true, _) => "`==` compares",
        _ => "expected `=`",
    };
    Err(input.error(format!("{wrong}\nhelp: write `{after} = …;`")))
}
