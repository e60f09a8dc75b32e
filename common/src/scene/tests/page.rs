//! The page of the scene format has the tables of keys that the reader has, and the scene of all keys has each of them.
//!
//! `MERCURY_BLESS=1 cargo test -p common --lib scene::tests::page` writes the tables of the page anew, and adds keys to the sections of
//! that scene.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use super::super::SCENE;
use super::super::keys::{Absent, Kind, SceneKey, TableKeys, Variant, Variants};

const BEGIN: &str = "<!-- keys of ";
const END: &str = "<!-- end of keys -->";

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The tables inside a value.
fn table_of(kind: &'static Kind) -> Option<&'static TableKeys> {
    match kind {
        Kind::List(_, of) => table_of(of),
        Kind::Named(keys) => Some(keys),
        Kind::OneOf(all) => all.iter().find_map(table_of),
        kind => kind.table(),
    }
}

/// All keys of a table with the variant that they belong to.
fn all_keys(table: &'static TableKeys) -> Vec<&'static SceneKey> {
    let common = table.keys.iter().copied().flatten();
    let more = table
        .variants()
        .flat_map(|variant| variant.keys.iter().copied().flatten());
    common.chain(more).collect()
}

/// The table that the keys of a path lead to, from the scene.
fn table_at(path: &str) -> &'static TableKeys {
    let mut table: &'static TableKeys = &SCENE;
    for name in path.split('.').filter(|name| *name != "scene") {
        let keys = all_keys(table);
        let key = keys.into_iter().find(|key| key.name == name);
        table = key
            .and_then(|key| table_of(&key.kind))
            .unwrap_or_else(|| panic!("{path}"));
    }
    table
}

fn code(text: &str) -> String {
    format!("`{text}`")
}

/// Permitted values at a key, in words.
fn range(kind: &Kind) -> String {
    let many = |count: usize| vec!["."; count].join(", ");
    match kind {
        Kind::Number(_, range) => range.text(),
        Kind::Whole(low, high) if *high > i64::MAX as u64 => format!("whole, >= {low}"),
        Kind::Whole(low, high) => format!("whole, {low} to {high}"),
        Kind::Flag => "true, false".to_owned(),
        Kind::Word(..) | Kind::Keyword(_) => {
            let words: Vec<String> = kind
                .words()
                .iter()
                .map(|w| code(&format!("{w:?}")))
                .collect();
            words.join(", ")
        }
        Kind::Diameters => code("\"1.5d\""),
        Kind::Numbers(_, count, range) => format!("`[{}]` {}", many(*count), range.text())
            .trim_end()
            .to_owned(),
        Kind::Row(units) => format!("`[{}]` in {}", many(units.len()), units.join(", ")),
        Kind::Components(_) => "`[., ., .]` of numbers and `\"free\"`".to_owned(),
        Kind::Interval(_) => "`[low, high]`".to_owned(),
        Kind::Direction => "a vector of any length > 0".to_owned(),
        Kind::Name | Kind::Line | Kind::Text => "text".to_owned(),
        Kind::File(_) => "file".to_owned(),
        Kind::Folder => "folder".to_owned(),
        Kind::Material => "a material".to_owned(),
        Kind::Clump => "a clump".to_owned(),
        Kind::List(_, of) => match range(of).as_str() {
            "" => "list of numbers".to_owned(),
            item => format!("list of: {item}"),
        },
        Kind::Table(_) | Kind::Named(_) => "table".to_owned(),
        Kind::Texts => "table of texts".to_owned(),
        Kind::Law(..) => "a [law](#laws)".to_owned(),
        Kind::OneOf(all) => {
            let all: Vec<String> = all.iter().map(range).collect();
            let all: Vec<&str> = all
                .iter()
                .map(|text| if text.is_empty() { "number" } else { text })
                .collect();
            let mut all = all;
            all.dedup();
            all.join("; ")
        }
    }
}

fn units(kind: &Kind) -> Vec<&'static str> {
    let mut units = match kind {
        Kind::OneOf(all) => all.iter().flat_map(units).collect(),
        Kind::List(_, of) => units(of),
        Kind::Row(units) => units[1..].to_vec(),
        kind => kind
            .unit()
            .into_iter()
            .filter(|unit| !unit.is_empty())
            .collect(),
    };
    units.dedup();
    units
}

/// Whether two tables have the same variants, but for some keys.
fn alike(one: &TableKeys, other: &TableKeys) -> bool {
    match (&one.variants, &other.variants) {
        (Variants::Word { of: one, .. }, Variants::Word { of: other, .. }) => {
            std::ptr::eq(*one, *other)
        }
        _ => false,
    }
}

/// Rows of a table of keys; those of a table below it follow its row, unless the page has it elsewhere.
fn rows(
    table: &'static TableKeys,
    prefix: &str,
    elsewhere: &[&'static TableKeys],
    text: &mut String,
) {
    let mut shown: BTreeSet<String> = BTreeSet::new();
    let mut keys = |groups: &'static [&'static [SceneKey]], text: &mut String| {
        let mut again = Vec::new();
        for key in groups.iter().copied().flatten() {
            let name = format!("{prefix}{}", key.name);
            let row = row(key, &name);
            if !shown.insert(row.clone()) {
                again.push(code(&name));
                continue;
            }
            text.push_str(&row);
            let is_elsewhere = |below: &&'static TableKeys| {
                elsewhere.iter().any(|other| std::ptr::eq(*other, *below))
            };
            match table_of(&key.kind).filter(|below| !is_elsewhere(below)) {
                None => {}
                // A part of a mixture has the keys of the whole.
                Some(below) if alike(table, below) => {
                    for key in below.keys.iter().copied().flatten() {
                        text.push_str(&self::row(key, &format!("{name}.{}", key.name)));
                    }
                }
                Some(below) => rows(below, &format!("{name}."), elsewhere, text),
            }
        }
        if !again.is_empty() {
            let _ = writeln!(text, "| {} | | | | as above |", again.join(", "));
        }
    };
    keys(table.keys, text);
    if let Variants::Word {
        key,
        text: what,
        absent,
        ..
    } = &table.variants
    {
        let words: Vec<String> = (table.variants())
            .filter(|variant| !is_absent(table, variant))
            .map(|variant| code(&format!("{:?}", variant.name)))
            .collect();
        let default = if absent.is_some() { "" } else { "needed" };
        let _ = writeln!(
            text,
            "| `{prefix}{key}` | | {} | {default} | {what} |",
            words.join(", ")
        );
    }
    for variant in table.variants() {
        let head = match &table.variants {
            Variants::Word { key, .. } if !is_absent(table, variant) => {
                format!("**`{prefix}{key} = {:?}`**", variant.name)
            }
            _ => format!("with **`{prefix}{}`**", variant.name),
        };
        let _ = writeln!(text, "| {head}: {} | | | | |", variant.text);
        keys(variant.keys, text);
    }
}

/// Whether a variant is the one without the word.
fn is_absent(table: &TableKeys, variant: &'static Variant) -> bool {
    match table.variants {
        Variants::Word { absent, .. } => absent.is_some_and(|absent| std::ptr::eq(absent, variant)),
        _ => false,
    }
}

fn row(key: &SceneKey, name: &str) -> String {
    let default = match key.absent {
        Absent::Needed => "needed".to_owned(),
        absent => absent.text(),
    };
    let (units, range) = (units(&key.kind).join(", "), range(&key.kind));
    format!(
        "| `{name}` | {units} | {range} | {default} | {} |\n",
        key.text
    )
}

#[test]
fn the_page_has_the_tables_of_keys() {
    let path = repository().join("docs/formats/scene.md");
    let page = fs::read_to_string(&path).unwrap();
    let places: Vec<&str> = (page.split(BEGIN).skip(1))
        .map(|rest| rest.split(" -->").next().unwrap())
        .collect();
    let elsewhere: Vec<&'static TableKeys> = places.iter().map(|place| table_at(place)).collect();
    let mut parts = page.split(BEGIN);
    let mut written = parts.next().unwrap().to_owned();
    for (place, part) in places.iter().zip(parts) {
        let end = part
            .find(END)
            .unwrap_or_else(|| panic!("the keys of {place} do not end"));
        let mut table =
            "| key | unit | range | default | meaning |\n|---|---|---|---|---|\n".to_owned();
        rows(table_at(place), "", &elsewhere, &mut table);
        let _ = write!(written, "{BEGIN}{place} -->\n\n{table}\n{}", &part[end..]);
    }
    if std::env::var_os("MERCURY_BLESS").is_some() {
        fs::write(&path, &written).unwrap();
    }
    let is_same = fs::read_to_string(&path).unwrap() == written;
    assert!(
        is_same,
        "{} is behind the tables of keys; MERCURY_BLESS=1 cargo test -p common --lib scene::tests::page writes them",
        path.display()
    );
}

/// Names of all keys and words of a table and of those below it.
fn names(
    table: &'static TableKeys,
    seen: &mut Vec<&'static TableKeys>,
    all: &mut BTreeSet<&'static str>,
) {
    if seen.iter().any(|other| std::ptr::eq(*other, table)) {
        return;
    }
    seen.push(table);
    if let Variants::Word { key, of, .. } = &table.variants {
        all.insert(key);
        all.extend(of.iter().map(|variant| variant.name));
    }
    for key in all_keys(table) {
        all.insert(key.name);
        all.extend(key.kind.words());
        if let Some(below) = table_of(&key.kind) {
            names(below, seen, all);
        }
    }
}

/// The keys of the format that a scene lacks.
fn missing(text: &str) -> Vec<&'static str> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || "_-+*".contains(c);
    let words: BTreeSet<&str> = text.split(|c| !is_word(c)).collect();
    let mut all = BTreeSet::new();
    names(&SCENE, &mut Vec::new(), &mut all);
    assert!(all.len() > 200, "{}", all.len());
    all.retain(|name| !words.contains(name));
    all.into_iter().collect()
}

/// The scene with each key of a section such as `[output]`, those that it lacks behind the others with their examples and texts, and with an entry
/// for each variant of a list such as `[[walls]]`.
fn with_keys(text: &str) -> String {
    let mut scene = with_variants(text);
    for section in all_keys(&SCENE) {
        let head = format!("\n[{}]", section.name);
        let (Some(table), Some(begin)) = (table_of(&section.kind), scene.find(&head)) else {
            continue;
        };
        let begin = begin + head.len();
        let end = (scene[begin..].find("\n[")).map_or(scene.len(), |end| begin + end);
        let end = begin + scene[begin..end].trim_end().len();
        let is_there = |key: &&SceneKey| {
            let mut lines = scene[begin..end].lines();
            lines.any(|line| {
                let line = line.trim_start_matches(['#', ' ']).strip_prefix(key.name);
                line.is_some_and(|rest| rest.trim_start().starts_with('='))
            })
        };
        let keys = table.keys.iter().copied().flatten();
        let lines: String = (keys.filter(|key| !is_there(key)))
            .map(|key| {
                let example = key.example.split("   # ").next().unwrap();
                format!("\n{} = {example}   # {}", key.name, key.text)
            })
            .collect();
        scene.insert_str(end, &lines);
    }
    scene
}

/// The scene with an entry of each list whose entries have variants by a word, for each variant that it lacks.
fn with_variants(text: &str) -> String {
    let mut scene = text.to_owned();
    let material = text.split("\n[materials.").nth(1).unwrap();
    let material = format!("\"{}\"", material.split(']').next().unwrap());
    for section in all_keys(&SCENE) {
        let head = format!("\n[[{}]]", section.name);
        let Some(table) = table_of(&section.kind) else {
            continue;
        };
        let (Variants::Word { key: word, of, .. }, Some(begin)) =
            (&table.variants, scene.find(&head))
        else {
            continue;
        };
        let end = scene.rfind(&head).unwrap() + 1;
        let mut end = (scene[end..].find("\n[")).map_or(scene.len(), |more| end + more);
        for variant in *of {
            let value = format!("\"{}\"", variant.name);
            if is_absent(table, variant) || scene[begin..end].contains(&value) {
                continue;
            }
            let needed = table.keys.iter().copied().flatten();
            let needed = needed.filter(|key| matches!(key.absent, Absent::Needed));
            let mut entry = format!("{head}\n{word} = {value}   # {}\n", variant.text);
            for key in needed.chain(variant.keys.iter().copied().flatten()) {
                let example = match key.kind {
                    Kind::Material => &material,
                    _ => key.example,
                };
                let _ = writeln!(entry, "{} = {example}", key.name);
            }
            scene.insert_str(end, &entry);
            end += entry.len();
        }
    }
    scene
}

#[test]
fn the_scene_of_all_keys_has_each_of_them() {
    let path = repository().join("scenes/keys.toml");
    let text = fs::read_to_string(&path).unwrap();
    let whole = with_keys(&text);
    if std::env::var_os("MERCURY_BLESS").is_some() && whole != text {
        fs::write(&path, &whole).unwrap();
    }
    let text = fs::read_to_string(&path).unwrap();
    let lacks = missing(&text);
    assert!(lacks.is_empty(), "scenes/keys.toml lacks {lacks:?}");
    assert!(
        text == whole,
        "a section of scenes/keys.toml lacks a key; MERCURY_BLESS=1 cargo test -p common --lib scene::tests::page adds it"
    );
}

/// A shape of a wall that is taken out comes back with its keys.
#[test]
fn a_variant_that_the_scene_lacks_is_added_to_its_list() {
    let text = fs::read_to_string(repository().join("scenes/keys.toml")).unwrap();
    let begin = text.find("\n[[walls]]\nname     = \"ball\"").unwrap();
    let end = begin + 1 + text[begin + 1..].find("\n[").unwrap();
    let without = format!("{}{}", &text[..begin], &text[end..]);
    let added = with_keys(&without);
    assert!(added.contains(
        "\n[[walls]]\nshape = \"sphere\"   # a sphere\nmaterial = \"a\"\norigin = [0, 0, 0]\n"
    ));
    assert_eq!(with_keys(&added), added);
}

/// A key that is taken out comes back into its section.
#[test]
fn a_key_that_the_scene_lacks_is_added_to_its_section() {
    let text = fs::read_to_string(repository().join("scenes/keys.toml")).unwrap();
    let lines = text.split_inclusive('\n');
    let without: String = lines
        .filter(|line| !line.starts_with("track_every "))
        .collect();
    assert_eq!(missing(&without), ["track_every"]);
    let added = with_keys(&without);
    let [output, key] = ["\n[output]", "\ntrack_every = "].map(|head| added.find(head).unwrap());
    assert!(!added[output + 1..key].contains("\n["));
    assert_eq!(missing(&added), [""; 0]);
}
