//! No input makes the reader panic, and every error has a place.

use std::path::Path;

use proptest::prelude::*;

use super::bad::completed;
use crate::scene::*;

fn read(text: &str, overrides: &[String]) -> Result<Scene, SceneErrors> {
    parse_scene(Path::new("garbage.toml"), text, overrides, Files::Unchecked)
}

/// Printing reads places and spans: it must not panic either, and names the file and a line.
fn check(result: Result<Scene, SceneErrors>, lines: usize) {
    if let Err(SceneErrors(errors)) = result {
        assert!(!errors.is_empty());
        for error in errors {
            let line = error.place.line();
            assert!(line >= 1 && line <= lines + 1, "line {line} of {lines}");
            assert!(error.place.column() >= 1);
            let text = error.to_string();
            assert!(
                text.starts_with("garbage.toml:") || text.starts_with("--set"),
                "{text}"
            );
        }
    }
}

/// All sections with all kinds of values: the contract's own example where it is at hand.
fn rich_scene() -> String {
    let keys = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes/keys.toml");
    match std::fs::read_to_string(&keys) {
        Ok(text) => text,
        Err(_) => {
            assert!(
                std::env::var_os("CI").is_none(),
                "{} is missing",
                keys.display()
            );
            eprintln!(
                "skipped: {} is missing; a small scene instead",
                keys.display()
            );
            completed("title = \"small\"\n")
        }
    }
}

proptest! {
    #[test]
    fn random_text_never_panics(text in "\\PC{0,200}") {
        check(read(&text, &[]), text.lines().count());
    }

    #[test]
    fn random_toml_like_text_never_panics(text in "([a-z\\[\\]{}=.,\"#\n 0-9eE+-]|normal|law|é){0,120}") {
        check(read(&completed(&text), &[]), completed(&text).lines().count());
    }

    #[test]
    fn random_overrides_never_panic(argument in "([a-z\\[\\]{}=.,\"' 0-9é]|time|end|materials|glass){0,30}") {
        check(read(&completed(""), &[argument]), completed("").lines().count());
    }

    #[test]
    fn a_missing_line_never_panics(line in 0_usize..400) {
        let text = rich_scene();
        let lines: Vec<&str> = text.lines().collect();
        let gone = line % lines.len();
        let rest: Vec<&str> =
            lines.iter().enumerate().filter(|(i, _)| *i != gone).map(|(_, line)| *line).collect();
        check(read(&rest.join("\n"), &[]), rest.len());
    }

    #[test]
    fn a_changed_character_never_panics(at in 0_usize..20_000, with in any::<char>()) {
        let text = rich_scene();
        let mut characters: Vec<char> = text.chars().collect();
        let at = at % characters.len();
        characters[at] = with;
        let text: String = characters.into_iter().collect();
        check(read(&text, &[]), text.split('\n').count());
    }
}
