//! Random expressions over `x`, `y`, `z`, `a: [f64; 3]`, `N = 3` and `f`, and mutations of their tokens.

use crate::differential::generate::Random;
use crate::fuzz::count;
use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

/// Literals in all forms that tokens have, some of which no compiler accepts.
const LITERALS: [&str; 44] = [
    "2.0",
    "0.5",
    "1.",
    "3",
    "7",
    "0",
    "1",
    "2",
    "1e1",
    "2.5e-1",
    "1_000.5",
    "0x1f",
    "0b101",
    "0o17",
    "3f64",
    "2.5f64",
    "3_f64",
    "0x1f64",
    "0b1f64",
    "0o7f64",
    "3f32",
    "0.5f32",
    "3u8",
    "300u8",
    "7i32",
    "2usize",
    "1i64",
    "3x",
    "2m",
    "1e3V",
    "5kg",
    "1E1",
    "1e+2",
    "9223372036854775807",
    "1e400",
    "true",
    "'a'",
    "\"s\"",
    "b'a'",
    "0.1_f64",
    "0_0_12",
    "1.5u8",
    "2147483648",
    "128i8",
];
const NUMBERS: [&str; 13] = [
    "2.0", "0.5", "1.", "3.0", "1e1", "2.5e-1", "1_000.5", "3f64", "2.5f64", "3_f64", "0.1_f64", "1.25E0",
    "0.0",
];
const PREFIXES: [&str; 16] = [
    "-",
    "!",
    "*",
    "&",
    "- -",
    "**",
    "&&",
    "&mut",
    "#[inline]",
    "'a:",
    "move",
    "return",
    "unsafe",
    "const",
    "..",
    "box",
];
const INSERTED: [&str; 22] = [
    "as f64", "as i32", "as f32", "as usize", "as u8", "as _", "as bool", "?", ";", ".0", ".1", "::<f64>",
    "[0]", "[1usize]", ".sin()", ".powi(2)", ".iter()", ".len()", "()", "!", "**2", "^2",
];
const OPERATORS: [&str; 31] = [
    "+", "-", "*", "/", "%", "^", "&", "|", "<<", ">>", "&&", "||", "<", "<=", ">", ">=", "==", "!=", "=",
    "+=", "..", "..=", "**", ".", ",", "+ -", "* -", "/ *", "* &", "- &", "=>",
];
const WORDS: [&str; 40] = [
    "x",
    "y",
    "z",
    "a",
    "N",
    "f",
    "sin",
    "powi",
    "powf",
    "max",
    "min",
    "sum",
    "map",
    "iter",
    "into_iter",
    "rev",
    "zip",
    "enumerate",
    "copied",
    "collect",
    "PI",
    "f64",
    "f32",
    "mut",
    "ref",
    "_",
    "if",
    "else",
    "let",
    "match",
    "loop",
    "self",
    "unknown",
    "len",
    "abs",
    "signum",
    "skip",
    "product",
    "cloned",
    "break",
];
const FUNCTIONS: [&str; 14] = [
    "sin",
    "cos",
    "tan",
    "atan",
    "sinh",
    "tanh",
    "exp",
    "exp_m1",
    "sqrt",
    "cbrt",
    "abs",
    "recip",
    "to_radians",
    "asinh",
];

/// Text of an expression; without `mutated` one that the language means to accept.
pub fn expression(random: &mut Random, mutated: bool) -> String {
    let depth = 1 + random.below(4);
    let text = Written { random, locals: Vec::new() }.number(depth);
    if !mutated {
        return text;
    }
    let mut tokens: TokenStream = text.parse().expect("tokens");
    for _ in 0..1 + random.below(2) {
        tokens = mutation(random, tokens);
    }
    tokens.to_string()
}

struct Written<'r> {
    random: &'r mut Random,
    locals: Vec<String>,
}

impl Written<'_> {
    fn pick<'s>(&mut self, words: &[&'s str]) -> &'s str {
        words[self.random.below(words.len())]
    }

    fn leaf(&mut self) -> String {
        match self.random.below(12) {
            0 | 1 => self.pick(&NUMBERS).into(),
            2 => self.integer(0),
            3 => self
                .pick(&[
                    "PI",
                    "f64::consts::PI",
                    "std::f64::consts::TAU",
                    "consts::E",
                    "core::f64::consts::LN_2",
                ])
                .into(),
            4 => format!("a[{}]", self.integer(1)),
            5 | 6 if !self.locals.is_empty() => {
                let i = self.random.below(self.locals.len());
                self.locals[i].clone()
            }
            _ => self.pick(&["x", "y", "z"]).into(),
        }
    }

    fn number(&mut self, depth: usize) -> String {
        if depth == 0 {
            return self.leaf();
        }
        let d = depth - 1;
        match self.random.below(30) {
            0..=8 => {
                let op = self.pick(&["+", "-", "*", "/", "+", "-", "*"]);
                format!("{} {op} {}", self.number(d), self.number(d))
            }
            9 | 10 => format!("({})", self.number(d)),
            11 => format!("-{}", self.number(d)),
            12 => format!("-{}.powi({})", self.leaf(), self.integer(1)),
            13 | 14 => format!("({}).{}()", self.number(d), self.pick(&FUNCTIONS)),
            15 => format!(
                "({}).{}({})",
                self.number(d),
                self.pick(&["max", "min", "hypot", "atan2", "powf"]),
                self.number(d)
            ),
            16 => format!("({}).mul_add({}, {})", self.number(d), self.number(d), self.number(d)),
            17 => format!("if {} {{ {} }} else {{ {} }}", self.condition(d), self.number(d), self.number(d)),
            18 | 19 => {
                let value = self.number(d);
                let name = self.pick(&["x", "s", "u"]);
                let ty = self.pick(&["", "", ": f64", ": _"]);
                self.locals.push(name.into());
                let rest = self.number(d);
                self.locals.pop();
                format!("{{ let {name}{ty} = {value}; {rest} }}")
            }
            20 => {
                let value = self.number(d);
                self.locals.push("s".into());
                let body = self.number(d);
                self.locals.pop();
                format!("{{ let g = |s: f64| {body}; g({value}) + g(y) }}")
            }
            21 => format!("({} as f64)", self.integer(d)),
            22..=24 => self.sum(d),
            25 => {
                let (one, other) = (self.number(d), self.number(d));
                let i = self.random.below(2);
                format!("({one}, {other}).{i}")
            }
            26 => format!("[{}, {}][{}]", self.number(d), self.number(d), self.random.below(2)),
            27 => match self.random.below(6) {
                0 => format!("f({})", self.number(d)),
                1 => format!("f64::{}({})", self.pick(&FUNCTIONS), self.number(d)),
                2 => format!("{}({})", self.pick(&FUNCTIONS), self.number(d)),
                3 => format!("f64::max({}, {})", self.number(d), self.number(d)),
                4 => format!("*&{}", self.leaf()),
                _ => format!("powi({}, 2)", self.number(d)),
            },
            28 => match self.random.below(4) {
                0 => format!("[{}, x].dot([y, {}])", self.number(d), self.number(d)),
                1 => format!("([{}, x] * {}).norm()", self.number(d), self.number(d)),
                2 => format!("([x, y, {}] - a)[{}]", self.number(d), self.integer(0)),
                _ => format!("a.cross([x, y, {}])[1]", self.number(d)),
            },
            _ => format!(
                "{{ let (s, u) = {}; s * {} + u }}",
                match self.random.below(2) {
                    0 => format!("({}).sin_cos()", self.number(d)),
                    _ => format!("({}, {})", self.number(d), self.number(d)),
                },
                self.number(d)
            ),
        }
    }

    fn integer(&mut self, depth: usize) -> String {
        if depth == 0 {
            return self.pick(&["0", "1", "2", "0x1", "0b10", "1", "2", "N - 1"]).into();
        }
        match self.random.below(6) {
            0 => format!("{} + {}", self.random.below(2), self.random.below(2)),
            1 => format!("{} * {}", self.random.below(2), self.random.below(3)),
            2 => format!("{} - {}", self.random.below(3), self.random.below(3)),
            3 => format!("{} % {}", self.random.below(9), self.random.below(4)),
            4 => format!("{} / {}", self.random.below(9), self.random.below(4)),
            _ => self.integer(0),
        }
    }

    fn condition(&mut self, d: usize) -> String {
        let op = self.pick(&["<", "<=", ">", ">=", "!="]);
        let one = format!("({}) {op} ({})", self.number(d), self.number(d));
        match self.random.below(8) {
            0 => format!("!({one})"),
            1 => format!("{one} && x < 0.5"),
            2 => format!("{one} || y > 0.5"),
            3 => format!("&x {op} &y"),
            _ => one,
        }
    }

    /// A sum over an array or a range.
    fn sum(&mut self, d: usize) -> String {
        let (list, pattern, names): (String, &str, &[&str]) = match self.random.below(9) {
            0 => ("(0..3)".into(), "i", &["a[i]", "i as f64"]),
            1 => ("(0..N).rev()".into(), "i", &["a[i]", "a[N - 1 - i]", "i as f64"]),
            2 => ("a.iter()".into(), "v", &["v", "*v", "v.sin()"]),
            3 => ("a.iter()".into(), "&v", &["v"]),
            4 => ("a.iter().copied()".into(), "v", &["v"]),
            5 => ("a.into_iter().enumerate()".into(), "(i, v)", &["v", "i as f64", "a[i]"]),
            6 => (
                format!("a.iter().zip([{}, {}, 1.0])", self.number(d), self.number(d)),
                "(u, v)",
                &["*u", "v"],
            ),
            7 => (format!("[{}, {}].into_iter()", self.number(d), self.number(d)), "v", &["v"]),
            _ => (format!("[{}; 2].map(|s| s * 2.0).into_iter()", self.number(d)), "v", &["v"]),
        };
        let before = self.locals.len();
        self.locals.extend(names.iter().map(|name| (*name).to_string()));
        let body = self.number(d);
        let name = self.pick(names);
        self.locals.truncate(before);
        let ty = self.pick(&["::<f64>", "::<f64>", ""]);
        let end = self.pick(&["sum", "sum", "product"]);
        format!("{list}.map(|{pattern}| {name} * ({body})).{end}{ty}()")
    }
}

/// One token is replaced, removed, doubled or followed by others.
fn mutation(random: &mut Random, tokens: TokenStream) -> TokenStream {
    let at = random.below(count(&tokens).max(1));
    changed(random, tokens, &mut 0, at)
}

fn changed(random: &mut Random, tokens: TokenStream, position: &mut usize, at: usize) -> TokenStream {
    let mut result = Vec::new();
    for token in tokens {
        let here = *position == at;
        *position += 1;
        let token = match token {
            TokenTree::Group(group) => {
                let inside = changed(random, group.stream(), position, at);
                let delimiter = match (here, random.below(4)) {
                    (true, 0) => Delimiter::Brace,
                    (true, 1) => Delimiter::Parenthesis,
                    (true, 2) => Delimiter::Bracket,
                    _ => group.delimiter(),
                };
                TokenTree::Group(Group::new(delimiter, inside))
            }
            other => other,
        };
        if !here {
            result.push(token);
            continue;
        }
        let mut put = |words: &[&str], random: &mut Random| {
            let text = words[random.below(words.len())];
            result.extend(text.parse::<TokenStream>().expect("tokens"));
        };
        match (random.below(8), &token) {
            (0, _) => {}
            (1, _) => result.extend([token.clone(), token]),
            (2, _) => {
                put(&PREFIXES, random);
                result.push(token);
            }
            (3, _) => {
                result.push(token);
                result.extend(INSERTED[random.below(INSERTED.len())].parse::<TokenStream>().expect("tokens"));
            }
            (_, TokenTree::Literal(_)) => put(&LITERALS, random),
            (_, TokenTree::Ident(_)) => put(&WORDS, random),
            (_, TokenTree::Punct(_)) => put(&OPERATORS, random),
            (_, TokenTree::Group(_)) => result.push(token),
        }
    }
    result.into_iter().collect()
}
