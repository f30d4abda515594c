//! Declarations: `m`, `g = 9.81`, `k: [N]`, `theta: angle`, with what other languages write in them.

use super::attributes;
use super::{
    Declaration, KINDS, Kind, START, begins_statement, is_punct, kept, skip, skip_declaration, spelling,
    words,
};
use crate::diagnostics::{Errors, closest, plain};
use proc_macro2::{Delimiter, Ident, Literal, TokenStream, TokenTree};
use quote::ToTokens;
use syn::parse::ParseStream;
use syn::{Attribute, Expr, Token, bracketed};

pub fn declarations(
    input: ParseStream,
    attributes: Vec<Attribute>,
    word: &str,
    errors: &mut Errors,
) -> syn::Result<Vec<Declaration>> {
    let mut declarations = vec![declaration(input, attributes, word, errors)?];
    loop {
        if input.peek(Token![,]) {
            input.parse::<Token![,]>()?;
        } else {
            let rest: Vec<TokenTree> = input.fork().parse::<TokenStream>()?.into_iter().collect();
            let has_value = declarations.last().is_some_and(|last| last.value.is_some());
            match rest.first() {
                Some(TokenTree::Ident(unit)) if has_value && is_unit(unit, rest.get(1)) => {
                    let message = format!(
                        "a number has no unit\nhelp: remove `{unit}`, {UNITS}; another name follows a comma"
                    );
                    errors.push(unit, message);
                    skip_declaration(input)?;
                    continue;
                }
                Some(sign) if "<>".chars().any(|c| is_punct(sign, c)) => {
                    let message = "a declaration has no range of values\nhelp: remove it; a value is given by `m = 1.0`";
                    errors.push(sign, message);
                    skip_declaration(input)?;
                    continue;
                }
                Some(TokenTree::Ident(next)) if !begins_statement(&rest) => {
                    errors.push(next, "expected `,` before this");
                }
                _ => return Ok(declarations),
            }
        }
        if input.is_empty() || input.peek(Token![;]) {
            return Ok(declarations);
        }
        if let Ok(number) = input.fork().parse::<Literal>() {
            let last = declarations.last();
            let whole = last.and_then(|last| last.value.as_ref()).map(plain);
            let (whole, digits) = (whole.unwrap_or_else(|| "1".into()), number.to_string());
            let thousands = match digits.len() {
                3 => format!("; thousands are written without a comma, `{whole}{digits}`"),
                _ => String::new(),
            };
            let message = format!(
                "expected a name, found a number\nhelp: each name has its own value, `{word} a = 1, b = 2;`; a decimal fraction is written with a point, `{whole}.{digits}`{thousands}"
            );
            return Err(syn::Error::new(number.span(), message));
        }
        let attributes = attributes::of_statement(input.call(Attribute::parse_outer)?, kept(word), errors);
        declarations.push(declaration(input, attributes, word, errors)?);
    }
}

/// The help for a number with a unit.
const UNITS: &str = "with all values in units that fit together, such as kg, m and s";

/// Is this word behind a number a unit, before this token?
fn is_unit(word: &Ident, next: Option<&TokenTree>) -> bool {
    spelling::UNITS.contains(&word.to_string().as_str())
        && next.is_none_or(|next| ",;/*^.".chars().any(|c| is_punct(next, c)))
}

/// Refuses the parentheses of `x(0) = 1` and `m(unit = "kg") = 3`, and skips them with a start behind them.
fn no_arguments(input: ParseStream, name: &Ident, word: &str, errors: &mut Errors) -> syn::Result<()> {
    if !input.peek(syn::token::Paren) {
        return Ok(());
    }
    let arguments: TokenTree = input.parse()?;
    let message = match word {
        "coord" => {
            input.parse::<Option<Token![=]>>()?;
            skip_declaration(input)?;
            format!("a coordinate is declared by its name alone\nhelp: write `coord {name};`; {START}")
        }
        "let" => format!("a binding has no arguments\nhelp: a function is `fn {name}(x) = …;`"),
        "param" | "input" | "state" => {
            let what = match word {
                "param" => "a parameter",
                "input" => "an input",
                _ => "a state",
            };
            format!(
                "{what} has no arguments\nhelp: write `{word} {name};` or `{word} {name} = 1.0;`, {UNITS}"
            )
        }
        _ => format!("only functions have arguments\nhelp: write `{word} {name} = …;`"),
    };
    errors.push(arguments, message);
    Ok(())
}

/// The tokens where Rust has a type, read flat: a parser of types would recurse as deep as they are nested. The name of
/// a kind ends them: what follows it in a new line belongs to another statement.
pub fn type_tokens(input: ParseStream) -> syn::Result<TokenStream> {
    let mut tokens = TokenStream::new();
    while !(input.is_empty()
        || input.peek(Token![=])
        || input.peek(Token![,])
        || input.peek(Token![;])
        || input.peek(syn::token::Brace))
    {
        let token: TokenTree = input.parse()?;
        let is_kind = tokens.is_empty() && KINDS.iter().any(|(kind, _)| token.to_string() == *kind);
        tokens.extend([token]);
        if is_kind && input.peek(syn::Ident) {
            break;
        }
    }
    if tokens.is_empty() {
        Err(input.error("expected a kind, `angle`, `length`, `rotation` or `direction`"))
    } else {
        Ok(tokens)
    }
}

pub fn declaration(
    input: ParseStream,
    attributes: Vec<Attribute>,
    word: &str,
    errors: &mut Errors,
) -> syn::Result<Declaration> {
    names_follow(input, word, errors)?;
    words::no_type_before(input, errors)?;
    let name = words::name(input, "expected a name", errors)?;
    no_arguments(input, &name, word, errors)?;
    let (mut kind, mut length) = (Kind::Plain, None);
    let held = word == "input";
    if input.peek(syn::token::Bracket) && matches!(word, "param" | "input" | "coord" | "state" | "let") {
        length = length_or_unit(input, &name, errors)?;
    }
    if input.peek(Token![::]) {
        input.parse::<Token![::]>()?;
        let ty = type_tokens(input)?;
        errors
            .push(ty, "a type has no place here: every number is of the system's own type\nhelp: remove it");
    }
    if matches!(word, "param" | "input" | "state") && input.peek(syn::Lit) {
        let number: Expr = input.parse()?;
        let message = format!("expected `=` before this\nhelp: write `{name} = {}`", plain(&number));
        errors.push(&number, message);
        let value = Some(without_unit(number, errors));
        return Ok(Declaration { attributes, name, kind, length, value, input: held });
    }
    if input.peek(Token![:]) && !input.peek2(Token![=]) {
        if let ("const" | "let" | "observe", Some(value)) = (word, value_behind_colon(input)) {
            let message =
                format!("a value follows `=`, not `:`\nhelp: write `{word} {name} = {};`", plain(&value));
            errors.push(input.parse::<Token![:]>()?, message);
            skip(input)?;
            return Ok(Declaration { attributes, name, kind, length, value: Some(value), input: held });
        }
        input.parse::<Token![:]>()?;
        if input.peek(syn::token::Bracket) {
            let inside;
            bracketed!(inside in input);
            let first: Expr = inside.parse()?;
            length = Some(if inside.is_empty() {
                first
            } else {
                if !inside.peek(Token![;]) {
                    return Err(inside.error(format!("expected one length\nhelp: an array is `{name}: [N]`")));
                }
                inside.parse::<Token![;]>()?;
                kind = kind_of(&first, &format!("an array is `{name}: [N]`"), word, errors);
                inside.parse()?
            });
        } else {
            let ty = type_tokens(input)?;
            if let Some(value) = value_for_type(&ty) {
                let text = plain(&value);
                let message = match word {
                    "coord" => {
                        format!("a number of coordinates is in brackets\nhelp: write `{name}: [{text}]`")
                    }
                    _ => format!("a value follows `=`, not `:`\nhelp: write `{name} = {text}`"),
                };
                errors.push(ty, message);
                let (length, value) = if word == "coord" { (Some(value), None) } else { (None, Some(value)) };
                return Ok(Declaration { attributes, name, kind, length, value, input: held });
            }
            let text = ty.to_token_stream();
            let help = format!("write `{name}` without `: {text}`; an array is `{name}: [N]`");
            kind = kind_of(&ty, &help, word, errors);
        }
    }
    if input.peek(Token![:]) {
        input.parse::<Token![:]>()?;
        return Err(input.error("expected a value"));
    }
    let value = if input.peek(Token![=]) {
        input.parse::<Token![=]>()?;
        Some(without_unit(input.parse()?, errors))
    } else {
        None
    };
    Ok(Declaration { attributes, name, kind, length, value, input: held })
}

/// The value of `observe y: x;`, all that follows the colon, unless it is a type, a length, or one with a value.
fn value_behind_colon(input: ParseStream) -> Option<Expr> {
    let rest: Vec<TokenTree> = input.fork().parse::<TokenStream>().ok()?.into_iter().collect();
    let end = rest.iter().position(|token| is_punct(token, ';')).unwrap_or(rest.len());
    let is_kind = |word: &str| KINDS.iter().any(|(kind, _)| *kind == word);
    let is_type = |token: &TokenTree| match token {
        TokenTree::Group(group) => !group.stream().into_iter().any(|token| is_punct(&token, ',')),
        token => words::is_type(&token.to_string()) || is_kind(&token.to_string()),
    };
    match rest.get(1..end)? {
        [only] if is_type(only) => None,
        value if value.iter().any(|token| is_punct(token, '=')) => None,
        value => syn::parse2(value.iter().cloned().collect()).ok(),
    }
}

/// Refuses what stands between `param` and its names: `param: m, k;`, `param (m, k);`.
fn names_follow(input: ParseStream, word: &str, errors: &mut Errors) -> syn::Result<()> {
    if (input.peek(Token![:]) || input.peek(Token![=])) && input.peek2(syn::Ident) {
        let sign: TokenTree = input.parse()?;
        errors.push(&sign, format!("a name follows `{word}`\nhelp: remove this `{sign}`"));
    }
    if let Ok(TokenTree::Group(group)) = input.fork().parse() {
        let names = plain(group.stream());
        let message = match word {
            "let" => "a binding has one name\nhelp: write `let a = …; let b = …;`".into(),
            "observe" => format!(
                "an output has a name of its own\nhelp: one number is `observe name = …;`, several are `observe name = [{names}];`"
            ),
            _ => format!("names are separated by commas alone\nhelp: write `{word} {names};`"),
        };
        let at = if group.delimiter() == Delimiter::Brace { group.span_open() } else { group.span() };
        return Err(syn::Error::new(at, message));
    }
    Ok(())
}

/// The length of `x[3]`, which is written `x: [3]`; none of `m [kg]`, whose unit is refused.
fn length_or_unit(input: ParseStream, name: &Ident, errors: &mut Errors) -> syn::Result<Option<Expr>> {
    let inside;
    let brackets = bracketed!(inside in input).span;
    let unit = inside.fork().parse::<TokenStream>()?.into_iter().next();
    if let Some(TokenTree::Ident(unit)) = unit
        && spelling::UNITS.contains(&unit.to_string().as_str())
    {
        let rest: TokenStream = inside.parse()?;
        let message = format!("a number has no unit\nhelp: remove `[{}]`, {UNITS}", plain(&rest));
        errors.push(rest, message);
        return Ok(None);
    }
    let length: Expr = inside.parse()?;
    let message = format!("a length follows a colon\nhelp: write `{name}: [{}]`", plain(&length));
    errors.record(syn::Error::new(brackets.join(), message));
    Ok(Some(length))
}

/// The number or the formula that stands where a kind is expected.
fn value_for_type(ty: &TokenStream) -> Option<Expr> {
    let value: Expr = syn::parse2(ty.clone()).ok()?;
    matches!(value, Expr::Lit(_) | Expr::Binary(_) | Expr::Unary(_) | Expr::Call(_) | Expr::MethodCall(_))
        .then_some(value)
}

/// The number of `3 [kg]`, whose unit is refused.
fn without_unit(value: Expr, errors: &mut Errors) -> Expr {
    match value {
        Expr::Index(index) if matches!(&*index.expr, Expr::Lit(_)) => {
            let (number, unit) = (index.expr.to_token_stream(), index.index.to_token_stream());
            errors.push(unit, format!("a number has no unit\nhelp: write `{number}`, {UNITS}"));
            *index.expr
        }
        value => value,
    }
}

/// Units and other words for kinds of coordinates.
const OTHER_KINDS: [(&str, &str); 34] = [
    ("m", "length"),
    ("cm", "length"),
    ("mm", "length"),
    ("um", "length"),
    ("km", "length"),
    ("meter", "length"),
    ("meters", "length"),
    ("metre", "length"),
    ("metres", "length"),
    ("millimeter", "length"),
    ("millimetre", "length"),
    ("position", "length"),
    ("distance", "length"),
    ("displacement", "length"),
    ("translation", "length"),
    ("linear", "length"),
    ("prismatic", "length"),
    ("rad", "angle"),
    ("radian", "angle"),
    ("radians", "angle"),
    ("deg", "angle"),
    ("degree", "angle"),
    ("degrees", "angle"),
    ("rev", "angle"),
    ("turn", "angle"),
    ("angular", "angle"),
    ("revolute", "angle"),
    ("attitude", "rotation"),
    ("orientation", "rotation"),
    ("quaternion", "rotation"),
    ("Quaternion", "rotation"),
    ("Rotation3", "rotation"),
    ("unit_vector", "direction"),
    ("axis", "direction"),
];

/// The tokens after the colon of `name: kind` and `name: [kind; N]`, in the statement that begins with this word.
fn kind_of(at: &impl ToTokens, help: &str, word: &str, errors: &mut Errors) -> Kind {
    let text = at.to_token_stream().to_string();
    let known = KINDS.into_iter().find(|(kind, _)| *kind == text);
    let other = OTHER_KINDS.into_iter().find(|(other, _)| *other == text).map(|(_, meant)| meant);
    let meant = other.or_else(|| closest(&text, KINDS.map(|(kind, _)| kind)));
    let message = match (known, meant) {
        (Some((_, kind)), _) if word == "coord" => return kind,
        (Some((_, Kind::Rotation)), _) if word == "param" => return Kind::Rotation,
        (Some((_, Kind::Rotation)), _) if word == "input" => {
            "an input is a number\nhelp: a rotation that changes is made of angles, `rotation_z(psi) * rotation_x(theta)`; one that does not is a parameter, `param R: rotation`".into()
        }
        (Some(_), _) => format!("only coordinates have a kind\nhelp: {help}"),
        (None, Some(meant)) if word == "coord" => format!(
            "`{text}` is no kind of coordinate; did you mean `{meant}`?\nhelp: kinds are `angle`, `length`, `rotation` and `direction`; a number has no unit: all are in units that fit together, such as kg, m, s and rad"
        ),
        (None, _) if spelling::UNITS.contains(&text.as_str()) => {
            format!("a number has no unit\nhelp: remove `: {text}`, {UNITS}")
        }
        _ => format!("a type has no place here: every number is of the system's own type\nhelp: {help}"),
    };
    errors.push(at, message);
    // The rest is read as if the kind were spelled rightly.
    let meant = meant.filter(|_| word == "coord");
    KINDS.into_iter().find(|(kind, _)| Some(*kind) == meant).map_or(Kind::Plain, |(_, kind)| kind)
}
