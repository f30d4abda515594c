//! Constraints and impulses: `constraint rod: x * x + y * y == l * l;`, `impulse blow at [x, y];`.

use super::{Declaration, Statement, family_follows, skip, words};
use crate::diagnostics::Errors;
use proc_macro2::Ident;
use quote::ToTokens;
use syn::parse::ParseStream;
use syn::{Attribute, BinOp, Expr, Token, bracketed};

/// Reads what follows `constraint`, or `redundant`.
pub fn constraint(
    input: ParseStream,
    keyword: &Ident,
    redundant: bool,
    errors: &mut Errors,
) -> syn::Result<Statement> {
    if redundant && !input.parse::<Ident>().is_ok_and(|word| word == "constraint") {
        return Err(syn::Error::new(keyword.span(), "expected `constraint` after `redundant`"));
    }
    let name = words::name(input, "expected the name of the constraint", errors)?;
    let mut declared = Box::new(Declaration::named(name));
    let sides = if input.parse::<Token![:]>().is_ok() {
        if family_follows(input)? {
            let length;
            bracketed!(length in input);
            declared.length = Some(length.parse()?);
            input.parse::<Token![=]>()?;
            equations(input.parse()?)
        } else {
            equation(input.parse()?)
        }
    } else {
        let message = "expected the name of a constraint and `:`\nhelp: write `constraint rod: x * x + y * y == l * l;`";
        Err(syn::Error::new(declared.name.span(), message))
    };
    let sides = sides.map_err(|error| errors.record(error)).ok();
    if sides.is_none() {
        skip(input)?;
    }
    Ok(Statement::Constraint { declared, sides, redundant })
}

/// Reads what follows `impulse`.
pub fn impulse(
    input: ParseStream,
    attributes: Vec<Attribute>,
    errors: &mut Errors,
) -> syn::Result<Statement> {
    let name = words::name(input, "expected the name of the impulse", errors)?;
    let at = if input.parse::<Ident>().is_ok_and(|at| at == "at") {
        Some(input.parse()?)
    } else {
        let message = "an impulse needs its point of application\nhelp: write `impulse blow at [x, y];`";
        errors.push(&name, message);
        skip(input)?;
        None
    };
    Ok(Statement::Impulse { attributes, name, at })
}

/// Both sides of the `==` of a family of constraints, as closures of the index.
fn equations(family: Expr) -> syn::Result<(Expr, Expr)> {
    let Expr::Closure(closure) = family else {
        let message = "the constraints of a family are given by their index\nhelp: write `constraint rods: [N] = |i| … == …;`";
        return Err(syn::Error::new_spanned(family, message));
    };
    let (left, right) = equation((*closure.body).clone())?;
    let side = |body| Expr::Closure(syn::ExprClosure { body: Box::new(body), ..closure.clone() });
    Ok((side(left), side(right)))
}

/// Both sides of the `==` of a constraint.
fn equation(whole: Expr) -> syn::Result<(Expr, Expr)> {
    let (at, message) = match &whole {
        Expr::Binary(syn::ExprBinary { op: BinOp::Eq(_), .. }) => {
            let Expr::Binary(binary) = whole else { unreachable!("matched above") };
            return Ok((*binary.left, *binary.right));
        }
        Expr::Binary(syn::ExprBinary { op, .. })
            if matches!(op, BinOp::Lt(_) | BinOp::Le(_) | BinOp::Gt(_) | BinOp::Ge(_) | BinOp::Ne(_)) =>
        {
            let message = "a constraint is an equation\nhelp: a stop or a contact is an event of the integration, where an impulse acts";
            (op.to_token_stream(), message)
        }
        Expr::Assign(assign) => (
            assign.eq_token.to_token_stream(),
            "nothing is assigned in a constraint\nhelp: an equation is `f == g`",
        ),
        Expr::Binary(syn::ExprBinary { op: op @ BinOp::And(_), .. }) => (
            op.to_token_stream(),
            "a constraint is one equation\nhelp: write two constraints, or an equation of arrays, `[x, y] == [y, z]`",
        ),
        other => (
            other.to_token_stream(),
            "a constraint is an equation\nhelp: if this is to vanish, write `… == 0`",
        ),
    };
    Err(syn::Error::new_spanned(at, message))
}
