//! Systems as beginners write them, with what they mean, in `tests/beginners/systems.txt`; what the compiler says
//! about each is in `tests/beginners/messages.snap`, and what a reader makes of that in `docs/lab/beginners.md`.

use crate::diagnostics::Errors;
use crate::syntax::{self, characters};
use proc_macro2::{LineColumn, TokenStream};
use std::fmt::Write;

/// A name, what is meant, and what is written.
fn systems() -> Vec<[&'static str; 3]> {
    let text = include_str!("../tests/beginners/systems.txt");
    let entries = text.split("\n\n").filter(|entry| !entry.trim_start().starts_with('#'));
    let parts = entries.map(|entry| {
        let (title, system) = entry.trim().split_once('\n').expect("a title and a system");
        let (name, meaning) = title.split_once(": ").expect("a name and what is meant");
        [name, meaning, system]
    });
    parts.collect()
}

#[test]
fn messages_to_beginners() {
    let (mut all, mut silent, mut count, mut helpful) = (String::new(), Vec::new(), 0, 0);
    for [name, meaning, system] in systems() {
        let text = format!("@crate [::lagrange_runtime] {system}");
        let tokens: TokenStream = characters::without(&text).parse().expect("tokens of Rust");
        let mut errors = Errors::default();
        let start = LineColumn { line: 1, column: 0 };
        if !characters::check(&text, start, &tokens, &mut errors)
            && let Some(definition) = syntax::parse(tokens, &mut errors)
        {
            crate::compile::system(&definition, &mut errors);
        }
        let said = errors.said();
        count += 1;
        if said.is_empty() {
            silent.push(name);
        }
        helpful += usize::from(said.iter().any(|(_, message)| message.contains("help:")));
        let _ = writeln!(all, "{name}: {meaning}");
        for (at, message) in said {
            let at = at.source_text().unwrap_or_default();
            let at = at.split_whitespace().collect::<Vec<_>>().join(" ");
            let _ = writeln!(all, "  {at}\n      {}", message.replace('\n', "\n      "));
        }
        all.push('\n');
    }
    let _ = write!(all, "{count} systems, {helpful} with help");
    let mut settings = insta::Settings::new();
    settings.set_snapshot_path("../tests/beginners");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!("messages", all));
    assert!(silent.is_empty(), "nothing is said about {silent:?}");
    assert!(count >= 385 && helpful >= 372, "{helpful} of {count}");
}
