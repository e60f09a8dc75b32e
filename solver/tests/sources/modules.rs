//! The modules of the engine and of the solver, and that none uses a module above it: the table of `ARCHITECTURE.md`.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Folders of sources.
const ENGINE: &str = "../engine/src";
const SOLVER: &str = "src";

/// Files in the folder of a feature that belong to another module, with the sources that they are of: the part of the step
/// (`wear/part.rs`, and what lies in `guard/part/`), what a scene says of it (`wear/plan/`), and its output (`wear/output.rs`).
const PARTS: [(&str, &str, &str); 3] = [
    (ENGINE, "part", "step"),
    (SOLVER, "plan", "plan"),
    (SOLVER, "output", "output"),
];

/// Arrows that still run upwards, each of which is owed: the list may only become shorter.
const OWED: &[(&str, &str)] = &[];

#[test]
fn no_module_uses_a_module_above_it() {
    let solver = Path::new(env!("CARGO_MANIFEST_DIR"));
    let modules = modules(&fs::read_to_string(solver.join("../ARCHITECTURE.md")).unwrap());
    assert!(
        modules.len() > 20,
        "the table of ARCHITECTURE.md was read as {modules:?}"
    );
    let place = |module: &str| modules.iter().position(|known| known == module);
    let mut wrong = String::new();
    let mut owed = Vec::new();
    for folder in [ENGINE, SOLVER] {
        let source = solver.join(folder);
        let files = sources(&source);
        assert!(files.len() > 50, "the sources are not where they were");
        for file in files {
            let inside = file.strip_prefix(&source).unwrap();
            let path = module_of(inside);
            let is_of = |&&(of, name, _): &&(&str, &str, &str)| {
                of == folder && path.get(1).is_some_and(|own| own == name)
            };
            let part = PARTS.iter().find(is_of).map(|(.., module)| *module);
            let Some(module) = part.or(path.first().map(String::as_str)) else {
                // lib.rs names all modules.
                continue;
            };
            if path.len() == 1 && folder == SOLVER && is_house(&file) {
                // It names its files.
                continue;
            }
            let Some(height) = place(module) else {
                let _ = writeln!(
                    wrong,
                    "{folder}/{}: `{module}` is not in the table of modules of ARCHITECTURE.md: it belongs above all modules that it uses",
                    inside.display()
                );
                continue;
            };
            for (line, to) in names_of_modules(&fs::read_to_string(&file).unwrap(), path.len()) {
                if place(&to).is_none_or(|below| below >= height) {
                    continue;
                }
                if OWED.contains(&(module, to.as_str())) {
                    owed.push((module.to_owned(), to));
                    continue;
                }
                let _ = writeln!(
                    wrong,
                    "{folder}/{}:{line}: `{module}` uses `{to}`, which lies above it",
                    inside.display()
                );
            }
        }
    }
    for &(from, to) in OWED {
        if !owed.contains(&(from.to_owned(), to.to_owned())) {
            let _ = writeln!(wrong, "`{from}` uses `{to}` no more: take it from OWED");
        }
    }
    assert!(
        wrong.is_empty(),
        "{wrong}An arrow is turned by passing the lower module a value (a number, a slice, a struct of its own) instead of what \
        the upper module knows, or by moving the shared type down. The order of the modules: {}",
        modules.join(" > ")
    );
}

/// The names in the first column of the table, from the top to the bottom.
fn modules(page: &str) -> Vec<String> {
    let table = page
        .split("\n## ")
        .find(|section| section.starts_with("The modules"));
    let rows = table
        .unwrap()
        .lines()
        .filter_map(|line| line.strip_prefix("| "));
    let cells = rows.filter_map(|row| row.split(" | ").next());
    let names = cells.flat_map(|cell| cell.split('`').skip(1).step_by(2));
    let names = names.map(|name| {
        name.trim_end_matches(".rs")
            .trim_end_matches('/')
            .to_owned()
    });
    names.collect()
}

/// Whether a file is the root of a feature in the solver.
fn is_house(file: &Path) -> bool {
    file.ends_with("mod.rs")
        && ["plan.rs", "plan"]
            .iter()
            .any(|plan| file.with_file_name(plan).exists())
}

/// All Rust files below a folder but those of tests.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap_or_default();
        if stem == "tests" {
            continue;
        }
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The module that a file below `src/` holds: `["plan", "mixing"]` for `plan/mixing.rs`.
fn module_of(inside: &Path) -> Vec<String> {
    let mut parts: Vec<String> = inside
        .with_extension("")
        .iter()
        .map(|part| part.to_string_lossy().into_owned())
        .collect();
    if matches!(parts.last().map(String::as_str), Some("mod" | "lib")) {
        parts.pop();
    }
    parts
}

/// Names behind `crate::`, and behind as many `super::` as lead out of a module this deep, with their lines. Comments and test
/// modules at the end of a file do not count.
fn names_of_modules(text: &str, depth: usize) -> Vec<(usize, String)> {
    let text = match text.find("#[cfg(test)]\nmod tests {") {
        Some(end) => &text[..end],
        None => text,
    };
    let code: String = text
        .split_inclusive('\n')
        .map(|line| match line.find("//") {
            Some(at) => line[..at].to_owned() + "\n",
            None => line.to_owned(),
        })
        .collect();
    let out = "super::".repeat(depth);
    let mut found = Vec::new();
    for start in ["crate::", out.as_str()] {
        for (at, _) in code.match_indices(start) {
            let before = code[..at].chars().next_back();
            if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
                continue;
            }
            let line = code[..at].matches('\n').count() + 1;
            let path = &code[at + start.len()..];
            for name in first_names(path) {
                // A plan and an output of a feature belong to the modules of these names.
                let of_feature = ["plan", "output"].into_iter().find(|part| {
                    let behind = path
                        .strip_prefix(&name)
                        .and_then(|path| path.strip_prefix("::"));
                    behind.is_some_and(|behind| behind.starts_with(part))
                });
                found.push((line, of_feature.map_or(name, str::to_owned)));
            }
        }
    }
    found
}

/// The first names of a path: one, or those of a group in braces.
fn first_names(path: &str) -> Vec<String> {
    let name = |path: &str| -> String {
        path.trim_start()
            .chars()
            .take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect()
    };
    let Some(group) = path.strip_prefix('{') else {
        return vec![name(path)];
    };
    let (mut depth, mut begins, mut names) = (0, true, Vec::new());
    for (at, letter) in group.char_indices() {
        if depth == 0 && begins {
            names.push(name(&group[at..]));
        }
        begins = false;
        match letter {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' => begins = true,
            _ => {}
        }
    }
    names.retain(|name| !name.is_empty());
    names
}

#[test]
fn arrows_are_found_however_they_are_written() {
    let text = "use crate::plan::Plan;\n// crate::run is a comment\nuse crate::{\n    forces::{Watch, blocks}, walls,\n};\n\
        use super::super::step::Engine;\nuse super::own;\nuse crate::wear::output::WearCsv;\nfn f() -> crate::output::FrameCopy {}\nuse mercury_crate::x;\n\
        #[cfg(test)]\nmod tests {\n    use crate::run::run;\n}\n";
    let found = names_of_modules(text, 2);
    let expected = [
        (1, "plan"),
        (3, "forces"),
        (3, "walls"),
        (8, "output"),
        (9, "output"),
        (6, "step"),
    ];
    let expected: Vec<_> = expected.map(|(line, name)| (line, name.to_owned())).into();
    assert_eq!(found, expected);
    assert_eq!(module_of(Path::new("plan/mixing/normal.rs")).len(), 3);
    assert_eq!(module_of(Path::new("plan/mod.rs")), ["plan"]);
    assert!(module_of(Path::new("lib.rs")).is_empty());
}
