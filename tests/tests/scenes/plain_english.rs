//! Texts of the project speak of things in standard technical English: a particle is "a particle", not "who".
//!
//! The test reads comments, string literals and names of functions in Rust files, and whole files of the other kinds.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Pronouns for people, and a verb whose object is a person.
const FORBIDDEN: [&str; 8] = [
    "who",
    "whom",
    "whoever",
    "nobody",
    "somebody",
    "anybody",
    "everybody",
    "told",
];

/// Phrases about people, and a phrasal verb, which may contain a forbidden word.
const ABOUT_PEOPLE: [&str; 11] = [
    "users who",
    "user who",
    "people who",
    "researchers who",
    "students who",
    "everyone who",
    // From the licence of a font.
    "persons to whom",
    // Authors of sources.
    "Wadell (1932), who",
    "Korn and Graubard 1998, Survey Methodology 24, 193, who",
    // Things that are.
    "told apart",
    // The rule itself, in CONTRIBUTING.md.
    "is not *who* or *nobody*",
];

/// Endings of the files that are read.
const ENDINGS: [&str; 6] = ["rs", "md", "py", "sh", "toml", "txt"];

/// Folders that hold no text of the project, wherever they are.
const FOREIGN: [&str; 3] = ["target", "vendor", "node_modules"];

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// All files with one of the endings, without hidden ones and those that `.gitignore` names at the root.
fn files(folder: &Path, root: &Path, ignored: &[String], found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let inside = path.strip_prefix(root).unwrap();
        if name.starts_with('.')
            || FOREIGN.contains(&name.as_str())
            || ignored.iter().any(|other| inside == Path::new(other))
        {
            continue;
        }
        if path.is_dir() && !path.is_symlink() {
            files(&path, root, ignored, found);
        } else if path.extension().is_some_and(|ending| {
            let ending = ending.to_string_lossy();
            ENDINGS.contains(&ending.as_ref())
        }) {
            found.push(path);
        }
    }
}

/// Rust files of the repository, by their paths from its root, with their code.
fn sources() -> Vec<(PathBuf, String)> {
    let root = repository();
    let mut all = Vec::new();
    for folder in fs::read_dir(&root).unwrap() {
        let folder = folder.unwrap().path();
        if folder.is_dir() && !folder.ends_with("target") && !folder.ends_with(".git") {
            files(&folder, &root, &[], &mut all);
        }
    }
    all.retain(|path| path.extension().is_some_and(|ending| ending == "rs"));
    let read = |path: PathBuf| {
        let inside = path.strip_prefix(&root).unwrap().to_owned();
        (inside, fs::read_to_string(path).unwrap())
    };
    all.into_iter().map(read).collect()
}

/// Rust code with everything blanked but comments, the words of names of functions, and string literals without `{placeholders}`.
/// Lines stay where they are.
fn prose(code: &str) -> String {
    let mut prose = String::with_capacity(code.len());
    let (mut rest, mut names_function) = (code, false);
    while let Some(next) = rest.chars().next() {
        let length = token(rest);
        let (text, after) = rest.split_at(length.max(next.len_utf8()));
        if text.starts_with("//") || text.starts_with("/*") {
            prose += text;
        } else if text.contains('"') && length > 0 {
            prose += &without_placeholders(text);
        } else if names_function && length > 0 {
            prose += &text.replace('_', " ");
        } else {
            prose.extend(text.chars().filter(|&c| c == '\n'));
            prose.push(' ');
        }
        names_function = text == "fn" || names_function && text == " ";
        rest = after;
    }
    prose
}

/// Bytes of the comment, string, character or word at the start of some code; 0 for anything else.
fn token(code: &str) -> usize {
    let until = |end: &str, from: usize| {
        code[from..]
            .find(end)
            .map_or(code.len(), |at| from + at + end.len())
    };
    if code.starts_with("//") {
        return code.find('\n').unwrap_or(code.len());
    }
    if code.starts_with("/*") {
        return until("*/", 2);
    }
    let word = code
        .find(|c: char| !c.is_alphanumeric() && c != '_')
        .unwrap_or(code.len());
    let after = &code[word..];
    if matches!(&code[..word], "r" | "br" | "cr") {
        let hashes = after.len() - after.trim_start_matches('#').len();
        if after[hashes..].starts_with('"') {
            return until(&format!("\"{}", "#".repeat(hashes)), word + hashes + 1);
        }
    }
    if matches!(&code[..word], "" | "b" | "c") && after.starts_with('"') {
        return word + quoted(after, '"');
    }
    if matches!(&code[..word], "" | "b") && after.starts_with('\'') {
        // A lifetime has no quote behind its first character.
        let is_character = after[1..].starts_with('\\') || after.chars().nth(2) == Some('\'');
        return word + if is_character { quoted(after, '\'') } else { 1 };
    }
    word
}

/// Bytes up to the closing quote of a literal that begins with one.
fn quoted(text: &str, quote: char) -> usize {
    let mut escaped = false;
    for (at, next) in text.char_indices().skip(1) {
        if next == quote && !escaped {
            return at + 1;
        }
        escaped = next == '\\' && !escaped;
    }
    text.len()
}

/// `"{who} has {}"` names a variable, not a person.
fn without_placeholders(text: &str) -> String {
    let mut left = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find('{') {
        let is_name = |c: char| c.is_alphanumeric() || "_:?.#$<>^+-".contains(c);
        let inside = &rest[at + 1..];
        let end = inside.find(|c| !is_name(c)).unwrap_or(inside.len());
        left += &rest[..at + 1];
        rest = if inside[end..].starts_with('}') {
            &inside[end..]
        } else {
            inside
        };
    }
    left + rest
}

/// Forbidden words of a text with their lines, counted from 1.
fn found_in(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let line = line.to_lowercase();
        if forbidden_in(&line).next().is_some() {
            let others = ABOUT_PEOPLE.iter().fold(line, |line, phrase| {
                line.replace(&phrase.to_lowercase(), "")
            });
            found.extend(forbidden_in(&others).map(|word| (number + 1, word.to_owned())));
        }
    }
    found
}

fn forbidden_in(line: &str) -> impl Iterator<Item = &str> {
    line.split(|c: char| !c.is_alphanumeric() && c != '_')
        .filter(|word| FORBIDDEN.contains(word))
}

#[test]
fn things_are_not_spoken_of_as_persons() {
    let root = repository();
    let ignored: Vec<String> = fs::read_to_string(root.join(".gitignore"))
        .unwrap()
        .lines()
        .filter_map(|line| line.strip_prefix('/'))
        .map(|name| name.trim_end_matches('/').to_owned())
        .collect();
    let mut all = Vec::new();
    files(&root, &root, &ignored, &mut all);
    all.sort();
    assert!(all.len() > 500, "the sources are not where they were");
    let mut wrong = String::new();
    for path in all {
        let inside = path.strip_prefix(&root).unwrap();
        // The words themselves.
        if inside == Path::new("tests/tests/scenes/plain_english.rs") {
            continue;
        }
        let text = String::from_utf8_lossy(&fs::read(&path).unwrap()).into_owned();
        let is_rust = path.extension().is_some_and(|ending| ending == "rs");
        let text = if is_rust { prose(&text) } else { text };
        for (line, word) in found_in(&text) {
            let _ = writeln!(wrong, "{}:{line}: {word}", inside.display());
        }
    }
    assert!(
        wrong.is_empty(),
        "{wrong}Name the thing (a particle, a thread, the caller, the user) instead, or rewrite the sentence in the passive. \
         Phrases about people go into ABOUT_PEOPLE."
    );
}

/// Words that stand twice in a comment from which on this is a half sentence that was left over.
const TWICE: usize = 7;

/// Scars of edits in the comments of Rust code, with their lines: a heading that runs into its text, a sentence that goes on behind its end, and
/// half a sentence that stands twice.
fn scars(code: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut words: Vec<(String, usize)> = Vec::new();
    let mut is_code = false;
    for (index, line) in code.lines().chain([""]).enumerate() {
        let Some(text) = line.trim_start().strip_prefix("//") else {
            let runs = words.windows(TWICE).enumerate();
            for (k, run) in runs {
                let is_same =
                    |other: &[(String, usize)]| other.iter().zip(run).all(|(a, b)| a.0 == b.0);
                if words[k + 1..].windows(TWICE).any(is_same) {
                    let run: Vec<&str> = run.iter().map(|(word, _)| word.as_str()).collect();
                    found.push((words[k].1, format!("stands twice: {}", run.join(" "))));
                    break;
                }
            }
            words.clear();
            continue;
        };
        let text = text.trim_start_matches(['/', '!']);
        let heading = ["# Errors ", "# Panics ", "# Safety "];
        if heading
            .iter()
            .any(|heading| text.trim_start().starts_with(heading))
        {
            found.push((index + 1, text.trim().to_owned()));
        }
        // Indented code, and code between backticks, is no prose.
        is_code ^= text.trim_start().starts_with("```");
        if is_code || text.starts_with("    ") {
            continue;
        }
        let prose: String = text.split('`').step_by(2).collect::<Vec<_>>().join("`");
        let is_word = |word: &str| word.len() > 2 && word.chars().all(|c| c.is_ascii_lowercase());
        let all: Vec<&str> = prose.split(' ').filter(|word| !word.is_empty()).collect();
        for pair in all.windows(2) {
            if pair[0].strip_suffix('.').is_some_and(is_word) && is_word(pair[1]) {
                found.push((
                    index + 1,
                    format!("goes on behind its end: {} {}", pair[0], pair[1]),
                ));
            }
        }
        let letters = |word: &str| {
            word.to_lowercase()
                .trim_matches(|c: char| !c.is_alphabetic())
                .to_owned()
        };
        let spoken = all
            .iter()
            .map(|word| letters(word))
            .filter(|word| !word.is_empty());
        words.extend(spoken.map(|word| (word, index + 1)));
    }
    found
}

#[test]
fn comments_have_no_scars_of_edits() {
    let half = "// One for all blocks of a thread, as it is large. It is\n// one for all blocks of a thread.\nlet a = 1;";
    assert_eq!(scars(half).len(), 1);
    assert_eq!(scars("/// # Errors If it fails.\n").len(), 1);
    assert_eq!(scars("// There is no limit. whatever\n").len(), 1);
    assert_eq!(
        scars("/// # Errors\n/// If it fails. It may, e.g. at `a. b`.\n"),
        []
    );
    let mut wrong = String::new();
    for (path, code) in sources() {
        for (line, scar) in scars(&code) {
            let _ = writeln!(wrong, "{}:{line}: {scar}", path.display());
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Beginnings of a doc comment that hide its noun.
const WITHOUT_NOUN: [&str; 2] = ["What", "The same"];

/// Beginnings of items that are private at the root of a module.
const PRIVATE: [&str; 9] = [
    "fn ", "const ", "static ", "struct ", "enum ", "type ", "trait ", "mod ", "unsafe ",
];

/// Doc comments without a noun, with their lines: of modules and of all items but private ones at the root of a module.
fn without_noun(code: &str) -> Vec<(usize, &str)> {
    let doc = |line: &&str| {
        let text = line.trim_start();
        text.starts_with("///") || text.starts_with("//!")
    };
    let lines: Vec<&str> = code.lines().collect();
    let mut found = Vec::new();
    for (index, line) in lines.iter().enumerate() {
        if !doc(line) || index > 0 && doc(&lines[index - 1]) {
            continue;
        }
        let text = line.trim_start_matches([' ', '/', '!']);
        let is_hidden = WITHOUT_NOUN.iter().any(|start| {
            let rest = text.strip_prefix(start);
            rest.is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
        });
        let is_item = |line: &&&str| !doc(line) && !line.trim_start().starts_with("#[");
        let item = lines[index..].iter().find(is_item);
        let is_private = !line.starts_with("//!")
            && item.is_some_and(|item| PRIVATE.iter().any(|start| item.starts_with(start)));
        if is_hidden && !is_private {
            found.push((index + 1, text));
        }
    }
    found
}

#[test]
fn doc_comments_begin_with_their_noun() {
    assert_eq!(without_noun("//! The same, twice.\n").len(), 1);
    assert_eq!(
        without_noun("/// What it is.\n#[must_use]\npub fn a() {}").len(),
        1
    );
    assert_eq!(
        without_noun("trait A {\n    /// The same.\n    fn a();\n}"),
        [(2, "The same.")]
    );
    let others =
        "/// Whatever.\n/// What follows is text.\npub struct A;\n/// What it does.\nfn f() {}";
    assert_eq!(without_noun(others), []);
    let mut wrong = String::new();
    for (path, code) in sources() {
        if path.starts_with("cloud") {
            continue;
        }
        for (line, text) in without_noun(&code) {
            let _ = writeln!(wrong, "{}:{line}: {text}", path.display());
        }
    }
    assert!(
        wrong.is_empty(),
        "{wrong}Begin with a noun or a verb: \"balance error\", not \"what is lost\"."
    );
}

#[test]
fn words_of_prose_are_found_and_those_of_code_are_not() {
    let found = |code: &str| found_in(&prose(code));
    let word = |line, word: &str| (line, word.to_owned());
    assert_eq!(found("let who = told(nobody);"), []);
    assert_eq!(
        found("f(); // Who\n/* nobody\n told */"),
        [word(1, "who"), word(2, "nobody"), word(3, "told")]
    );
    assert_eq!(
        found(r#"print("{who} is {told:?} by whom \" who")"#),
        [word(1, "whom"), word(1, "who")]
    );
    assert_eq!(
        found("r#\"a \" who\"#; told('\"', 'a', \"x\")"),
        [word(1, "who")]
    );
    assert_eq!(found("fn f<'a>(who: &'a str) {} // users who read"), []);
    assert_eq!(found("fn is_told() {}"), [word(1, "told")]);
    assert_eq!(found("fn are_told_apart() { told() }"), []);
    assert_eq!(found("\"a \\\n who\""), [word(2, "who")]);
    assert_eq!(found("// a whole"), []);
}
