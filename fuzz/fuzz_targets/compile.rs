//! Any text is compiled to items of Rust or to errors, without a panic and in bounded time and memory.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let Ok(tokens) = format!("@crate [::lagrange_runtime] {text}").parse() else { return };
    let output = compiler::compile(tokens);
    syn::parse2::<syn::File>(output).expect("items of Rust");
});
