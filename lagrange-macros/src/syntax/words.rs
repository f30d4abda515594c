//! Names that a system may give, and words of Rust that it may not.

use crate::diagnostics::Errors;
use proc_macro2::{Delimiter, Ident, TokenStream, TokenTree};
use syn::ext::IdentExt;
use syn::parse::ParseStream;

/// Keywords of Rust, of all editions and reserved ones.
pub const KEYWORDS: [&str; 52] = [
    "Self", "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "crate", "do",
    "dyn", "else", "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in", "let", "loop",
    "macro", "match", "mod", "move", "mut", "override", "priv", "pub", "ref", "return", "self", "static",
    "struct", "super", "trait", "true", "try", "type", "typeof", "unsafe", "unsized", "use", "virtual",
    "where", "while", "yield",
];

/// The help for functions that choose.
pub const CHOICE: &str = "a number that depends on a condition is `if x < 0 { … } else { … }`";
/// The help for functions that jump.
pub const PERIODIC: &str = "functions that jump everywhere are not part of the language; a periodic function is made of `sin` and `cos`, such as `sin(2 * PI * t)`";

/// Greek letters with their names.
pub const GREEK: [(char, &str); 24] = [
    ('α', "alpha"),
    ('β', "beta"),
    ('γ', "gamma"),
    ('δ', "delta"),
    ('ε', "epsilon"),
    ('ζ', "zeta"),
    ('η', "eta"),
    ('θ', "theta"),
    ('κ', "kappa"),
    ('λ', "lambda"),
    ('μ', "mu"),
    ('ν', "nu"),
    ('ξ', "xi"),
    ('π', "pi"),
    ('ρ', "rho"),
    ('σ', "sigma"),
    ('τ', "tau"),
    ('φ', "phi"),
    ('χ', "chi"),
    ('ψ', "psi"),
    ('ω', "omega"),
    ('Ω', "Omega"),
    ('Φ', "Phi"),
    ('Θ', "Theta"),
];

/// Types of Rust that need no path; emitted code says them.
pub const PRIMITIVES: [&str; 19] = [
    "bool", "char", "f16", "f32", "f64", "f128", "i8", "i16", "i32", "i64", "i128", "isize", "str", "u8",
    "u16", "u32", "u64", "u128", "usize",
];

pub fn is_primitive(name: &str) -> bool {
    PRIMITIVES.contains(&name)
}

pub fn is_keyword(name: &str) -> bool {
    KEYWORDS.contains(&name)
}

/// The name that a statement gives. A keyword is refused, and read as the name that is proposed instead of it.
pub fn name(input: ParseStream, expected: &str, errors: &mut Errors) -> syn::Result<Ident> {
    let name = input.call(Ident::parse_any).map_err(|error| syn::Error::new(error.span(), expected))?;
    let text = name.to_string();
    let proposed = match text.strip_prefix("r#") {
        Some(raw) => format!("{raw}_"),
        None if is_keyword(&text) => format!("{text}_"),
        None if text == "_" => {
            return Err(syn::Error::new(
                name.span(),
                format!("{expected}, found `_`\nhelp: write a word, such as `m`"),
            ));
        }
        None => return Ok(name),
    };
    errors.push(
        &name,
        format!("`{text}` is a keyword of Rust\nhelp: choose another name, such as `{proposed}`"),
    );
    Ok(Ident::new(&proposed, name.span()))
}

/// Types of other languages, which stand before names.
const FOREIGN_TYPES: [&str; 8] = ["Real", "Integer", "double", "float", "int", "f64", "f32", "Number"];

pub fn is_type(word: &str) -> bool {
    is_primitive(word) || FOREIGN_TYPES.contains(&word)
}

/// Refuses and skips a type before a name: `Real m`.
pub fn no_type_before(input: ParseStream, errors: &mut Errors) -> syn::Result<()> {
    let ahead = input.fork();
    let ty = ahead.call(Ident::parse_any).ok().filter(|word| FOREIGN_TYPES.iter().any(|ty| word == ty));
    if ty.is_some() && ahead.peek(Ident::peek_any) {
        let ty = input.call(Ident::parse_any)?;
        errors
            .push(ty, "a type has no place here: every number is of the system's own type\nhelp: remove it");
    }
    Ok(())
}

/// Returns the message for a statement that begins with this word of Rust.
pub fn statement_of_rust(word: &str) -> Option<&'static str> {
    match word {
        "for" | "while" | "loop" => Some(
            "a system has no loops\nhelp: a sum over a range is `(0..N).map(|i| …).sum()`, an array of bindings `let x: [N] = |i| …;`",
        ),
        "if" | "match" => Some(
            "a statement cannot be conditional\nhelp: a number that depends on a condition is `if … { … } else { … }`, as in `V = if x < 0 { … } else { … };`",
        ),
        _ => None,
    }
}

/// Returns the message for a statement that begins with this word of another language.
pub fn statement_elsewhere(word: &str) -> Option<&'static str> {
    match word {
        "else" | "elif" | "elseif" | "elsif" => {
            Some("`else` continues an `if`\nhelp: remove the `;` before it, `if … { … } else { … }`")
        }
        "import" | "from" | "use" | "using" | "include" => Some(
            "nothing is imported into a system\nhelp: remove this; functions are known by their names, such as `sin(x)`, and π is `PI`",
        ),
        "end" => Some("a statement ends in `;`, a system in `}`\nhelp: remove `end`"),
        "equation" | "equations" => Some(
            "the equations of motion are derived, and not written\nhelp: write the energies, `T = …; V = …;`; a force along a coordinate is `Q[x] = …;`",
        ),
        "der" | "diff" | "ddt" => Some(
            "an equation is no statement: the equations of motion are derived\nhelp: write the energies, `T = …; V = …;`; a velocity in them is `dot(x)`",
        ),
        "torque" | "moment" => Some(
            "a torque is no statement\nhelp: along an angle it is `Q[theta] = …;`, on a frame in space `couple [mx, my, mz] on link;`",
        ),
        "every" | "sample" | "controller" => Some(
            "a control law is no part of a system\nhelp: declare `input u;`, and give the law to a stepper, `Stepper::every`",
        ),
        "print" | "println" | "disp" | "plot" | "display" => {
            Some("a system prints nothing\nhelp: a number of interest is an output, `observe name = …;`")
        }
        "syms" | "symbols" => Some(
            "this is no declaration\nhelp: parameters are declared by `param m, k;`, coordinates by `coord x;`",
        ),
        _ if FOREIGN_TYPES.contains(&word) => Some(
            "a declaration has no type\nhelp: parameters are declared by `param m, k;`, coordinates by `coord x;`, other names by `let y = …;`",
        ),
        _ => None,
    }
}

/// Returns the message for a statement that goes on in this way, if that is an equation.
pub fn equation(rest: ParseStream) -> Option<&'static str> {
    let rest: Vec<TokenTree> = rest.fork().parse::<TokenStream>().ok()?.into_iter().collect();
    let is_equals = |token: &TokenTree| matches!(token, TokenTree::Punct(p) if p.as_char() == '=');
    let is_operator =
        |token: &TokenTree| matches!(token, TokenTree::Punct(p) if "*/+-".contains(p.as_char()));
    let is_product = rest.first().is_some_and(is_operator) && rest.iter().skip(2).any(is_equals);
    (is_product || rest.windows(2).any(|pair| pair.iter().all(is_equals))).then_some(
        "an equation is no statement: the equations of motion are derived\nhelp: write the energies, `T = …; V = …;`; an equation between coordinates is `constraint name: … == …;`",
    )
}

/// An error of the parser's own at a keyword, or behind one, that was meant to be a name.
pub fn keyword_at(error: &syn::Error, tokens: &[TokenTree]) -> Option<syn::Error> {
    if error.to_string().contains("help:") {
        return None;
    }
    let mut all = Vec::new();
    flatten(tokens.iter().cloned(), &mut all);
    let place = error.span().start();
    let found = all.iter().position(|token| token.span().start() == place)?;
    let keyword = |token: &TokenTree| match token {
        // These begin expressions, and are known as what they are.
        TokenTree::Ident(word) => {
            let text = word.to_string();
            let begins = ["if", "for", "while", "loop", "match", "true", "false", "let", "else", "as"];
            (is_keyword(&text) && !begins.contains(&text.as_str())).then_some(text)
        }
        _ => None,
    };
    let is_called = |at: usize| matches!(all.get(at + 1), Some(TokenTree::Group(g)) if g.delimiter() == Delimiter::Parenthesis);
    // The first one begins the statement.
    let candidates = [found, found.wrapping_sub(1)].into_iter().filter(|place| *place > 0);
    let (at, text) = candidates.filter_map(|at| Some((at, keyword(all.get(at)?)?))).next()?;
    let message = match text.as_str() {
        "mod" if is_called(at) => format!("unknown function `mod`\nhelp: {PERIODIC}"),
        "where" if is_called(at) => format!("unknown function `where`\nhelp: {CHOICE}"),
        _ => format!(
            "`{text}` is a keyword of Rust, and no name\nhelp: choose another name, such as `{text}_`"
        ),
    };
    Some(syn::Error::new(all[at].span(), message))
}

/// Tokens with those of groups among them, in the order of the source.
pub fn flatten(tokens: impl Iterator<Item = TokenTree>, all: &mut Vec<TokenTree>) {
    for token in tokens {
        all.push(token.clone());
        if let TokenTree::Group(group) = token {
            flatten(group.stream().into_iter(), all);
        }
    }
}

pub fn ends_operand(token: &TokenTree) -> bool {
    match token {
        TokenTree::Ident(word) => !is_keyword(&word.to_string()),
        TokenTree::Group(group) => group.delimiter() == Delimiter::Parenthesis,
        other => matches!(other, TokenTree::Literal(_)),
    }
}

pub fn begins_operand(token: &TokenTree) -> bool {
    match token {
        TokenTree::Ident(word) => !is_keyword(&word.to_string()),
        other => matches!(other, TokenTree::Literal(_)),
    }
}
