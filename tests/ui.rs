//! What the compiler says about mistakes: each file under `tests/ui` is a program with the mistake of its name, and the
//! `.stderr` beside it is everything that rustc prints. `TRYBUILD=overwrite cargo test --test ui` writes them anew.

#[test]
fn ui() {
    let cases = trybuild::TestCases::new();
    cases.pass("tests/ui/pass/*.rs");
    cases.compile_fail("tests/ui/*.rs");
}
