//! Makes a test of each listing of the guide, of the README and of the runtime's documentation, by rustdoc's rules: a
//! listing is a program if it has a `main` and the body of one else, a line that begins with `# ` is hidden in the
//! page, and the last line may say which error `?` returns. Listings that must not compile stay rustdoc's: they become
//! the documentation of the library `mistakes.rs`.

use std::{
    env,
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};

fn main() {
    let root = Path::new("../..");
    let (guide, runtime) = (root.join("docs/guide/src"), root.join("lagrange-runtime/src"));
    let mut pages = files(&guide, "md");
    pages.push(root.join("README.md"));
    pages.extend(files(&runtime, "rs"));
    if env::var_os("CARGO_FEATURE_PARQUET").is_none() {
        pages.retain(|page| !page.ends_with("ensemble/parquet.rs"));
    }
    pages.sort();
    for folder in [guide, runtime.clone()] {
        println!("cargo:rerun-if-changed={}", folder.display());
    }
    let (mut tests, mut mistakes) = (String::new(), String::new());
    for page in &pages {
        println!("cargo:rerun-if-changed={}", page.display());
        let text = fs::read_to_string(page).expect("a page");
        let is_source = page.extension().is_some_and(|extension| extension == "rs");
        let text = if is_source { documentation(&text) } else { text };
        let path = page.strip_prefix(if is_source { &runtime } else { page.parent().expect("a folder") });
        let path = path.expect("a file of this folder").with_extension("");
        let name = path.to_string_lossy().replace(['-', '/', '\\'], "_").to_lowercase();
        for Listing { line, mark, code } in listings(&text) {
            match (mark.as_str(), is_source) {
                ("rust", _) | ("", true) => write!(tests, "mod {name}_line_{line} {{\n{}}}\n", test(&code)),
                (mark, _) if mark.starts_with("compile_fail") => {
                    write!(mistakes, "{name}, line {line}\n```{mark}\n{code}```\n")
                }
                (mark, _) if mark.starts_with("rust") || is_source && mark != "text" => {
                    panic!("{}, line {line}: a listing marked `{mark}` is not compiled", page.display())
                }
                _ => Ok(()),
            }
            .expect("a string");
        }
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("set by cargo"));
    fs::write(out.join("listings.rs"), tests).expect("the folder of what is generated");
    fs::write(out.join("mistakes.md"), mistakes).expect("the folder of what is generated");
}

/// All files in a folder and those in it with this extension.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("a file").path();
        if path.is_dir() {
            found.extend(files(&path, extension));
        } else if path.extension().is_some_and(|of| of == extension) {
            found.push(path);
        }
    }
    found
}

/// The comments of a source that are documentation, each line where it is.
fn documentation(source: &str) -> String {
    let comment = |line: &str| {
        let line = line.trim_start();
        let text =
            line.strip_prefix("///").filter(|text| !text.starts_with('/')).or(line.strip_prefix("//!"))?;
        Some(text.strip_prefix(' ').unwrap_or(text).to_string() + "\n")
    };
    source.lines().map(|line| comment(line).unwrap_or_else(|| "\n".into())).collect()
}

struct Listing {
    /// Number of its first line.
    line: usize,
    mark: String,
    code: String,
}

fn listings(page: &str) -> Vec<Listing> {
    let (mut found, mut open): (Vec<Listing>, _) = (Vec::new(), false);
    for (number, line) in (1..).zip(page.lines()) {
        match (line.trim_start().strip_prefix("```"), found.last_mut().filter(|_| open)) {
            (Some(mark), None) => {
                found.push(Listing { line: number + 1, mark: mark.into(), code: String::new() });
                open = true;
            }
            (Some(""), Some(_)) => open = false,
            (_, Some(listing)) => {
                listing.code += line;
                listing.code.push('\n');
            }
            (None, None) => {}
        }
    }
    assert!(!open, "a listing without an end");
    found
}

/// The items of a module that runs one listing.
fn test(listing: &str) -> String {
    let shown =
        |line: &str| if line == "#" { String::new() } else { line.strip_prefix("# ").unwrap_or(line).into() };
    let listing = listing.lines().map(|line| shown(line) + "\n").collect::<String>();
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
