//! Invariants of docs/ARCHITECTURE.md that the sources show: which stage imports which, that no files import each
//! other in a circle, where tokens are made, where code parses, panics and is unsafe, how long a file is, that every
//! long test is run by a script, and that the document names files that there are.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

#[path = "tidy/prose.rs"]
mod reading;

/// The folder of the repository.
const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Stages of the compiler, each with those that it may import.
const STAGES: &[(&str, &[&str])] = &[
    ("diagnostics", &[]),
    ("graph", &[]),
    ("program", &["graph"]),
    ("syntax", &["diagnostics"]),
    ("model", &["diagnostics", "graph", "syntax"]),
    ("equations", &["diagnostics", "graph", "model", "program", "syntax"]),
    ("table", &["diagnostics", "equations", "graph", "program", "syntax"]),
    ("emit", &["equations", "graph", "model", "program", "syntax", "table"]),
    ("compile", &["diagnostics", "emit", "equations", "model", "syntax", "table"]),
];

/// Files in which tokens are written: the output, errors, and the entry of the macro.
const TOKENS: &[&str] = &["emit/", "emit.rs", "compile.rs", "diagnostics.rs", "lib.rs"];

const UNSAFE: &[&str] = &["lanes/processor.rs", "lanes/registers.rs", "series/rows.rs"];

/// Lines of a file, comments included.
const LONGEST: usize = 1000;

/// All Rust sources below a folder of the repository, by their paths there.
fn texts(folder: &str) -> BTreeMap<String, String> {
    fn collect(at: &Path, root: &Path, found: &mut BTreeMap<String, String>) {
        for entry in fs::read_dir(at).expect("a folder of the repository") {
            let path = entry.expect("an entry").path();
            if path.is_dir() && !path.ends_with("target") {
                collect(&path, root, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let name =
                    path.strip_prefix(root).expect("below the root").to_string_lossy().replace('\\', "/");
                found.insert(name, fs::read_to_string(&path).expect("a text"));
            }
        }
    }
    let root = Path::new(ROOT).join(folder);
    let mut found = BTreeMap::new();
    collect(&root, &root, &mut found);
    assert!(!found.is_empty(), "{folder}");
    found
}

/// The sources below a folder, without comments.
fn sources(folder: &str) -> BTreeMap<String, String> {
    texts(folder).into_iter().map(|(name, text)| (name, code(&text))).collect()
}

/// The sources below a folder that are no programs with mistakes.
fn prose(folder: &str) -> impl Iterator<Item = (String, String)> {
    texts(folder).into_iter().filter(|(name, _)| !name.contains("ui/"))
}

/// A text without its comments.
fn code(text: &str) -> String {
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Code that is compiled for use, without the unit tests at the end of a file.
fn used(code: &str) -> &str {
    let tests = code.find("\nmod tests").and_then(|at| code[..at].rfind("#[cfg(test)]"));
    &code[..tests.unwrap_or(code.len())]
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

/// The paths of a `use` tree.
fn leaves(tree: &str, before: &[&str], found: &mut Vec<Vec<String>>) {
    let tree = tree.trim();
    let (path, list) = match tree.split_once('{') {
        Some((path, list)) => (path, list.strip_suffix('}')),
        None => (tree.split(" as ").next().unwrap_or_default(), None),
    };
    let path: Vec<&str> = before
        .iter()
        .copied()
        .chain(path.split("::").map(str::trim).filter(|word| !word.is_empty()))
        .collect();
    let Some(list) = list else {
        found.push(path.into_iter().map(String::from).collect());
        return;
    };
    let (mut depth, mut begin) = (0, 0);
    for (i, c) in list.char_indices().chain([(list.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                let leaf = &list[begin..i];
                begin = (i + 1).min(list.len());
                if !leaf.trim().is_empty() {
                    leaves(leaf, &path, found);
                }
            }
            _ => {}
        }
    }
}

/// The `use` declarations of a file: paths that it hands on to others, and paths that it uses itself, there or in its
/// code.
fn paths(code: &str) -> [Vec<Vec<String>>; 2] {
    let (mut handed_on, mut used) = (Vec::new(), Vec::new());
    let mut rest = String::new();
    for part in code.split_inclusive(';') {
        let is_public = |before: &str| {
            let word = before.split_whitespace().last().unwrap_or_default();
            word == "pub" || word.starts_with("pub(") || word.ends_with(')') && before.contains("pub(in")
        };
        match part.rfind("use ").filter(|at| part[..*at].chars().last().is_none_or(char::is_whitespace)) {
            Some(at) if !part[at..].contains(" = ") => {
                let (before, tree) = (&part[..at], part[at + 4..].trim_end_matches(';'));
                leaves(tree, &[], if is_public(before) { &mut handed_on } else { &mut used });
                rest += before;
            }
            _ => rest += part,
        }
    }
    let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    for start in ["crate::", "super::"] {
        for (at, _) in rest.match_indices(start) {
            let before = rest[..at].chars().last();
            if before.is_none_or(|c| !is_word(c) && c != '$') {
                let path: String = rest[at..].chars().take_while(|c| is_word(*c)).collect();
                used.push(path.split("::").filter(|word| !word.is_empty()).map(String::from).collect());
            }
        }
    }
    [handed_on, used]
}

/// The file in which a path of another one ends, through what files hand on.
fn file_of(
    path: &[String],
    from: &str,
    files: &BTreeMap<String, [Vec<Vec<String>>; 2]>,
    depth: usize,
) -> Option<String> {
    let own: Vec<&str> = from.trim_end_matches(".rs").split('/').filter(|m| *m != "lib").collect();
    let ups = path.iter().take_while(|word| *word == "super").count();
    let words = path.iter().map(String::as_str);
    let full: Vec<&str> = match path.first()?.as_str() {
        "crate" => words.skip(1).collect(),
        "super" => own[..own.len().checked_sub(ups)?].iter().copied().chain(words.skip(ups)).collect(),
        "self" => own.iter().copied().chain(words.skip(1)).collect(),
        _ => own.iter().copied().chain(words).collect(),
    };
    let known = |modules: &[&str]| {
        let name = if modules.is_empty() { "lib.rs".into() } else { modules.join("/") + ".rs" };
        files.contains_key(&name).then_some(name)
    };
    let (length, file) = (0..=full.len()).rev().find_map(|n| Some((n, known(&full[..n])?)))?;
    // A path that begins with the name of a crate.
    if length == own.len() && !["crate", "super", "self"].contains(&path[0].as_str()) && file == from {
        return None;
    }
    let handed_on = full.get(length).and_then(|name| {
        let of = files[&file][0].iter().find(|path| path.last().is_some_and(|last| last == name))?;
        (depth < 8).then(|| file_of(of, &file, files, depth + 1))?
    });
    Some(handed_on.unwrap_or(file))
}

/// Files of a crate and the files that they use, but for its root.
fn uses(folder: &str) -> BTreeMap<String, BTreeSet<String>> {
    let sources = sources(folder);
    let files: BTreeMap<String, _> = sources
        .iter()
        .filter(|(name, _)| !is_test(name, &sources["lib.rs"]) && !name.contains("testing/"))
        .map(|(name, code)| (name.clone(), paths(used(code))))
        .collect();
    let of = |name: &String| {
        let [_, used] = &files[name];
        let found = used.iter().filter_map(|path| file_of(path, name, &files, 0));
        found.filter(|file| file != name && file != "lib.rs").collect()
    };
    files.keys().filter(|name| *name != "lib.rs").map(|name| (name.clone(), of(name))).collect()
}

/// Stages that descend recursively through what was written: an expression contains statements, and these
/// expressions, each with its file.
const RECURSIVE: [&str; 2] = ["model", "syntax"];

/// Files that import each other in a circle cannot be understood, or compiled, one after the other.
#[test]
fn no_files_import_each_other_in_a_circle() {
    let crates = [
        ("lagrange-runtime/src", "state.rs", "scalar.rs"),
        ("lagrange-macros/src", "emit.rs", "emit/body.rs"),
    ];
    for (folder, file, uses_file) in crates {
        let mut graph = uses(folder);
        let count: usize = graph.values().map(BTreeSet::len).sum();
        assert!(graph[file].contains(uses_file) && count > 300, "{count} {:?}", graph[file]);
        if folder.contains("macros") {
            let stage = |file: &str| RECURSIVE.into_iter().find(|stage| file.starts_with(stage));
            for (from, uses) in &mut graph {
                uses.retain(|to| stage(from).is_none() || stage(from) != stage(to));
            }
        }
        let reached = |from: &String| {
            let (mut reached, mut next) = (BTreeSet::new(), vec![from.clone()]);
            while let Some(file) = next.pop() {
                next.extend(graph[&file].iter().filter(|file| reached.insert((*file).clone())).cloned());
            }
            reached
        };
        let reached: BTreeMap<_, _> = graph.keys().map(|file| (file, reached(file))).collect();
        let is_back = |from: &String, to: &&String| reached[*to].contains(from);
        let of = |(file, uses): (&String, &BTreeSet<String>)| {
            let back: Vec<_> = uses.iter().filter(|to| is_back(file, to)).cloned().collect();
            (!back.is_empty()).then(|| format!("{file}: {}", back.join(", ")))
        };
        let circle: Vec<_> = graph.iter().filter_map(of).collect();
        assert!(circle.is_empty(), "{folder}: {circle:#?}");
    }
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

/// Tokens of the user are parsed in the first stage; what else is parsed is the table of functions.
#[test]
fn tokens_are_parsed_by_the_first_stage() {
    let sources = sources("lagrange-macros/src");
    let parses =
        |code: &str| ["syn::parse", "parse2(", "parse_str("].iter().any(|word| used(code).contains(word));
    let found: Vec<_> = sources
        .iter()
        .filter(|(name, code)| !is_test(name, &sources["lib.rs"]) && parses(code))
        .map(|(name, _)| name.as_str())
        .filter(|name| !name.starts_with("syntax"))
        .collect();
    assert_eq!(found, ["graph/differentiate.rs"]);
}

/// Entries of the standard library's hash maps have another order in each run of the compiler.
#[test]
fn nothing_iterates_over_a_hash_map() {
    let sources = sources("lagrange-macros/src");
    let of = |(name, code): (&String, &String)| {
        let has = ["HashMap", "HashSet"].iter().any(|map| code.contains(map));
        (has && !is_test(name, &sources["lib.rs"])).then(|| name.clone())
    };
    let found: Vec<_> = sources.iter().filter_map(of).collect();
    assert!(found.is_empty(), "{found:?}");
}

/// A panic says which invariant does not hold. In the runtime nothing that a user gives leads to one: those that are
/// left are of the font that is compiled in, of numbers in the source, and of what the loop over lanes knows of
/// itself.
#[test]
fn no_input_of_a_user_panics() {
    const INVARIANTS: [&str; 4] =
        ["chart/font.rs", "ensemble/lanes.rs", "integrate/lanes/convoy.rs", "scalar/double_double/digits.rs"];
    let panics = ["panic!(", ".unwrap()", ".expect(", "unreachable!(", "todo!(", "unimplemented!("];
    let files = |folder, words: &[&str]| -> Vec<String> {
        let sources = sources(folder);
        let is_used = |name: &str| {
            let tests =
                ["tests", "testing", "properties", "accuracy", "fuzz", "rustc", "differential", "beginners"];
            !is_test(name, &sources["lib.rs"]) && !tests.iter().any(|test| name.contains(test))
        };
        let has = |code: &str| words.iter().any(|word| used(code).contains(word));
        let found = sources.iter().filter(|(name, code)| is_used(name) && has(code));
        found.map(|(name, _)| name.clone()).collect()
    };
    assert_eq!(files("lagrange-runtime/src", &panics), INVARIANTS);
    let without_a_reason = [".unwrap()", "panic!()", "todo!(", "unimplemented!("];
    assert!(files("lagrange-macros/src", &without_a_reason).is_empty());
}

/// No emitted coefficient is made up where a table has none.
#[test]
fn no_coefficient_is_invented() {
    let sources = sources("lagrange-macros/src");
    for name in [
        "equations/series.rs",
        "equations/series/recurrence.rs",
        "equations/series/orders.rs",
        "equations/series/bindings.rs",
        "emit/taylor.rs",
    ] {
        let invented =
            ["unwrap_or(0)", "unwrap_or(Place", "unwrap_or(Value", "unwrap_or(own)", "\"S::one()\".into()"];
        for invented in invented {
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
        for controller in ["PiController", "PidController", "FixedStep"] {
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

/// Tests that take long are run by `.ci/run`, and those that take minutes by `.ci/full`, but for measurements.
#[test]
fn long_tests_run_somewhere() {
    let run = fs::read_to_string(Path::new(ROOT).join(".ci/run")).expect("a script");
    assert!(run.contains("\ncargo test --profile long -p lagrange-motions --features long\n"));
    let motions = fs::read_to_string(Path::new(ROOT).join("tests/motions/Cargo.toml")).expect("a manifest");
    assert!(!motions.contains("\ntest = false") && motions.contains("required-features = [\"long\"]"));
    assert!(run.contains("\ncargo test --release --example stability"));
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

/// Each chapter of the guide is in its summary; a listing that says which example it is has its code.
#[test]
fn the_guide_has_its_chapters_and_examples() {
    let root = Path::new(ROOT);
    let read =
        |path: &str| fs::read_to_string(root.join(path)).unwrap_or_else(|_| panic!("{path} is not there"));
    let summary = read("docs/guide/src/SUMMARY.md");
    let mut examples = 0;
    for (name, text) in documents() {
        let Some(chapter) = name.strip_prefix("docs/guide/src/") else { continue };
        assert!(
            chapter == "SUMMARY.md" || summary.contains(&format!("({chapter})")),
            "{chapter} is in no summary"
        );
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

/// The gallery has a row for each example, with a picture and a sentence.
#[test]
fn the_gallery_shows_each_example() {
    let read = |path: &str| fs::read_to_string(Path::new(ROOT).join(path)).expect("a file of the repository");
    let (manifest, gallery) = (read("examples/Cargo.toml"), read("docs/gallery.md"));
    let names: Vec<&str> =
        manifest.split("[[example]]\nname = \"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    let is_shown = |name: &str| {
        gallery.lines().any(|line| {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            let [_, picture, example, sentence, _] = cells[..] else { return false };
            let file = picture.strip_prefix("![](").and_then(|rest| rest.strip_suffix(')'));
            (example == format!("`{name}`") || sentence.contains(&format!("`{name}`")))
                && file.is_some_and(|file| Path::new(ROOT).join("docs").join(file).is_file())
                && sentence.ends_with(['.', '?', ')'])
        })
    };
    let missing: Vec<_> = names.iter().filter(|name| !is_shown(name)).collect();
    assert!(missing.is_empty() && names.len() > 20, "{missing:?}");
}

/// Pictures load at once, each is in a document, and each chapter of the guide has one, but for those that
/// explain words.
#[test]
fn pictures_are_small_and_shown() {
    let root = Path::new(ROOT);
    let all: String = documents().into_values().collect();
    for folder in ["docs/gallery", "docs/guide/src/images", "docs/lab"] {
        for entry in fs::read_dir(root.join(folder)).expect("a folder of the repository") {
            let entry = entry.expect("an entry");
            let name = entry.file_name().to_string_lossy().into_owned();
            let most = match name.rsplit_once('.').unwrap_or_default().1 {
                "svg" => 300_000,
                "png" | "html" => 1_000_000,
                _ => continue,
            };
            let size = entry.metadata().expect("a file").len();
            assert!(size <= most, "{folder}/{name}: {size} bytes");
            assert!(
                all.contains(&format!("/{name})")) || all.contains(&format!("({name})")),
                "{name} is shown nowhere"
            );
        }
    }
    for (name, text) in documents() {
        let Some(chapter) = name.strip_prefix("docs/guide/src/") else { continue };
        let is_plain = ["SUMMARY.md", "glossary.md", "failures.md"].contains(&chapter);
        assert!(is_plain || text.contains("](images/"), "{chapter} has no picture");
    }
}

/// First lines of the errors and warnings in an output of rustc, without the constant that a warning of the macro uses.
fn messages(stderr: &str) -> Vec<String> {
    let of = |line: &str| {
        let (head, message) = line.split_once(": ")?;
        let is_head = ["error", "warning"]
            .into_iter()
            .any(|word| head == word || head.starts_with(&format!("{word}[")));
        let message = match message.strip_prefix("use of deprecated constant `") {
            Some(rest) => rest.split_once("`: ")?.1,
            None => message,
        };
        is_head.then(|| message.to_string())
    };
    stderr.lines().filter_map(of).collect()
}

/// A message without its names, which are in backticks, and its numbers.
fn form(message: &str) -> String {
    let without_names = message.split('`').enumerate().map(|(i, part)| if i % 2 == 1 { "" } else { part });
    let text = without_names.collect::<Vec<_>>().join("`");
    let mut form = String::new();
    for c in text.chars() {
        let is_more = c.is_ascii_digit() && form.ends_with('0');
        if !is_more {
            form.push(if c.is_ascii_digit() { '0' } else { c });
        }
    }
    form
}

/// The chapter on failures has a row for each variant of `Failure`, and one for each kind of message that the compiler
/// gives: with names and numbers left out, every message of tests/ui/fail begins as one of a row (or
/// is one, if that has only one or two words).
#[test]
fn the_guide_explains_each_failure() {
    let read = |path: &str| fs::read_to_string(Path::new(ROOT).join(path)).expect("a file of the repository");
    let (chapter, failures) = (read("docs/guide/src/failures.md"), read("lagrange-runtime/src/failure.rs"));
    let body = failures.split_once("pub enum Failure<").and_then(|(_, rest)| rest.split_once("\n}\n"));
    let variants: Vec<&str> = body
        .expect("the enum")
        .0
        .lines()
        .filter_map(|line| line.strip_prefix("    ")?.split([' ', ',', '(']).next())
        .filter(|word| word.starts_with(char::is_uppercase))
        .collect();
    assert!(variants.len() > 25, "{variants:?}");
    let rows: Vec<&str> = chapter.lines().filter(|line| line.starts_with("| ")).collect();
    let missing: Vec<_> =
        variants.iter().filter(|v| !rows.iter().any(|row| row.starts_with(&format!("| `{v}` |")))).collect();
    assert!(missing.is_empty(), "{missing:?}");

    let mut explained = BTreeSet::new();
    let mut beginnings = Vec::new();
    for section in chapter.split("\n### ").skip(1) {
        let kinds = section.split_once("<!-- ").and_then(|(_, rest)| rest.split_once(" -->"));
        let kinds: Vec<&str> = kinds.expect("the programs of a kind").0.split(' ').collect();
        let messages: Vec<String> =
            kinds.iter().flat_map(|kind| messages(&read(&format!("{kind}.stderr")))).collect();
        explained.extend(kinds.into_iter().map(|kind| kind.replace("tests/ui/fail/", "")));
        for row in section.lines().filter(|line| line.starts_with("| ")).skip(1) {
            let cell = row.trim_start_matches("| ").split(" | ").next().unwrap_or_default();
            for beginning in cell.replace("\\|", "|").split("<br>") {
                assert!(messages.iter().any(|m| m.starts_with(beginning)), "no such message: {beginning}");
                beginnings.push(form(beginning));
            }
        }
    }
    let of_kind = |path: std::path::PathBuf| {
        let is_program = path.extension().is_some_and(|e| e == "stderr");
        is_program.then(|| path.file_stem().expect("a name").to_string_lossy().into_owned())
    };
    let folder = fs::read_dir(Path::new(ROOT).join("tests/ui/fail")).expect("a folder of the repository");
    let kinds: BTreeSet<String> = folder.filter_map(|entry| of_kind(entry.ok()?.path())).collect();
    assert_eq!(explained, kinds);
    let forms: BTreeSet<String> = kinds
        .iter()
        .flat_map(|kind| messages(&read(&format!("tests/ui/fail/{kind}.stderr"))))
        .map(|message| form(&message))
        .collect();
    // One or two words are no kind, but may be a whole message.
    let begins = |form: &str, beginning: &str| {
        form == beginning || beginning.split(' ').count() > 2 && form.starts_with(beginning)
    };
    let is_missing = |form: &&String| !beginnings.iter().any(|beginning| begins(form, beginning));
    let missing: Vec<_> = forms.iter().filter(is_missing).collect();
    assert!(missing.is_empty() && forms.len() > 300, "{} of {}: {missing:#?}", missing.len(), forms.len());
}

/// A reader of the crate's front page sees a bounded number of names.
#[test]
fn the_root_has_a_bounded_number_of_names() {
    let lib = fs::read_to_string(Path::new(ROOT).join("lagrange-runtime/src/lib.rs")).expect("the crate");
    let modules: Vec<&str> = lib.lines().filter_map(|line| line.strip_prefix("pub mod ")).collect();
    // (Beside the prelude, and what emitted code names.)
    let modules: Vec<_> =
        modules.into_iter().filter(|m| !m.starts_with("prelude") && !m.starts_with("__")).collect();
    assert!((8..=12).contains(&modules.len()), "{}: {modules:?}", modules.len());
    let code = code(&lib);
    let names: Vec<&str> = code
        .split("\npub use ")
        .skip(1)
        .flat_map(|rest| {
            rest.split(';').next().unwrap_or_default().rsplit("::").next().unwrap_or_default().split(',')
        })
        .map(|name| name.trim_matches(|c: char| !c.is_alphanumeric() && c != '_'))
        .filter(|name| !name.is_empty())
        .collect();
    // (With the macro.)
    assert!((30..60).contains(&names.len()), "{}: {names:?}", names.len());
}

/// A function of the compiler fits a page or two.
#[test]
fn functions_of_the_compiler_are_short() {
    const MAX_LINES: usize = 100;
    let lib = fs::read_to_string(Path::new(ROOT).join("lagrange-macros/src/lib.rs")).expect("the crate");
    let mut seen = 0;
    let mut long = Vec::new();
    for (name, text) in texts("lagrange-macros/src") {
        if is_test(&name, &lib) {
            continue;
        }
        let lines: Vec<&str> = text.lines().collect();
        for (first, line) in lines.iter().enumerate() {
            let head = line.trim_start();
            let indent = &line[..line.len() - head.len()];
            let is_function =
                ["fn ", "pub fn ", "pub(crate) fn ", "pub(super) fn ", "const fn ", "pub const fn "];
            if !is_function.iter().any(|start| head.starts_with(start)) || head.ends_with(['}', ';']) {
                continue;
            }
            let is_end = |line: &&str| line.strip_prefix(indent).is_some_and(|rest| rest == "}");
            let length = lines[first..].iter().position(is_end).expect("an end") + 1;
            seen += 1;
            if length > MAX_LINES {
                long.push(format!("{name}:{}: {length} lines", first + 1));
            }
        }
    }
    assert!(long.is_empty() && seen > 500, "of {seen}: {long:#?}");
}

/// A user has to know the traits of the prelude alone, and the front page says what each is for.
#[test]
fn the_prelude_has_a_bounded_number_of_traits() {
    let lib = fs::read_to_string(Path::new(ROOT).join("lagrange-runtime/src/lib.rs")).expect("the crate");
    let traits: BTreeSet<String> = sources("lagrange-runtime/src")
        .values()
        .flat_map(|text| text.split("pub trait ").skip(1).map(name_at_start).collect::<Vec<_>>())
        .collect();
    let prelude = code(&lib).split("pub mod prelude").nth(1).expect("the prelude").to_owned();
    let prelude = prelude.split("\n}").next().unwrap_or_default();
    let words: BTreeSet<&str> = prelude.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
    let known: Vec<&str> = traits.iter().map(String::as_str).filter(|name| words.contains(name)).collect();
    assert!((10..=16).contains(&known.len()), "{}: {known:?}", known.len());
    let table =
        lib.split("//! # Traits").nth(1).and_then(|rest| rest.split("//! # ").next()).expect("a table");
    let row = |name: &&str| {
        table.lines().any(|line| line.starts_with("//! |") && line.contains(&format!("[`{name}`]")))
    };
    let unexplained: Vec<&str> = known.into_iter().filter(|name| !row(name)).collect();
    assert!(unexplained.is_empty(), "no row of the front page: {unexplained:?}");
}

/// The identifier that a text begins with.
fn name_at_start(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}
