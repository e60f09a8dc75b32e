//! Exact messages for scenes with errors.
//!
//! `bad_scenes.txt` holds the cases: a head `### name`, the part of a scene that is wrong, `---`, and the
//! full text of the errors. Sections that a case leaves out are those of [`GOOD`], put behind it, so a
//! case's lines count from 1.

use std::path::Path;

use crate::scene::*;

/// A good scene, section by section.
pub(super) const GOOD: [(&str, &str); 4] = [
    ("[time]", "end = 1.0\nstep = 0.1"),
    ("[domain]", "min = [0.0, 0.0, 0.0]\nmax = [1.0, 1.0, 1.0]"),
    ("[output]", "interval = 0.1"),
    (
        "[materials.glass]",
        "density = 2500.0\nnormal = { law = \"linear\", stiffness = 1e3, dissipation = 0.0 }",
    ),
];

/// The case with the sections of [`GOOD`] that it does not have.
pub(super) fn completed(part: &str) -> String {
    let mut scene = part.to_owned();
    for (head, body) in GOOD {
        if !part.lines().any(|line| line.trim() == head) {
            scene.push_str(&format!("\n{head}\n{body}\n"));
        }
    }
    scene
}

fn errors_of(part: &str) -> String {
    // Not under any root that exists, so that missing files have the same full path everywhere.
    let path = Path::new("/scenes/bad.toml");
    match parse_scene(path, &completed(part), &[], Files::MustExist) {
        Ok(_) => "no error".to_owned(),
        Err(errors) => errors.to_string().replace("/scenes/bad.toml", "bad.toml"),
    }
}

/// A key on which others hang may be misspelt: the part that is then not read must not vanish in silence.
#[test]
fn a_misspelt_key_on_which_the_rest_hangs_is_named() {
    let wall = "[[walls]]\nname = \"a\"\nshape = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmaterial = \"glass\"\n";
    for (part, misspelt) in [
        (
            format!("{wall}motion = [{{ knd = \"rotation\" }}]\n"),
            "knd",
        ),
        (
            "[[regions]]\nname = \"r\"\nregion = { shpe = \"box\" }\n".to_owned(),
            "shpe",
        ),
        (
            "[materials.glass]\ndensity = 1.0\nnormal = { lw = \"linear\", stiffness = 1.0 }\n"
                .to_owned(),
            "lw",
        ),
    ] {
        let errors = errors_of(&part);
        let help = format!("help: is it meant by `{misspelt}`?");
        assert!(
            errors.contains("is missing") && errors.contains(&help),
            "{errors}"
        );
    }
}

#[test]
fn every_mistake_is_named() {
    let cases: Vec<&str> = include_str!("bad_scenes.txt")
        .split("### ")
        .skip(1)
        .collect();
    assert!(cases.len() >= 40, "only {} cases", cases.len());
    let mut differences = String::new();
    for case in cases {
        let (name, rest) = case.split_once('\n').expect("a case has a name");
        let (part, expected) = rest.split_once("---\n").expect("a case has an expectation");
        let errors = errors_of(part);
        if !is_as_expected(&errors, expected.trim_end()) {
            differences.push_str(&format!("### {name}\n{part}---\n{errors}\n\n"));
        }
    }
    assert!(differences.is_empty(), "these differ:\n\n{differences}");
}

/// Line by line; an expected line that ends in `...` gives only the beginning of the line: a list of keys grows.
fn is_as_expected(errors: &str, expected: &str) -> bool {
    let is_line = |(found, expected): (&str, &str)| match expected.strip_suffix(" ...") {
        Some(begin) => found.starts_with(begin),
        None => found == expected,
    };
    errors.lines().count() == expected.lines().count()
        && errors.lines().zip(expected.lines()).all(is_line)
}

#[test]
fn the_good_scene_is_good() {
    assert_eq!(errors_of(""), "no error");
}

#[test]
fn files_that_are_no_text_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("latin1.toml");
    std::fs::write(&path, b"title = \"Gr\xfc\xdfe\"\n").expect("written");
    let errors = read_scene(&path, &[]).expect_err("not UTF-8").to_string();
    assert!(
        errors.contains("latin1.toml:1:12: this is not UTF-8 text"),
        "{errors}"
    );
    let errors = read_scene(folder.path(), &[])
        .expect_err("a folder")
        .to_string();
    assert!(errors.contains("the scene cannot be read"), "{errors}");
    let missing = read_scene(&folder.path().join("none.toml"), &[]).expect_err("missing");
    assert_eq!(missing.0.len(), 1);
    assert_eq!(missing.0[0].help, None);
    // A slip of the keyboard, or a name without its ending; a folder is no scene.
    std::fs::create_dir(folder.path().join("drun.toml")).expect("a folder");
    std::fs::write(folder.path().join("drum.toml"), "").expect("written");
    for slip in ["drum.tml", "durm.toml", "drum"] {
        let missing = read_scene(&folder.path().join(slip), &[]).expect_err("missing");
        let near = folder.path().join("drum.toml");
        let reported = format!("did you mean `{}`?", near.display());
        assert_eq!(missing.0[0].help, Some(reported), "{slip}");
    }
}

#[test]
fn windows_line_ends_and_tabs_keep_columns() {
    let text = completed("seed = 1\n")
        .replace('\n', "\r\n")
        .replace("end = 1.0", "\tend = \"ü\"");
    let errors = parse_scene(Path::new("w.toml"), &text, &[], Files::Unchecked).expect_err("bad");
    assert_eq!(
        errors.to_string(),
        "w.toml:4:8: time.end: expected a number, got a string\n    \tend = \"ü\"\n    \t      ^^^"
    );
}
