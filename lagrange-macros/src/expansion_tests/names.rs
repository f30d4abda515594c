//! Names: those that systems have, and whatever a user may write as one.

use super::taken::is_taken;
use super::{file, solved, systems};
use crate::compile::{compile, system};
use crate::diagnostics::Errors;
use crate::differential::{LONG, variable};
use crate::syntax::parse;
use crate::table::TRAITS;
use crate::through_rustc::Package;
use proc_macro2::{Spacing, TokenStream, TokenTree};
use quote::quote;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use syn::visit::Visit;

/// Functions of traits, of the runtime as it stands, by the name of the trait.
fn traits_of_the_runtime() -> BTreeMap<String, BTreeSet<String>> {
    struct Traits(BTreeMap<String, BTreeSet<String>>);
    impl<'a> Visit<'a> for Traits {
        fn visit_item_trait(&mut self, item: &'a syn::ItemTrait) {
            let functions = item.items.iter().flat_map(|item| match item {
                syn::TraitItem::Fn(function) => vec![function.sig.ident.to_string()],
                // Functions of a state, each before a colon.
                syn::TraitItem::Macro(of) if of.mac.path.is_ident("at_states") => {
                    let written = of.mac.tokens.to_string();
                    let names = written.split(';').filter_map(|one| one.split_once(':'));
                    names.map(|(name, _)| name.trim().to_string()).collect()
                }
                _ => vec![],
            });
            self.0.insert(item.ident.to_string(), functions.collect());
        }
    }
    let mut traits = Traits(BTreeMap::new());
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("../lagrange-runtime/src")];
    while let Some(folder) = folders.pop() {
        for entry in folder.read_dir().expect("sources of the runtime") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&path).expect("text");
                traits.visit_file(&syn::parse_file(&text).expect("Rust"));
            }
        }
    }
    // Traits of the standard library that are derived.
    for (name, functions) in [
        ("Clone", &["clone", "clone_from"][..]),
        ("Copy", &[]),
        ("Debug", &["fmt"]),
        ("PartialEq", &["eq", "ne"]),
        ("Default", &["default"]),
    ] {
        traits.0.insert(name.to_string(), functions.iter().map(ToString::to_string).collect());
    }
    traits.0
}

/// Traits that an emitted system implements, and its own functions.
#[derive(Default)]
struct Implemented {
    traits: BTreeSet<String>,
    functions: BTreeSet<String>,
}

impl<'a> Visit<'a> for Implemented {
    fn visit_item_impl(&mut self, item: &'a syn::ItemImpl) {
        match &item.trait_ {
            Some((path, _)) => {
                self.traits.extend(path.segments.last().map(|s| s.ident.to_string()));
            }
            None => self.functions.extend(item.items.iter().filter_map(|item| match item {
                syn::ImplItem::Fn(function) => Some(function.sig.ident.to_string()),
                _ => None,
            })),
        }
    }

    fn visit_attribute(&mut self, attribute: &'a syn::Attribute) {
        if attribute.path().is_ident("derive") {
            let _ = attribute.parse_nested_meta(|meta| {
                self.traits.extend(meta.path.get_ident().map(ToString::to_string));
                Ok(())
            });
        }
    }
}

/// The names that no output can have are those that emitted systems have, no more and no less.
#[test]
fn outputs_hide_nothing() {
    let runtime = traits_of_the_runtime();
    let mut found: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (_, input) in systems() {
        let definition = solved(input.clone());
        let outputs = definition.model.observed.iter().map(|o| o.name.to_string());
        let outputs: BTreeSet<String> =
            outputs.chain(definition.model.struck.iter().map(|s| s.name.to_string())).collect();
        // (A function of a state beside each of (q, q̇, t).)
        let outputs: BTreeSet<String> =
            outputs.iter().flat_map(|name| [name.clone(), format!("{name}_at")]).collect();
        let mut implemented = Implemented::default();
        implemented.visit_file(&file(compile(input)));
        for name in implemented.traits {
            let functions = runtime.get(&name).unwrap_or_else(|| panic!("no trait `{name}`")).clone();
            // Markers have no functions.
            if !functions.is_empty() {
                found.insert(name, functions);
            }
        }
        found.entry(String::new()).or_default().extend(implemented.functions.difference(&outputs).cloned());
    }
    let table: BTreeMap<String, BTreeSet<String>> =
        TRAITS.iter().map(|of| (of.name.to_string(), of.names().map(String::from).collect())).collect();
    assert_eq!(found, table);
}

/// Keywords of Rust, names of its prelude, types that need no path, and words of the language.
const WORDS: &str = "as break const continue crate else enum extern false fn for if impl in let loop match mod move mut pub ref \
    return self Self static struct super trait true type unsafe use where while async await dyn abstract become box do final gen \
    macro override priv try typeof unsized virtual yield union auto raw safe macro_rules _ __ r#type \
    Some None Ok Err Option Result Vec String Box Default Clone Copy Iterator IntoIterator Extend Drop Fn FnMut FnOnce From Into Send \
    Sync Sized ToOwned ToString AsRef AsMut Eq Ord PartialEq PartialOrd Debug Hash drop default clone vec println assert panic \
    f64 f32 usize u8 i32 bool char str std core alloc lagrange_runtime nalgebra proc_macro \
    t T V L D Q q qd p param input inputs coord state rate start states observe event constraint impulse force couple at on system routhian world frame body particle PI E TAU \
    sin dot reaction x y φ Θ θ̇ ẋ Größe µ _x S K N R M KEY";

/// Roles that a name may have: the word for the role, and a definition in which NAME has it.
pub const ROLES: [(&str, &str); 22] = [
    ("param", "system A { param NAME, other; coord z; T = NAME * dot(z).powi(2); V = other * z.cos(); }"),
    (
        "param array",
        "system A { param NAME: [2]; coord z; T = NAME[0] * dot(z).powi(2); V = NAME[1] * z.sin(); }",
    ),
    (
        "state",
        "system A { coord z; state NAME; T = 0.5 * dot(z).powi(2); V = NAME * z; rate(NAME) = z - NAME; }",
    ),
    (
        "state array",
        "system A { coord z; state NAME: [2]; T = 0.5 * dot(z).powi(2); V = NAME[1] * z; rate(NAME) = [z, NAME[0]]; }",
    ),
    (
        "input",
        "system A { input NAME, other; coord z; T = 0.5 * dot(z).powi(2); V = NAME * z.cos(); Q[z] = other; }",
    ),
    (
        "input array",
        "system A { input NAME: [2]; coord z; T = 0.5 * dot(z).powi(2); V = NAME[0] * z.cos(); Q[z] = NAME[1]; }",
    ),
    ("param default", "system A { param NAME = 2; coord z; T = NAME * dot(z).powi(2); V = z.sin() / NAME; }"),
    (
        "coord",
        "system A { param other; coord NAME, z; T = dot(NAME).powi(2) + (2 + NAME * z) * dot(z).powi(2); V = other * NAME.cos(); }",
    ),
    (
        "coord array",
        "system A { coord NAME: [2]; T = dot(NAME[0]).powi(2) + NAME[0].powi(2) * dot(NAME[1]).powi(2); V = NAME[1].cos() + NAME[0]; }",
    ),
    (
        "prescribed",
        "system A { param other; coord z; coord NAME = other * t; T = (dot(z) + z * dot(NAME)).powi(2); V = z * NAME; observe r = reaction(NAME); }",
    ),
    (
        "const",
        "system A { const NAME = 2; coord z: [NAME]; T = z.map(|z| dot(z).powi(2)).sum(); V = z[NAME - 1].cos(); }",
    ),
    (
        "let",
        "system A { param other; coord z; let NAME = other * z.sin() + t; T = dot(z).powi(2) + dot(NAME).powi(2); V = NAME; }",
    ),
    (
        "let array",
        "system A { coord z; let NAME: [2] = |i| z.sin() + i * z; T = dot(z).powi(2) + dot(NAME[1]).powi(2); V = NAME[0].exp(); }",
    ),
    ("fn", "system A { coord z; fn NAME(s) = s.exp() - s; T = dot(z).powi(2); V = NAME(z); }"),
    (
        "argument",
        "system A { coord z; fn other(NAME) = NAME.exp() - NAME; T = dot(z).powi(2); V = other(z); }",
    ),
    ("closure", "system A { coord z; T = dot(z).powi(2); V = (0..3).map(|NAME| NAME * z.sin()).sum(); }"),
    (
        "extern fn",
        "system A { param other; coord z; extern fn NAME(s, t); T = dot(z).powi(2); V = 0; Q[z] = other * NAME(z, t); }",
    ),
    (
        "observe",
        "system A { param other; coord z; T = dot(z).powi(2); V = z.cos(); observe NAME = [z, other * dot(z)]; }",
    ),
    (
        "constraint",
        "system A { coord z, w; T = dot(z).powi(2) + dot(w).powi(2); V = z; constraint NAME: z.sin() == w; observe r = reaction(NAME); }",
    ),
    ("event", "system A { coord z; T = dot(z).powi(2); V = z.cos(); event NAME: z.sin(); }"),
    ("impulse", "system A { coord z; T = dot(z).powi(2); V = z.cos(); impulse NAME at [z.sin(), z]; }"),
    (
        "system",
        "system NAME { coord z, w; T = dot(z).powi(2) + (1 + z * z) * dot(w).powi(2); V = if z < 0 { z.cos() } else { 1 }; pub routhian Other; }",
    ),
];

fn compiled(definition: &str) -> Result<TokenStream, syn::Error> {
    let tokens: TokenStream = definition.parse().expect("tokens of Rust");
    let tokens = quote!(@crate [::lagrange_runtime] #tokens);
    let mut errors = Errors::default();
    if let Some(definition) = parse(tokens.clone(), &mut errors) {
        system(&definition, &mut errors);
    }
    match errors.first() {
        Some(error) => Err(error),
        None => Ok(compile(tokens)),
    }
}

fn is_colon(token: Option<&TokenTree>) -> bool {
    matches!(token, Some(TokenTree::Punct(p)) if p.as_char() == ':' && p.spacing() == Spacing::Alone)
}

/// Identifiers in functions, in the order of the text: those of fields, methods, functions and paths are kept apart
/// from variables.
fn identifiers(tokens: TokenStream, braced: bool, all: &mut Vec<String>) {
    let mut before = String::new();
    let mut tokens = tokens.into_iter().peekable();
    while let Some(token) = tokens.next() {
        let text = match token {
            TokenTree::Group(group) => {
                identifiers(group.stream(), group.delimiter() == proc_macro2::Delimiter::Brace, all);
                String::new()
            }
            TokenTree::Punct(colon) if colon.as_char() == ':' && colon.spacing() == Spacing::Joint => {
                "::".into()
            }
            TokenTree::Punct(colon) if colon.as_char() == ':' && before == "::" => "::".into(),
            other => other.to_string(),
        };
        let called = match tokens.peek() {
            Some(TokenTree::Group(group)) => group.delimiter() == proc_macro2::Delimiter::Parenthesis,
            Some(TokenTree::Punct(generic)) => generic.as_char() == ':',
            _ => false,
        };
        match before.as_str() {
            "." if called => all.push(format!(".() {text}")),
            "." | "fn" | "::" => all.push(format!("{before} {text}")),
            // A field of a structure that is written out.
            "" | "," if braced && is_colon(tokens.peek()) => all.push(format!(". {text}")),
            _ => all.push(text.clone()),
        }
        before = text;
    }
}

/// The identifiers of each function, without those of functions within it, which do not see its variables.
#[derive(Default)]
struct Functions(Vec<Vec<String>>);

impl Functions {
    fn add(&mut self, signature: &syn::Signature, body: &syn::Block) {
        let (inner, statements): (Vec<_>, Vec<_>) =
            body.stmts.iter().partition(|statement| matches!(statement, syn::Stmt::Item(_)));
        let mut all = Vec::new();
        identifiers(quote!(#signature #(#statements)*), false, &mut all);
        self.0.push(all);
        inner.into_iter().for_each(|statement| self.visit_stmt(statement));
    }
}

impl<'a> Visit<'a> for Functions {
    fn visit_impl_item_fn(&mut self, function: &'a syn::ImplItemFn) {
        self.add(&function.sig, &function.block);
    }

    fn visit_item_fn(&mut self, function: &'a syn::ItemFn) {
        self.add(&function.sig, &function.block);
    }
}

/// The functions of an expansion's traits and outputs, without the structure and its constructors.
fn functions(expansion: TokenStream) -> Vec<Vec<String>> {
    let mut functions = Functions::default();
    for item in syn::parse2::<syn::File>(expansion).expect("items").items {
        if let syn::Item::Const(item) = item {
            functions.visit_expr(&item.expr);
        }
    }
    functions.0
}

/// No variable of ours is hidden by one of the user's, nor the other way round: the functions are those for a name that
/// nothing else has, but for a renaming that keeps different names apart.
fn assert_hygienic(name: &str, role: &str, expansion: TokenStream, neutral: &[Vec<String>]) {
    let own = functions(expansion);
    assert_eq!(own.len(), neutral.len(), "{role} `{name}`");
    for (own, neutral) in own.iter().zip(neutral) {
        assert_eq!(own.len(), neutral.len(), "{role} `{name}`");
        let mut renamed: BTreeMap<&str, &str> = BTreeMap::new();
        // Types have names apart from those of values, and fields belong to their types.
        const TYPES: [&str; 4] = ["f64", "usize", "bool", "S"];
        let both = own
            .iter()
            .zip(neutral)
            .filter(|(_, neutral)| !TYPES.contains(&neutral.as_str()) && !neutral.starts_with(". "));
        for (own, neutral) in both {
            let known = renamed.insert(own, neutral);
            assert!(
                known.is_none_or(|known| known == neutral),
                "{role} `{name}`: `{own}` is `{neutral}` as well as `{known:?}`"
            );
        }
    }
}

/// Every identifier of the expansions of the fixtures.
fn identifiers_of_expansions() -> BTreeSet<String> {
    let mut all = Vec::new();
    for (_, input) in systems() {
        identifiers(compile(input), false, &mut all);
    }
    let word = |text: &String| syn::parse_str::<syn::Ident>(text).is_ok();
    all.into_iter().map(|text| text.rsplit(' ').next().unwrap_or_default().to_string()).filter(word).collect()
}

/// A name with one of [`ROLES`], and the system in which it has it.
type Accepted = (String, &'static str, String);

/// One in so many pairs of names and roles: the system is accepted, and what is emitted is hygienic, or the error is
/// at the name and says what to write.
fn assert_names(names: impl Iterator<Item = String>, one_in: usize) -> Vec<Accepted> {
    let neutral = ROLES.map(|(role, template)| {
        ["neutral", "Neutral"].map(|name| {
            let expansion = compiled(&template.replace("NAME", name));
            functions(expansion.unwrap_or_else(|error| panic!("{role}: {error}")))
        })
    });
    let mut accepted = Vec::new();
    for (i, name) in names.enumerate() {
        for (j, (role, template)) in ROLES.into_iter().enumerate() {
            if (i + j) % one_in != 0 {
                continue;
            }
            let definition = template.replace("NAME", &name);
            match compiled(&definition) {
                Ok(expansion) => {
                    assert!(!is_taken(&name, template), "{role} `{name}` is not taken");
                    if role != "system" {
                        let large = usize::from(!name.starts_with(char::is_lowercase));
                        assert_hygienic(&name, role, expansion, &neutral[j][large]);
                    }
                    accepted.push((name.clone(), role, definition));
                }
                Err(error) => {
                    let at = error.span().source_text().unwrap_or_default();
                    let message = error.to_string();
                    assert!(message.contains("help:"), "{role} `{name}`: {message}");
                    assert!(at == name, "{role} `{name}`: at `{at}`, {message}");
                    // (Arguments of a closure are a pattern, in which keywords mean something.)
                    let is_known = role == "closure"
                        || is_taken(&name, template)
                        || name == "_"
                        || message.contains("defined twice");
                    assert!(is_known, "{role} `{name}` is in no table: {message}");
                }
            }
        }
    }
    accepted
}

/// One in `n`; with [`LONG`] five times as many.
fn one_in(n: usize) -> usize {
    if *LONG { n / 5 } else { n }
}

#[test]
fn words_as_names() {
    assert_names(WORDS.split_whitespace().map(String::from), one_in(60));
}

#[test]
fn names_of_expansions_as_names() {
    assert_names(identifiers_of_expansions().into_iter(), one_in(600));
}

/// Each name in each role, where it is accepted, through rustc: what a name means where the system stands does not
/// matter.
#[test]
#[ignore = "minutes: thousands of systems are compiled"]
fn names_through_rustc() {
    let names: BTreeSet<String> =
        WORDS.split_whitespace().map(String::from).chain(identifiers_of_expansions()).collect();
    let one_in = variable("LAGRANGE_ONE_IN").map_or(1, |one_in| one_in as usize);
    let accepted = assert_names(names.into_iter(), one_in);
    let package = Package::new("names", "");
    for (i, systems) in accepted.chunks(200).enumerate() {
        let modules = systems.iter().enumerate().map(|(k, (name, role, definition))| {
            let outside = match *role {
                "extern fn" => format!("fn {name}<S: ::lagrange_runtime::Scalar>(s: S, _: S) -> S {{ s }}"),
                "system" => String::new(),
                // Constants are not called in small letters.
                _ if name.starts_with(char::is_lowercase) || name.starts_with('_') => String::new(),
                _ => format!("const {name}: f64 = 1.0;"),
            };
            format!("mod names_{k} {{ use ::lagrange_runtime::prelude::*; {outside}\nlagrangian! {{ {definition} }} }}\n")
        });
        package.add(&format!("names_{i}"), &format!("#![allow(warnings)]\n{}", modules.collect::<String>()));
    }
    println!("{} systems through rustc", accepted.len());
    package.cargo(&["check", "--tests"]);
}
