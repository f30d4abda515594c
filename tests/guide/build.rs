//! Makes a test of each listing of the guide and of the README, by rustdoc's rules: a listing is a program if it has a
//! `main` and the body of one else, a line that begins with `# ` is hidden in the page, and the last line may say which
//! error `?` returns. Listings that are not marked `rust` are left out.

use std::{env, fmt::Write, fs, path::Path};

fn main() {
    let root = Path::new("../..");
    let guide = root.join("docs/guide/src");
    let mut pages: Vec<_> =
        fs::read_dir(&guide).expect("the guide").map(|entry| entry.expect("a chapter").path()).collect();
    pages.retain(|page| page.extension().is_some_and(|extension| extension == "md"));
    pages.push(root.join("README.md"));
    pages.sort();
    println!("cargo:rerun-if-changed={}", guide.display());
    let mut tests = String::new();
    for page in &pages {
        println!("cargo:rerun-if-changed={}", page.display());
        let text = fs::read_to_string(page).expect("a chapter");
        let name = page.file_stem().expect("a file").to_string_lossy().replace('-', "_").to_lowercase();
        for (line, listing) in listings(&text) {
            write!(tests, "mod {name}_line_{line} {{\n{}}}\n", test(&listing)).expect("a string");
        }
    }
    let out = env::var_os("OUT_DIR").expect("set by cargo");
    fs::write(Path::new(&out).join("listings.rs"), tests).expect("the folder of what is generated");
}

/// The listings of a page, each with the number of its first line.
fn listings(page: &str) -> Vec<(usize, String)> {
    let (mut found, mut open): (Vec<(usize, String)>, _) = (Vec::new(), false);
    for (number, line) in (1..).zip(page.lines()) {
        match (open, line) {
            (false, "```rust") => {
                found.push((number + 1, String::new()));
                open = true;
            }
            (false, mark) => {
                assert!(!mark.trim_start().starts_with("```rust"), "line {number}: {mark} is not compiled")
            }
            (true, "```") => open = false,
            (true, line) => {
                let code = if line == "#" { "" } else { line.strip_prefix("# ").unwrap_or(line) };
                let (_, listing) = found.last_mut().expect("one that is open");
                listing.push_str(code);
                listing.push('\n');
            }
        }
    }
    assert!(!open, "a listing without an end");
    found
}

/// The items of a module that runs one listing.
fn test(listing: &str) -> String {
    if listing.contains("fn main()") {
        format!(
            "{listing}\n#[test]\nfn runs() {{\n    let code = std::process::Termination::report(main());\n    \
             assert_eq!(code, std::process::ExitCode::SUCCESS);\n}}\n"
        )
    } else if listing.trim_end().ends_with("(())") {
        format!(
            "#[test]\nfn runs() {{\n    fn listing() -> Result<(), impl core::fmt::Debug> {{\n{listing}    }}\n    \
             listing().unwrap()\n}}\n"
        )
    } else {
        format!("#[test]\nfn runs() {{\n{listing}}}\n")
    }
}
