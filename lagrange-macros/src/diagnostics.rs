//! Errors of the user's making: collected with their spans, reported together.

use proc_macro2::TokenStream;
use quote::ToTokens;

/// The errors found so far.
#[derive(Default)]
pub struct Errors(Vec<syn::Error>);

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
        if self.0.iter().all(is_new) {
            self.0.push(error);
        }
        Reported
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// One `compile_error!` for each, in the order of the source.
    pub fn to_tokens(&self) -> TokenStream {
        let mut sorted: Vec<&syn::Error> = self.0.iter().collect();
        sorted.sort_by_key(|e| {
            let start = e.span().start();
            (start.line, start.column)
        });
        sorted.into_iter().map(syn::Error::to_compile_error).collect()
    }

    #[cfg(test)]
    pub fn messages(&self) -> Vec<String> {
        self.0.iter().map(ToString::to_string).collect()
    }
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
        *distance <= 1 + shorter / 3 && *distance < unknown.chars().count()
            || begins(name, unknown)
            || begins(unknown, name)
    };
    let distances = known.into_iter().map(|name| (strsim::damerau_levenshtein(unknown, name), name));
    distances.filter(close).min().map(|(_, name)| name)
}
