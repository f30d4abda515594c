//! The language as written: statements between the braces of `system Name { … }`, each ended by `;`.
//!
//! ```text
//! const N = 8;                                   compile-time integer
//! param m, g = 9.81, k: [N];                     parameters, with optional lengths and defaults
//! coord theta, x: [N];                           generalized coordinates
//! coord phi = omega * t;                         prescribed coordinate
//! fn gust(s) = a * (-s * s).exp();               named function
//! extern fn mu(t);                               function of the user's, generic over the scalar
//! let y = -l * theta.cos();                      kinematics; `let y: [N] = |i| …;` a family
//! T = …;  V = …;   or   L = …;                   energies
//! D = …;                                         Rayleigh dissipation function
//! Q[theta] = …;                                  generalized force
//! force [fx, fy] at [x, y];                      applied force, by virtual work
//! observe tip = [x, y];                          named output
//! ```
//!
//! Expressions are Rust expressions. One bad statement does not hide the others: parsing resumes after its `;`.

mod limits;

use crate::diagnostics::{Errors, did_you_mean};
use proc_macro2::{Ident, TokenStream, TokenTree};
use syn::parse::{Parse, ParseStream, Parser};
use syn::{Attribute, Expr, Token, Visibility, bracketed, parenthesized, punctuated::Punctuated};

/// `pub system Name { statements }`
pub struct Definition {
    /// Path of the runtime crate, as the user's crate sees it.
    pub runtime: TokenStream,
    pub header: Header,
    pub statements: Vec<Statement>,
}

/// What comes before the braces, all that the fallback expansion needs.
pub struct Header {
    pub attributes: Vec<Attribute>,
    pub visibility: Visibility,
    pub name: Ident,
}

/// `name`, `name: [length]`, `name = value`, `name: [length] = value`
pub struct Declaration {
    pub attributes: Vec<Attribute>,
    pub name: Ident,
    pub length: Option<Expr>,
    pub value: Option<Expr>,
}

pub enum Statement {
    Const(Declaration),
    Param(Vec<Declaration>),
    Coord(Vec<Declaration>),
    Let(Declaration),
    Function {
        name: Ident,
        arguments: Vec<Ident>,
        body: Expr,
    },
    Extern {
        name: Ident,
        arguments: Vec<Ident>,
    },
    /// `T`, `V`, `L` or `D`
    Energy {
        keyword: Ident,
        value: Expr,
    },
    /// `Q[coordinate] = value`
    Applied {
        keyword: Ident,
        coordinate: Expr,
        value: Expr,
    },
    Force {
        keyword: Ident,
        force: Expr,
        at: Expr,
    },
    Observe(Declaration),
    Constraint {
        name: Ident,
    },
}

const STATEMENTS: [&str; 9] =
    ["const", "param", "coord", "let", "fn", "extern", "force", "observe", "constraint"];

/// Reads `@crate [path] attributes visibility system Name { … }`. The header may be known even where the rest is not.
pub fn parse(input: TokenStream, errors: &mut Errors) -> Option<Definition> {
    let parser = |input: ParseStream| {
        input.parse::<Token![@]>()?;
        input.parse::<Token![crate]>()?;
        let path;
        bracketed!(path in input);
        let runtime: TokenStream = path.parse()?;
        let header = Header::parse(input)?;
        let body;
        syn::braced!(body in input);
        let body: TokenStream = body.parse()?;
        if !input.is_empty() {
            return Err(input.error("one system per `lagrangian!`: put this into a macro call of its own"));
        }
        Ok((runtime, header, body))
    };
    match parser.parse2(input) {
        Ok((runtime, header, body)) => {
            let statements = statements(body, errors);
            Some(Definition { runtime, header, statements })
        }
        Err(error) => {
            errors.record(error);
            None
        }
    }
}

impl Parse for Header {
    fn parse(input: ParseStream) -> syn::Result<Header> {
        let attributes = input.call(Attribute::parse_outer)?;
        let visibility = input.parse()?;
        let keyword: Option<Ident> = input.parse().ok();
        if keyword.as_ref().is_none_or(|k| k != "system") {
            let message = "expected `system Name { … }`\nhelp: a definition begins `pub system Pendulum { param …; coord …; T = …; V = …; }`";
            return Err(keyword.map_or_else(|| input.error(message), |k| syn::Error::new(k.span(), message)));
        }
        let name = input.parse()?;
        Ok(Header { attributes, visibility, name })
    }
}

/// Splits the body at its semicolons and reads each statement by itself.
fn statements(body: TokenStream, errors: &mut Errors) -> Vec<Statement> {
    let mut statements = Vec::new();
    let mut current = Vec::new();
    let mut read = |tokens: Vec<TokenTree>, errors: &mut Errors| {
        if let Err(error) = limits::check(&tokens) {
            errors.record(error);
            return;
        }
        match statement.parse2(tokens.into_iter().collect()) {
            Ok(statement) => statements.push(statement),
            Err(error) => drop(errors.record(error)),
        }
    };
    for token in body {
        match &token {
            TokenTree::Punct(p) if p.as_char() == ';' => read(std::mem::take(&mut current), errors),
            _ => current.push(token),
        }
    }
    if let Some(last) = current.last() {
        errors.push(last, "expected `;` after this statement");
        read(current, errors);
    }
    statements
}

fn statement(input: ParseStream) -> syn::Result<Statement> {
    let attributes = input.call(Attribute::parse_outer)?;
    let look = input.lookahead1();
    let statement = if input.peek(Token![const]) {
        input.parse::<Token![const]>()?;
        Statement::Const(declaration(input, attributes)?)
    } else if input.peek(Token![let]) {
        input.parse::<Token![let]>()?;
        if input.peek(Token![mut]) {
            return Err(
                input.error("a binding is a definition, nothing is assigned to it later: remove `mut`")
            );
        }
        Statement::Let(declaration(input, attributes)?)
    } else if input.peek(Token![fn]) {
        input.parse::<Token![fn]>()?;
        let (name, arguments) = signature(input)?;
        if !input.peek(Token![=]) {
            return Err(input.error(format!("expected `=`\nhelp: write `fn {name}(x) = expression;`")));
        }
        input.parse::<Token![=]>()?;
        Statement::Function { name, arguments, body: input.parse()? }
    } else if input.peek(Token![extern]) {
        input.parse::<Token![extern]>()?;
        input.parse::<Token![fn]>()?;
        let (name, arguments) = signature(input)?;
        Statement::Extern { name, arguments }
    } else if look.peek(syn::Ident) {
        let keyword: Ident = input.parse()?;
        let text = keyword.to_string();
        match text.as_str() {
            "param" => Statement::Param(declarations(input, attributes)?),
            "coord" => Statement::Coord(declarations(input, attributes)?),
            "observe" => Statement::Observe(declaration(input, attributes)?),
            "T" | "V" | "L" | "D" if input.peek(Token![=]) => {
                input.parse::<Token![=]>()?;
                Statement::Energy { keyword, value: input.parse()? }
            }
            "Q" if input.peek(syn::token::Bracket) => {
                let coordinate;
                bracketed!(coordinate in input);
                let coordinate = coordinate.parse()?;
                input.parse::<Token![=]>()?;
                Statement::Applied { keyword, coordinate, value: input.parse()? }
            }
            "Q" => {
                let message = "expected the coordinate of the generalized force\nhelp: write `Q[theta] = …;`";
                return Err(syn::Error::new(keyword.span(), message));
            }
            "force" => {
                let force = input.parse()?;
                match input.parse::<Ident>() {
                    Ok(at) if at == "at" => {}
                    Ok(other) => {
                        return Err(syn::Error::new(
                            other.span(),
                            "expected `at` and the point of application",
                        ));
                    }
                    Err(_) => {
                        let message =
                            "a force needs its point of application\nhelp: write `force [fx, fy] at [x, y];`";
                        return Err(syn::Error::new(keyword.span(), message));
                    }
                }
                Statement::Force { keyword, force, at: input.parse()? }
            }
            "constraint" => {
                let name = input.parse().unwrap_or(keyword);
                input.parse::<TokenStream>()?;
                Statement::Constraint { name }
            }
            _ => {
                let hint = did_you_mean(&text, STATEMENTS);
                let message = format!(
                    "`{text}` does not begin a statement{hint}\nhelp: statements are `param`, `coord`, `const`, `let`, `fn`, `extern fn`, `T =`, `V =`, `L =`, `D =`, `Q[…] =`, `force … at`, `observe`"
                );
                return Err(syn::Error::new(keyword.span(), message));
            }
        }
    } else {
        return Err(input.error("expected a statement, such as `coord theta;` or `T = …;`"));
    };
    if !input.is_empty() {
        return Err(input.error("expected `;` before this"));
    }
    Ok(statement)
}

fn signature(input: ParseStream) -> syn::Result<(Ident, Vec<Ident>)> {
    let name = input.parse()?;
    let arguments;
    parenthesized!(arguments in input);
    let arguments = Punctuated::<Ident, Token![,]>::parse_terminated(&arguments)?;
    Ok((name, arguments.into_iter().collect()))
}

fn declarations(input: ParseStream, attributes: Vec<Attribute>) -> syn::Result<Vec<Declaration>> {
    let mut declarations = vec![declaration(input, attributes)?];
    while input.peek(Token![,]) {
        input.parse::<Token![,]>()?;
        if input.is_empty() {
            break;
        }
        let attributes = input.call(Attribute::parse_outer)?;
        declarations.push(declaration(input, attributes)?);
    }
    Ok(declarations)
}

fn declaration(input: ParseStream, attributes: Vec<Attribute>) -> syn::Result<Declaration> {
    let name: Ident = input.parse()?;
    let mut length = None;
    if input.peek(Token![:]) {
        input.parse::<Token![:]>()?;
        if !input.peek(syn::token::Bracket) {
            return Err(input
                .error(format!("expected a length\nhelp: scalars have no type; an array is `{name}: [N]`")));
        }
        let inside;
        bracketed!(inside in input);
        length = Some(inside.parse()?);
        if !inside.is_empty() {
            return Err(inside.error(format!("expected one length, as in `{name}: [N]`")));
        }
    }
    let value = if input.peek(Token![=]) {
        input.parse::<Token![=]>()?;
        Some(input.parse()?)
    } else {
        None
    };
    Ok(Declaration { attributes, name, length, value })
}
