//! The JSON schema of scenes: every scene fits it, and what the reader refuses of single keys does not.
//!
//! `MERCURY_BLESS=1 cargo test -p tests --test scenes schema` writes `docs/formats/scene.schema.json` anew.

use std::fs;
use std::path::{Path, PathBuf};

use jsonschema::Validator;
use mercury_solver::plan::schema;
use mercury_solver::starters::STARTERS;
use serde_json::Value;

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The scenes of a folder and those below it.
fn scenes(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let entries = fs::read_dir(folder).expect("the folder can be listed");
    for entry in entries {
        let path = entry.expect("the folder can be listed").path();
        if path.is_dir() {
            files.extend(scenes(&path));
        } else if path.extension().is_some_and(|ending| ending == "toml") {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// A document as the schema sees it; `None` if it is no TOML, or no scene: a clump, a study or the law of a size distribution.
fn document(path: &Path) -> Option<Value> {
    let bytes = fs::read(path).expect("the file can be read");
    let document: Value = toml::from_str(&String::from_utf8(bytes).ok()?).ok()?;
    let is_scene = ["time", "domain", "materials", "walls"]
        .iter()
        .any(|key| !document[key].is_null());
    is_scene.then_some(document)
}

fn validator() -> Validator {
    jsonschema::draft202012::new(&schema()).expect("the schema is one")
}

/// Mistakes of a document, a line for each place.
fn mistakes(validator: &Validator, document: &Value) -> String {
    let errors = validator.iter_errors(document);
    let lines: Vec<String> = errors
        .map(|error| format!("  {}: {error}", error.instance_path()))
        .collect();
    lines.join("\n")
}

#[test]
fn the_committed_schema_is_that_of_the_tables() {
    jsonschema::draft202012::meta::validate(&schema()).expect("a schema of draft 2020-12");
    let path = repository().join("docs/formats/scene.schema.json");
    if std::env::var_os("MERCURY_BLESS").is_some() {
        let text = serde_json::to_string_pretty(&schema()).expect("JSON");
        fs::write(&path, text + "\n").expect("the schema can be written");
    }
    let committed: Value = fs::read_to_string(&path)
        .ok()
        .and_then(|text| serde_json::from_str(&text).ok())
        .unwrap_or_default();
    assert!(
        committed == schema(),
        "docs/formats/scene.schema.json is behind the tables of keys; MERCURY_BLESS=1 cargo test -p tests --test scenes schema writes it"
    );
}

#[test]
fn every_scene_fits_the_schema() {
    let validator = validator();
    let mut wrong = Vec::new();
    let mut count = 0;
    let folders = [
        "scenes",
        "tests/scenes/good",
        "../shared/scenes",
        "shared/scenes",
    ];
    for folder in folders.map(|folder| repository().join(folder)) {
        for path in if folder.is_dir() {
            scenes(&folder)
        } else {
            Vec::new()
        } {
            let Some(document) = document(&path) else {
                continue;
            };
            count += 1;
            let mistakes = mistakes(&validator, &document);
            if !mistakes.is_empty() {
                wrong.push(format!("{}\n{mistakes}", path.display()));
            }
        }
    }
    for starter in &STARTERS {
        for (name, text) in starter
            .files
            .iter()
            .filter(|(name, _)| name.ends_with(".toml"))
        {
            let document: Value = toml::from_str(text).expect("TOML");
            if document["time"].is_null() {
                continue;
            }
            count += 1;
            let mistakes = mistakes(&validator, &document);
            if !mistakes.is_empty() {
                wrong.push(format!("starter {} {name}\n{mistakes}", starter.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(count > 60, "only {count} scenes");
}

/// Of the reader's messages those of single keys: unknown, of a wrong type, out of range.
const OF_SINGLE_KEYS: [&str; 8] = [
    "is not a known key",
    "expected a ",
    "expected true or false",
    "must be > ",
    "must be >= ",
    "must lie in ",
    "there is no shape",
    "is missing",
];

#[test]
fn what_is_wrong_with_single_keys_does_not_fit_the_schema() {
    let validator = validator();
    let mut fit = Vec::new();
    let mut count = 0;
    for path in scenes(&repository().join("tests/scenes/bad")) {
        let name = path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let said = fs::read_to_string(path.with_extension("stderr")).unwrap_or_default();
        // Mistakes in a file that the scene names are no matter of the schema.
        let of_scene =
            |line: &&str| line.starts_with(&format!("{name}.toml:")) && !line.contains(".file: ");
        let is_of_single = said
            .lines()
            .filter(of_scene)
            .any(|line| OF_SINGLE_KEYS.iter().any(|text| line.contains(text)));
        let Some(document) = document(&path).filter(|_| is_of_single) else {
            continue;
        };
        count += 1;
        if validator.is_valid(&document) {
            fit.push(format!("{name}\n{said}"));
        }
    }
    assert!(fit.is_empty(), "{}", fit.join("\n"));
    assert!(count > 15, "only {count} scenes");
}
