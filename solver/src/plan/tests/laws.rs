//! The laws of a scene as the solver's own tables of keys read them, and the pages that follow from these tables.
//!
//! `bad_laws.txt` holds what is wrong and the words for it, as `bad_scenes.txt` of the reader does.

use std::path::Path;

use mercury_common::scene::{Files, Given, Key, KeyDefault, LawKeys, LawPart, Range};

use crate::plan::parse_scene;
use mercury_engine::contact::law_keys;

/// Sections that a case leaves out.
const GOOD: [(&str, &str); 4] = [
    ("[time]", "end = 1.0\nstep = 0.1"),
    ("[domain]", "min = [0.0, 0.0, 0.0]\nmax = [1.0, 1.0, 1.0]"),
    ("[output]", "interval = 0.1"),
    (
        "[materials.glass]",
        "density = 2500.0\nnormal = { law = \"linear\", stiffness = 1e3, dissipation = 0.0 }",
    ),
];

fn errors_of(part: &str) -> String {
    let mut scene = part.to_owned();
    for (head, body) in GOOD {
        if !part.lines().any(|line| line.trim() == head) {
            scene.push_str(&format!("\n{head}\n{body}\n"));
        }
    }
    match parse_scene(Path::new("bad.toml"), &scene, &[], Files::Unchecked) {
        Ok(_) => "no error".to_owned(),
        Err(errors) => errors.to_string(),
    }
}

#[test]
fn every_mistake_in_a_law_is_named() {
    let laws = law_keys().into_iter();
    let normal = laws.filter(|law| law.parts.contains(&LawPart::Normal));
    let normal: Vec<&str> = normal.map(|law| law.name).collect();
    let cases = include_str!("bad_laws.txt").replace("{normal laws}", &normal.join(", "));
    let cases = cases.split("### ").skip(1);
    let mut differences = String::new();
    let mut count = 0;
    for case in cases {
        let (name, rest) = case.split_once('\n').expect("a case has a name");
        let (part, expected) = rest.split_once("---\n").expect("a case has an expectation");
        let errors = errors_of(part);
        if errors != expected.trim_end() {
            differences.push_str(&format!("### {name}\n{part}---\n{errors}\n\n"));
        }
        count += 1;
    }
    assert!(count >= 22, "only {count} cases");
    assert!(differences.is_empty(), "these differ:\n\n{differences}");
}

/// A value that the key takes, as TOML.
fn example(key: &Key) -> String {
    match key.range {
        Range::Any | Range::Positive | Range::NonNegative | Range::NotBelow(_) => "2.0".to_owned(),
        Range::Over(low) => format!("{:?}", low + 1.0),
        Range::Fraction | Range::PoissonRatio => "0.25".to_owned(),
        Range::Between(low, high)
        | Range::Above(low, high)
        | Range::Below(low, high)
        | Range::Inside(low, high) => format!("{:?}", 0.5 * (low + high)),
        Range::Words(words) => format!("{:?}", words[words.len() - 1]),
    }
}

/// The tables of a material (by part) whose every key is given, for one way through the law's choices.
fn full(law: &LawKeys, part: LawPart, way: usize) -> String {
    let mut chosen: Vec<&str> = Vec::new();
    for ways in law.choices {
        let done = ways
            .iter()
            .any(|way| way.iter().all(|key| chosen.contains(key)));
        if !done {
            chosen.extend(ways[way.min(ways.len() - 1)]);
        }
    }
    let chosen = |key: &str| !law.is_choice(key) || chosen.contains(&key);
    let keys = law.keys.iter().filter(|key| chosen(key.name));
    let keys: Vec<String> = keys
        .map(|key| format!("{} = {}", key.name, example(key)))
        .collect();
    let table = format!(
        "{} = {{ law = {:?}, {} }}\n",
        part.word(),
        law.name,
        keys.join(", ")
    );
    let normal = match part {
        LawPart::Normal => "",
        _ => "normal = { law = \"linear\", stiffness = 1.0, restitution = 0.5 }\n",
    };
    format!("[materials.glass]\ndensity = 1.0\n{normal}{table}")
}

#[test]
fn every_key_of_every_law_is_read_and_its_range_is_kept() {
    for law in law_keys() {
        for &part in law.parts {
            for way in 0..2 {
                let scene = full(law, part, way);
                assert_eq!(errors_of(&scene), "no error", "{scene}");
            }
            for key in law.keys {
                let wrong = match key.range {
                    Range::Words(_) => "\"nonsense\"",
                    _ => "-7.0",
                };
                let scene = (0..2).map(|way| full(law, part, way));
                let scene = scene.map(|scene| {
                    let right = format!("{} = {}", key.name, example(key));
                    scene.replacen(&right, &format!("{} = {wrong}", key.name), 1)
                });
                let scene = scene.into_iter().find(|scene| scene.contains(wrong));
                let Some(scene) = scene else {
                    continue;
                };
                let errors = errors_of(&scene);
                let path = format!("materials.glass.{}.{}: ", part.word(), key.name);
                assert!(errors.contains(&path), "{scene}\n{errors}");
            }
        }
    }
}

#[test]
fn tables_of_keys_are_whole() {
    let laws = law_keys();
    for (index, law) in laws.iter().enumerate() {
        let same = |other: &&LawKeys| {
            other.name == law.name && other.parts.iter().any(|part| law.parts.contains(part))
        };
        assert!(!laws[..index].iter().any(same), "{} twice", law.name);
        for ways in law.choices {
            for key in ways.iter().copied().flatten() {
                let found = law.key(key).unwrap_or_else(|| panic!("{key} has no row"));
                assert_eq!(found.default, KeyDefault::Needed, "{key}");
            }
        }
        for key in law.keys {
            if let Range::NotBelow(other) = key.range {
                assert!(law.key(other).is_some(), "{other}");
            }
            if let (Range::Words(words), KeyDefault::Word(word, _)) = (key.range, key.default) {
                assert!(words.contains(&word));
            }
        }
    }
}

#[test]
fn defaults_arrive_with_the_place_where_they_could_stand() {
    let text = format!(
        "[time]\nend = 1.0\nstep = 0.1\n[domain]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[output]\ninterval = 0.1\n{}",
        "[materials.m]\ndensity = 1.0\nnormal = { law = \"hertz\", effective_modulus = 1e6, damping = 0.1 }\n\
         tangential = { law = \"mindlin\", friction = 0.5, damping = \"default\" }\n"
    );
    let scene = parse_scene(Path::new("test.toml"), &text, &[], Files::Unchecked)
        .unwrap_or_else(|errors| panic!("{errors}"));
    let tangential = scene.materials[0].tangential.as_ref().expect("a law");
    let factor = tangential
        .values
        .get("stiffness_factor")
        .expect("a default");
    assert_eq!(factor.value, Given::Number(2.0 / 3.0));
    assert_eq!(
        factor.place.key(),
        "materials.m.tangential.stiffness_factor"
    );
    assert_eq!(tangential.values.word("damping"), Some("default"));
    assert_eq!(tangential.values.number("damping"), None);
    assert_eq!(tangential.values.get("static_friction"), None);
}

/// Both pages lie in the repository of the solver.
fn page(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name)
}

/// `word` as code.
fn code(word: &str) -> String {
    format!("`{word}`")
}

/// The table of all keys of all laws, as the page of the format has it.
fn table_of_keys() -> String {
    let mut text =
        "| key | unit | range | default | of two materials | meaning |\n|---|---|---|---|---|---|\n"
            .to_owned();
    let laws = law_keys();
    let mut done: Vec<&LawKeys> = Vec::new();
    for law in &laws {
        // Laws of the same keys stand together.
        if done
            .iter()
            .any(|other| other.keys == law.keys && other.parts == law.parts)
        {
            continue;
        }
        done.push(law);
        let same = laws
            .iter()
            .filter(|other| other.keys == law.keys && other.parts == law.parts);
        let (names, texts): (Vec<String>, Vec<&str>) =
            same.map(|law| (code(law.name), law.text)).unzip();
        let parts: Vec<String> = law.parts.iter().map(|part| code(part.word())).collect();
        let mut head = format!(
            "**{} {}**: {}",
            parts.join(", "),
            names.join(", "),
            texts.join("; ")
        );
        for ways in law.choices {
            let ways: Vec<String> = ways
                .iter()
                .map(|way| {
                    let keys: Vec<String> = way.iter().map(|key| code(key)).collect();
                    keys.join(" with ")
                })
                .collect();
            head += &format!("; {}", ways.join(" or "));
        }
        text += &format!("| {head} | | | | | |\n");
        for key in law.keys {
            let default = match key.default {
                KeyDefault::Needed if law.is_choice(key.name) => "one way".to_owned(),
                KeyDefault::Needed => "needed".to_owned(),
                KeyDefault::Number(number) if number == 2.0 / 3.0 => "2/3".to_owned(),
                KeyDefault::Number(number) => format!("{number}"),
                KeyDefault::Open(then) => then.to_owned(),
                KeyDefault::Word(word, "") => code(&format!("{word:?}")),
                KeyDefault::Word(word, meaning) => {
                    format!("{}: {meaning}", code(&format!("{word:?}")))
                }
            };
            text += &format!(
                "| {} | {} | {} | {default} | {} | {} |\n",
                code(key.name),
                key.unit,
                key.range.text(),
                key.mixing.text(),
                key.text
            );
        }
    }
    text
}

/// The part of a page from `begin`, the head of a line, to `end` is `text`; it is written where that is wished for.
fn assert_written(name: &str, (begin, end): (&str, &str), text: &str) {
    let path = page(name);
    let whole = std::fs::read_to_string(&path).expect("the page can be read");
    let from = whole.find(begin).expect("where the tables begin");
    let from = from + whole[from..].find('\n').expect("a line") + 1;
    let to = from + whole[from..].find(end).expect("where they end");
    if std::env::var_os("MERCURY_BLESS").is_some() {
        let blessed = format!("{}{text}{}", &whole[..from], &whole[to..]);
        std::fs::write(&path, blessed).expect("the page can be written");
    } else {
        assert!(
            whole[from..to] == *text,
            "{} is behind the laws' tables of keys; MERCURY_BLESS=1 cargo test -p solver --lib laws:: writes\n{text}",
            path.display()
        );
    }
}

#[test]
fn the_page_of_the_format_has_the_tables_of_keys() {
    let marks = ("<!-- laws:", "<!-- end of laws -->");
    let table = format!("\n{}\n", table_of_keys());
    assert_written("docs/formats/scene.md", marks, &table);
}

/// A line for each law: its parts, its name, its keys with units or words.
#[test]
fn the_scene_of_all_keys_has_every_law_and_every_key() {
    let mut text = String::new();
    for law in law_keys() {
        let key = |key: &Key| match (key.range, key.unit) {
            (Range::Words(words), _) => format!("{} ({})", key.name, words.join(" | ")),
            (_, "") => key.name.to_owned(),
            (_, unit) => format!("{} ({unit})", key.name),
        };
        let keys: Vec<String> = law.keys.iter().map(key).collect();
        let parts: Vec<&str> = law.parts.iter().map(|part| part.word()).collect();
        let (parts, keys) = (parts.join(", "), keys.join(", "));
        let line = format!("# {parts:<17} {:<17} {keys}", law.name);
        text += &format!("{}\n", line.trim_end());
    }
    assert_written("scenes/keys.toml", ("# every law:", "# end of laws"), &text);
}
