//! Messages of the compiler: each file under `fail` is a program of many mistakes of one kind, each in a module of its own, and the
//! `.stderr` beside it is everything that rustc prints. `TRYBUILD=overwrite cargo test --test ui` writes them anew. A call of rustc takes
//! a second or two, so that mistakes which are found at the same stage share a program. Programs under `pass` have to compile and run.

#[test]
fn ui() {
    trybuild::TestCases::new().compile_fail("fail/*.rs");
}
