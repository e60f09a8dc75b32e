//! Each key of the tables of keys is read with its example, and refused with what may not stand there.

use std::path::Path;

use super::super::keys::{Absent, Kind, SceneKey, TableKeys, Variant, Variants};
use super::super::{Files, SCENE, parse_scene};

/// A key that only one variant may have.
const OF_ONE_VARIANT: [(&str, &str); 1] = [("wear", "mesh")];

/// Keys that stand in the place of another one, and what goes with them.
const INSTEAD: [(&str, &str, &str); 3] = [
    ("pressure", "force", ""),
    ("area", "force", "pressure = -1e4"),
    ("lattice", "position", ""),
];

/// A table of the scene under test.
#[derive(Clone, Copy)]
struct Case {
    table: &'static TableKeys,
    variant: Option<&'static Variant>,
}

impl Case {
    fn all(table: &'static TableKeys) -> Vec<Self> {
        let of = |variant| Self { table, variant };
        match table.variants {
            Variants::None => vec![of(None)],
            _ => table.variants().map(|variant| of(Some(variant))).collect(),
        }
    }

    /// The table with what it needs, and with this value of a key.
    fn with(self, name: &str, value: &str) -> String {
        let mut entries = Vec::new();
        if let (Variants::Word { key, absent, .. }, Some(variant)) =
            (&self.table.variants, self.variant)
            && !absent.is_some_and(|absent| std::ptr::eq(absent, variant))
        {
            let word = if *key == name {
                value.to_owned()
            } else {
                format!("{:?}", variant.name)
            };
            entries.push(format!("{key} = {word}"));
        }
        let chosen = |key: &str| {
            self.table
                .choices
                .iter()
                .find(|choice| choice.keys.contains(&key))
        };
        let instead = INSTEAD.iter().find(|(key, ..)| *key == name);
        // A list of droplets needs no nozzle.
        let is_free = value.contains("\"points\"");
        for key in self.table.of(self.variant) {
            let needed = match key.absent {
                Absent::Needed => true,
                Absent::When(_) => {
                    !is_free && instead.is_none_or(|(_, other, _)| *other != key.name)
                }
                _ => false,
            };
            // Of a choice the first key, unless this one is one of it.
            let is_first = chosen(key.name).is_some_and(|choice| {
                choice.needed && choice.keys[0] == key.name && !choice.keys.contains(&name)
            });
            if key.name == name {
                entries.push(format!("{name} = {value}"));
            } else if needed || is_first {
                entries.push(format!("{} = {}", key.name, example(key)));
            }
        }
        let with = instead.map(|(_, _, with)| (*with).to_owned());
        entries.extend(with.filter(|with| !with.is_empty()));
        format!("{{ {} }}", entries.join(", "))
    }
}

/// The example's value without its comment.
fn example(key: &SceneKey) -> &str {
    key.example.split("   #").next().unwrap_or_default()
}

/// A scene with this value of a key at the top level.
fn scene(name: &str, value: &str) -> String {
    let law = "{ law = \"linear\", stiffness = 1e3, restitution = 0.5 }";
    let material = |name: &str| format!("{name} = {{ density = 2500.0, normal = {law} }}");
    let mut materials = vec![material("glass"), material("steel")];
    let mut clumps = vec!["rod = { file = \"rod.clump.toml\", material = \"glass\" }".to_owned()];
    let one =
        "{ name = \"first\", material = \"glass\", radius = 1e-3, position = [0.05, 0.05, 0.05] }";
    let mut lines = vec![format!("particles = [{one}]")];
    match name {
        "materials" => materials.push(format!("tested = {value}")),
        "clumps" => clumps.push(format!("tested = {value}")),
        "particles" => lines = vec![format!("particles = [{one}, {value}]")],
        _ => {
            let key = key_of(&SCENE, name);
            let list = matches!(key.kind, Kind::List(..)) && !value.starts_with('[');
            let value = if list {
                format!("[{value}]")
            } else {
                value.to_owned()
            };
            lines.push(format!("{name} = {value}"));
        }
    }
    for section in ["time", "domain", "output"] {
        if section != name {
            lines.push(format!("{section} = {}", example(key_of(&SCENE, section))));
        }
    }
    lines.push(format!("materials = {{ {} }}", materials.join(", ")));
    lines.push(format!("clumps = {{ {} }}", clumps.join(", ")));
    lines.join("\n")
}

fn key_of(table: &'static TableKeys, name: &str) -> &'static SceneKey {
    let key = table.of(None).find(|key| key.name == name);
    key.unwrap_or_else(|| panic!("{name}"))
}

/// Errors of the reader for a scene; empty for a good one.
fn answer(text: &str) -> String {
    match parse_scene(Path::new("a.toml"), text, &[], Files::Unchecked) {
        Ok(_) => String::new(),
        Err(errors) => errors.to_string(),
    }
}

/// The first number of an example as a text with a unit that is none.
fn with_unit(example: &str, unit: &str) -> Option<String> {
    let begin = example.find(|c: char| c.is_ascii_digit())?;
    let is_number = |c: char| c.is_ascii_digit() || ".e-".contains(c);
    let end = example[begin..]
        .find(|c| !is_number(c))
        .map_or(example.len(), |end| begin + end);
    let begin = if example[..begin].ends_with('-') {
        begin - 1
    } else {
        begin
    };
    let number = &example[begin..end];
    // An example may be such a text itself.
    let before = example[..begin].trim_end_matches('"');
    let after = match example[end..].split_once('"') {
        Some((_, after)) if before.len() < begin => after,
        _ => &example[end..],
    };
    Some(format!("{before}\"{number} {unit}\"{after}"))
}

/// Looks at each key of a table and of those below it. `place`: the scene in which the table stands so.
fn look(
    table: &'static TableKeys,
    path: &str,
    place: &dyn Fn(&str) -> String,
    seen: &mut Vec<&'static TableKeys>,
    found: &mut (usize, Vec<String>),
) {
    if seen.iter().any(|other| std::ptr::eq(*other, table)) {
        return;
    }
    seen.push(table);
    for case in Case::all(table) {
        let variant = case.variant.map_or("", |variant| variant.name);
        for key in table.of(case.variant) {
            if OF_ONE_VARIANT
                .iter()
                .any(|(name, with)| *name == key.name && *with != variant)
            {
                continue;
            }
            found.0 += 1;
            let path = format!("{path} {variant} {}", key.name);
            let text = place(&case.with(key.name, example(key)));
            let said = answer(&text);
            if !said.is_empty() {
                found
                    .1
                    .push(format!("{path}: its example is refused\n{text}\n{said}"));
            }
            let wrong = match &key.kind {
                Kind::Flag => Some(("1".to_owned(), "expected true or false, got a number")),
                Kind::Name | Kind::Line | Kind::Text | Kind::File(_) | Kind::Folder => {
                    Some(("1".to_owned(), "expected a string, got a number"))
                }
                Kind::Word(..) => Some(("\"qqqqqqqq\"".to_owned(), "there is no ")),
                Kind::Whole(..) => Some(("-1".to_owned(), "must be ")),
                Kind::Table(_) | Kind::Named(_) | Kind::Texts => {
                    Some(("1".to_owned(), "expected a table"))
                }
                Kind::List(..) => Some(("1".to_owned(), "expected a list")),
                kind => match kind.unit() {
                    Some("") => with_unit(example(key), "m").map(|text| (text, ", a length")),
                    Some(_) => {
                        with_unit(example(key), "parsec").map(|text| (text, "there is no unit"))
                    }
                    None => None,
                },
            };
            if let Some((value, message)) = wrong {
                let text = place(&case.with(key.name, &value));
                let said = answer(&text);
                if !said.contains(message) {
                    found.1.push(format!(
                        "{path}: {value} is not refused with {message:?}\n{text}\n{said}"
                    ));
                }
            }
            let below = |kind: &'static Kind| match kind {
                Kind::List(_, of) => (of.table(), true),
                kind => (kind.table(), false),
            };
            let all: Vec<&'static Kind> = match &key.kind {
                Kind::OneOf(all) => all.iter().collect(),
                kind => vec![kind],
            };
            for (below, is_list) in all.into_iter().map(below) {
                let Some(below) = below else { continue };
                let inner = |value: &str| {
                    let value = if is_list {
                        format!("[{value}]")
                    } else {
                        value.to_owned()
                    };
                    place(&case.with(key.name, &value))
                };
                look(below, &path, &inner, seen, found);
            }
        }
    }
}

#[test]
fn each_key_is_read_by_its_table() {
    let (mut found, mut seen) = ((0, Vec::new()), Vec::new());
    for key in SCENE.of(None) {
        let table = match &key.kind {
            Kind::List(_, of) => of.table(),
            Kind::Named(keys) => Some(*keys),
            kind => kind.table(),
        };
        match table {
            Some(table) => {
                let place = |value: &str| scene(key.name, value);
                look(table, key.name, &place, &mut seen, &mut found);
            }
            None => {
                let said = answer(&scene(key.name, example(key)));
                assert_eq!(said, "", "{}", key.name);
            }
        }
    }
    let (keys, wrong) = found;
    assert!(
        wrong.is_empty(),
        "{} of {keys}:\n{}",
        wrong.len(),
        wrong.join("\n\n")
    );
    assert!(keys > 250, "{keys}");
}
