//! Invariants of docs/ARCHITECTURE.md that the sources show: which stage imports which, where tokens are made and where unsafe code stands, how
//! long a file is, that every long test is run by a script, and that the document names files that there are.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The folder of the repository.
const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Stages of the compiler, each with those that it may import.
const STAGES: &[(&str, &[&str])] = &[
    ("diagnostics", &[]),
    ("graph", &[]),
    ("schedule", &["graph"]),
    ("syntax", &["diagnostics"]),
    ("model", &["diagnostics", "graph", "syntax"]),
    ("equations", &["diagnostics", "graph", "model", "schedule", "syntax"]),
    ("table", &["diagnostics", "equations", "graph", "schedule", "syntax"]),
    ("emit", &["equations", "graph", "model", "schedule", "syntax", "table"]),
    ("compile", &["diagnostics", "emit", "equations", "model", "syntax", "table"]),
];

/// Where tokens are written: the output, errors, and the entry of the macro.
const TOKENS: &[&str] = &["emit/", "emit.rs", "compile.rs", "diagnostics.rs", "lib.rs"];

const UNSAFE: &[&str] = &["lanes/processor.rs", "lanes/registers.rs", "series/rows.rs"];

/// Lines of a file, comments included.
const LONGEST: usize = 1000;

/// All Rust sources below a folder of the repository, by their paths there, without comments.
fn sources(folder: &str) -> BTreeMap<String, String> {
    fn collect(at: &Path, root: &Path, found: &mut BTreeMap<String, String>) {
        for entry in fs::read_dir(at).expect("a folder of the repository") {
            let path = entry.expect("an entry").path();
            if path.is_dir() && !path.ends_with("target") {
                collect(&path, root, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let name =
                    path.strip_prefix(root).expect("below the root").to_string_lossy().replace('\\', "/");
                found.insert(name, code(&fs::read_to_string(&path).expect("a text")));
            }
        }
    }
    let root = Path::new(ROOT).join(folder);
    let mut found = BTreeMap::new();
    collect(&root, &root, &mut found);
    assert!(!found.is_empty(), "{folder}");
    found
}

/// A text without its comments.
fn code(text: &str) -> String {
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// What is compiled for use, without the unit tests at the end of a file.
fn used(code: &str) -> &str {
    code.split("#[cfg(test)]\nmod tests").next().unwrap_or_default()
}

/// Is a file compiled only for tests, by its name or by what `lib.rs`, whose text is given, declares?
fn is_test(name: &str, lib: &str) -> bool {
    let module = name.split(['/', '.']).next().unwrap_or_default();
    name.contains("tests") || lib.contains(&format!("#[cfg(test)]\nmod {module};"))
}

/// The modules at the root of a crate that a text names.
fn imports(code: &str) -> Vec<String> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let word = |text: &str| text.chars().take_while(|c| is_word(*c)).collect::<String>();
    code.split("crate::")
        .skip(1)
        .flat_map(|rest| match rest.strip_prefix('{') {
            // The first words of a list, whose own lists are passed over.
            Some(list) => {
                let (mut depth, mut words, mut begins) = (0, Vec::new(), true);
                for (i, c) in list.char_indices() {
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => begins = true,
                        c if begins && is_word(c) => {
                            words.push(word(&list[i..]));
                            begins = false;
                        }
                        _ => {}
                    }
                }
                words
            }
            None => vec![word(rest)],
        })
        .collect()
}

#[test]
fn stages_of_the_compiler_import_leftward() {
    assert_eq!(
        imports("use crate::{a::{b, c}, d}; let x = crate::e::f; use crate::g;"),
        ["a", "d", "e", "g"]
    );
    let sources = sources("lagrange-macros/src");
    let mut wrong = Vec::new();
    for (name, code) in sources.iter().filter(|(name, _)| !is_test(name, &sources["lib.rs"])) {
        let stage = name.split(['/', '.']).next().unwrap_or_default();
        let Some((_, allowed)) = STAGES.iter().find(|(s, _)| *s == stage) else { continue };
        for import in imports(used(code)) {
            let is_stage = STAGES.iter().any(|(s, _)| *s == import);
            if is_stage && import != stage && !allowed.contains(&import.as_str()) {
                wrong.push(format!("{name} imports {import}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn tokens_are_written_where_they_are_emitted() {
    let sources = sources("lagrange-macros/src");
    let written =
        |name: &String, code: &String| !is_test(name, &sources["lib.rs"]) && used(code).contains("quote!");
    let found: Vec<_> =
        sources.iter().filter(|(name, code)| written(name, code)).map(|(name, _)| name).collect();
    assert!(found.iter().any(|name| *name == "emit.rs"), "{found:?}");
    let wrong: Vec<_> =
        found.into_iter().filter(|name| !TOKENS.iter().any(|t| name.starts_with(t))).collect();
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// No emitted coefficient is made up where a table has none.
#[test]
fn no_coefficient_is_invented() {
    let sources = sources("lagrange-macros/src");
    for name in ["equations/series.rs", "emit/taylor.rs"] {
        for invented in ["unwrap_or(0)", "unwrap_or(Place", "\"S::one()\".into()"] {
            assert!(!used(&sources[name]).contains(invented), "{name}: {invented}");
        }
    }
}

#[test]
fn unsafe_code_stands_in_three_files() {
    let sources = sources("lagrange-runtime/src");
    let is_unsafe = |code: &str| {
        ["unsafe {", "unsafe fn", "unsafe impl"].iter().any(|word| code.contains(word))
            || code.contains("allow(unsafe_code)")
    };
    let found: Vec<_> =
        sources.iter().filter(|(_, code)| is_unsafe(code)).map(|(name, _)| name.as_str()).collect();
    assert_eq!(found, UNSAFE);
}

#[test]
fn methods_know_no_controller_and_controllers_no_system() {
    let sources = sources("lagrange-runtime/src");
    let of = |folder: &'static str| {
        let is_of = move |name: &str| name.starts_with(folder) && !name.contains("tests");
        sources.iter().filter(move |(name, _)| is_of(name)).map(|(name, code)| (name, used(code)))
    };
    for (name, code) in of("controller") {
        let known = imports(code);
        assert!(
            !known.iter().any(|m| ["system", "integrate", "method"].contains(&m.as_str())),
            "{name}: {known:?}"
        );
    }
    for (name, code) in of("method") {
        let known = imports(code);
        assert!(
            !known.iter().any(|m| ["integrate", "sample", "ensemble"].contains(&m.as_str())),
            "{name}: {known:?}"
        );
        for controller in ["Pi", "Pid", "Fixed"] {
            assert!(!code.contains(&format!("{controller}::")), "{name}: {controller}");
        }
    }
}

#[test]
fn files_are_read_in_one_sitting() {
    for folder in ["lagrange-macros", "lagrange-runtime", "examples", "tests", "benches"] {
        let long: Vec<_> =
            sources(folder).into_iter().filter(|(_, code)| code.lines().count() > LONGEST).collect();
        assert!(long.is_empty(), "{:?}", long.iter().map(|(name, _)| name).collect::<Vec<_>>());
    }
}

/// Tests that take minutes are run by `.ci/full`, but for measurements.
#[test]
fn long_tests_run_somewhere() {
    let full = fs::read_to_string(Path::new(ROOT).join(".ci/full")).expect("a script");
    let mut count = 0;
    for folder in ["lagrange-macros", "lagrange-runtime", "tests"] {
        for (name, code) in sources(folder) {
            for rest in code.split("#[ignore = \"").skip(1) {
                let (reason, rest) = rest.split_once('"').expect("a reason");
                let test = rest.split("fn ").nth(1).and_then(|rest| rest.split('(').next()).expect("a test");
                let known = reason.contains("measurement") || reason.contains("tests/peers");
                count += 1;
                assert!(
                    known || full.split_whitespace().any(|word| word.len() > 4 && test.starts_with(word)),
                    "{name}: {test}"
                );
            }
        }
    }
    assert!(count > 5, "{count}");
}

#[test]
fn the_architecture_names_files_that_there_are() {
    let root = Path::new(ROOT);
    let text = fs::read_to_string(root.join("docs/ARCHITECTURE.md")).expect("a document");
    let folders = ["", "lagrange-macros/src", "lagrange-runtime/src", "docs", "examples/work_precision"];
    let mut count = 0;
    let missing: Vec<_> = text
        .split('`')
        .skip(1)
        .step_by(2)
        .filter(|name| name.ends_with(".rs") && !name.contains(['*', '{', ' ']))
        .inspect(|_| count += 1)
        .filter(|name| !folders.iter().any(|folder| root.join(folder).join(name).is_file()))
        .collect();
    assert!(missing.is_empty() && count > 40, "{count}: {missing:?}");
}

/// All documents of the repository, by their paths there.
fn documents() -> BTreeMap<String, String> {
    fn collect(at: &Path, root: &Path, found: &mut BTreeMap<String, String>) {
        for entry in fs::read_dir(at).expect("a folder of the repository") {
            let path = entry.expect("an entry").path();
            let name = path.strip_prefix(root).expect("below the root").to_string_lossy().replace('\\', "/");
            if path.is_dir() && !name.ends_with("target") && !name.starts_with(".git") {
                collect(&path, root, found);
            } else if name.ends_with(".md") {
                found.insert(name, fs::read_to_string(&path).expect("a text"));
            }
        }
    }
    let mut found = BTreeMap::new();
    collect(Path::new(ROOT), Path::new(ROOT), &mut found);
    found
}

#[test]
fn links_lead_somewhere() {
    let mut wrong = Vec::new();
    for (name, text) in documents() {
        let folder = Path::new(ROOT).join(&name).parent().expect("a folder").to_path_buf();
        for rest in text.split("](").skip(1) {
            let target = rest.split([')', '#', ' ']).next().unwrap_or_default();
            let is_file = target.contains('.') && !target.contains("://") && !target.contains('\n');
            if is_file && !folder.join(target).exists() {
                wrong.push(format!("{name}: {target}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Each chapter of the guide is in its summary, and compiled if it has listings; a listing that says which example it is has its code.
#[test]
fn the_guide_is_compiled() {
    let root = Path::new(ROOT);
    let read =
        |path: &str| fs::read_to_string(root.join(path)).unwrap_or_else(|_| panic!("{path} is not there"));
    let (summary, library) = (read("docs/guide/src/SUMMARY.md"), read("lagrange-runtime/src/lib.rs"));
    let mut examples = 0;
    for (name, text) in documents() {
        let Some(chapter) = name.strip_prefix("docs/guide/src/") else { continue };
        assert!(
            chapter == "SUMMARY.md" || summary.contains(&format!("({chapter})")),
            "{chapter} is in no summary"
        );
        let stem = chapter.trim_end_matches(".md");
        if text.contains("```rust\n") {
            assert!(library.contains(&format!("\"{stem}\"")), "{chapter} is not compiled");
        }
        for rest in text.split("<!-- examples/").skip(1) {
            let (file, rest) =
                rest.split_once(" -->\n```rust\n").expect("a listing after the name of its example");
            let listing = rest.split("```").next().unwrap_or_default();
            let example = read(&format!("examples/{file}"));
            let code = example.split_once("\n\n").expect("a comment, and the code").1;
            assert_eq!(code, listing, "{chapter}: {file}");
            examples += 1;
        }
    }
    assert!(examples > 0);
}

#[test]
fn the_gallery_shows_each_example() {
    let read = |path: &str| fs::read_to_string(Path::new(ROOT).join(path)).expect("a file of the repository");
    let (manifest, gallery) = (read("examples/Cargo.toml"), read("docs/gallery.md"));
    let names: Vec<&str> =
        manifest.split("[[example]]\nname = \"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    let missing: Vec<_> = names.iter().filter(|name| !gallery.contains(&format!("`{name}`"))).collect();
    assert!(missing.is_empty() && names.len() > 20, "{missing:?}");
}
