//! Errors of the user's making: collected with their spans, reported together.

use proc_macro2::{Delimiter, Ident, Span, TokenStream, TokenTree};
use quote::{ToTokens, quote};

/// The errors found so far, and the warnings.
#[derive(Default)]
pub struct Errors {
    errors: Vec<syn::Error>,
    warnings: Vec<Warning>,
}

struct Warning {
    at: Span,
    about: &'static str,
    message: String,
}

/// Proof that an error has been recorded; whoever holds it gives up on one expression, not on the compile.
#[derive(Clone, Copy, Debug)]
pub struct Reported;

impl Errors {
    /// Records an error at these tokens. The message says what is wrong; a second line says what to write.
    pub fn push(&mut self, at: impl ToTokens, message: impl std::fmt::Display) -> Reported {
        self.record(syn::Error::new_spanned(at, message))
    }

    pub fn record(&mut self, error: syn::Error) -> Reported {
        // The same mistake met twice through a function or a family is one mistake.
        let is_new = |e: &syn::Error| {
            e.to_string() != error.to_string() || format!("{:?}", e.span()) != format!("{:?}", error.span())
        };
        if self.errors.iter().all(is_new) {
            self.errors.push(error);
        }
        Reported
    }

    /// Number of the errors.
    pub fn len(&self) -> usize {
        self.errors.len()
    }

    pub fn is_empty(&self) -> bool {
        self.errors.is_empty()
    }

    /// The errors in the order of the source.
    fn sorted(&self) -> Vec<&syn::Error> {
        let mut sorted: Vec<&syn::Error> = self.errors.iter().collect();
        sorted.sort_by_key(|e| {
            let start = e.span().start();
            (start.line, start.column)
        });
        sorted
    }

    /// One `compile_error!` for each.
    pub fn to_tokens(&self) -> TokenStream {
        self.sorted().into_iter().map(syn::Error::to_compile_error).collect()
    }

    /// Records a warning. `about` is the name that rustc gives to the subject of the message.
    pub fn warn(&mut self, at: Span, about: &'static str, message: String) {
        // An expression of a family is evaluated once per element.
        let is_new = |w: &Warning| w.message != message || format!("{:?}", w.at) != format!("{at:?}");
        if self.warnings.iter().all(is_new) {
            self.warnings.push(Warning { at, about, message });
        }
    }

    /// Items that make rustc warn: a stable macro has no warnings of its own, but rustc has one for the use of what is
    /// deprecated, at its place and with its note.
    pub fn warnings(&self) -> TokenStream {
        let warning = |Warning { at, about, message }: &Warning| {
            let (declared, used) = (Ident::new(about, Span::call_site()), Ident::new(about, *at));
            quote! {
                const _: () = {
                    #[allow(non_upper_case_globals)]
                    #[deprecated(note = #message)]
                    const #declared: () = ();
                    #used
                };
            }
        };
        self.warnings.iter().map(warning).collect()
    }

    /// The first error in the order of the source.
    pub fn earliest(&self) -> Option<String> {
        self.sorted().first().map(ToString::to_string)
    }

    #[cfg(test)]
    pub fn first(&self) -> Option<syn::Error> {
        self.errors.first().cloned()
    }

    /// Errors and warnings with their places.
    #[cfg(test)]
    pub fn said(&self) -> Vec<(Span, String)> {
        let errors = self.sorted().into_iter().map(|e| (e.span(), e.to_string()));
        errors.chain(self.warnings.iter().map(|w| (w.at, format!("warning: {}", w.message)))).collect()
    }

    #[cfg(test)]
    pub fn messages(&self) -> Vec<String> {
        self.errors.iter().map(ToString::to_string).collect()
    }
}

/// Tokens as one writes them: without spaces around dots, behind signs, and before and within parentheses.
pub fn plain(tokens: impl ToTokens) -> String {
    let (mut text, mut before, mut signed) = (String::new(), String::new(), false);
    for token in tokens.to_token_stream() {
        let (own, joined) = match &token {
            TokenTree::Group(group) => {
                let inside = plain(group.stream());
                let word = before.chars().all(|c| c.is_alphanumeric() || c == '_');
                match group.delimiter() {
                    Delimiter::Parenthesis => (format!("({inside})"), word),
                    Delimiter::Bracket => (format!("[{inside}]"), word),
                    Delimiter::Brace => (format!("{{ {inside} }}"), false),
                    Delimiter::None => (inside, false),
                }
            }
            other => {
                let own = other.to_string();
                let joined = [".", ",", "?"].contains(&own.as_str());
                (own, joined)
            }
        };
        if !(text.is_empty() || joined || signed || before == ".") {
            text.push(' ');
        }
        text += &own;
        let behind_operand =
            before.ends_with(|c: char| c.is_alphanumeric() || ['_', ')', ']', '}'].contains(&c));
        signed = own == "-" && !behind_operand;
        before = own;
    }
    text
}

/// `; did you mean …?` where a known name is close to the unknown one.
pub fn did_you_mean<'a>(unknown: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    closest(unknown, known).map_or(String::new(), |name| format!("; did you mean `{name}`?"))
}

/// The known name that was probably meant: a few letters apart, or a word of which one is the beginning.
pub fn closest<'a>(unknown: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let begins = |a: &str, b: &str| a.chars().count() >= 3 && b.starts_with(a);
    let close = |(distance, name): &(usize, &str)| {
        let shorter = name.chars().count().min(unknown.chars().count());
        *distance <= 1 + shorter.saturating_sub(1) / 3 && *distance < unknown.chars().count()
            || begins(name, unknown)
            || begins(unknown, name)
    };
    let distances = known.into_iter().map(|name| (strsim::damerau_levenshtein(unknown, name), name));
    distances.filter(close).min().map(|(_, name)| name)
}
