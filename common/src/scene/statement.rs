//! Statement of a scene, key by key: shows whether two scenes are equal, and where they differ.

use std::collections::BTreeMap;
use std::io;
use std::path::PathBuf;

use super::key_path::child;
use super::tree::{Node, Value};

/// Keys and values of a scene with those of the command line on top, and the files that it names.
///
/// Numbers are compared as numbers: `1` states the same as `1.0`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Statement {
    /// The values by their keys, lists by the numbers of their items: `walls[1].point[2]`.
    values: BTreeMap<String, String>,
    /// The files, in the order in which they are named.
    files: Vec<NamedFile>,
}

/// A file that a scene names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedFile {
    /// The path of the key, as `--set` takes it.
    pub key: String,
    /// The name as it was typed.
    pub name: String,
    /// Where it is.
    pub path: PathBuf,
}

impl Statement {
    pub(super) fn new(document: &Node, files: Vec<NamedFile>) -> Self {
        let mut values = BTreeMap::new();
        collect(document, "", &mut values);
        Self { values, files }
    }

    /// The files that the scene names, in the order in which they are read.
    #[must_use]
    pub fn files(&self) -> &[NamedFile] {
        &self.files
    }

    /// The values by their keys; of each file that the scene names, its length and a checksum in addition, so that a changed file
    /// is detected.
    ///
    /// # Errors
    /// The file that cannot be read, and why.
    pub fn entries(&self) -> Result<BTreeMap<String, String>, (PathBuf, io::Error)> {
        let mut entries = self.values.clone();
        for (number, NamedFile { path, .. }) in self.files.iter().enumerate() {
            let bytes = std::fs::read(path).map_err(|error| (path.clone(), error))?;
            let sum = format!(
                "{} bytes, checksum {:08x}",
                bytes.len(),
                crc32fast::hash(&bytes)
            );
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            entries.insert(format!("content of file {} ({name})", number + 1), sum);
        }
        Ok(entries)
    }
}

/// Differences between two lists of [`Statement::entries`], a line each, but for the keys `allowed`, in which `[]` stands for any
/// entry of a list, and `*` at the end for whatever follows.
#[must_use]
pub fn differences(
    before: &BTreeMap<String, String>,
    now: &BTreeMap<String, String>,
    allowed: &[&str],
) -> Vec<String> {
    let keys: std::collections::BTreeSet<&String> = before.keys().chain(now.keys()).collect();
    let difference = |key: &String| {
        let line = match (before.get(key), now.get(key)) {
            (Some(then), Some(now)) if then == now => return None,
            (Some(then), Some(now)) => format!("{key}: {then} then, {now} now"),
            (Some(then), None) => format!("{key}: {then} then, absent now"),
            (None, now) => format!("{key}: absent then, {} now", now.map_or("", |now| now)),
        };
        let kind: String = key.chars().filter(|c| !c.is_ascii_digit()).collect();
        let is_allowed = allowed
            .iter()
            .any(|allowed| match allowed.strip_suffix('*') {
                Some(beginning) => key.starts_with(beginning),
                None => *allowed == key || *allowed == kind,
            });
        (!is_allowed).then_some(line)
    };
    keys.into_iter().filter_map(difference).collect()
}

fn collect(node: &Node, path: &str, values: &mut BTreeMap<String, String>) {
    let mut state = |value: String| {
        values.insert(path.to_owned(), value);
    };
    match &node.value {
        Value::String(text) => state(format!("{text:?}")),
        Value::Integer(number) => state(number.to_string()),
        // A float that is whole prints like an integer.
        Value::Float(number) => state(number.to_string()),
        Value::Boolean(value) => state(value.to_string()),
        Value::Datetime => state("a date".to_owned()),
        Value::LeftOut => {}
        Value::Array(items) => {
            if items.is_empty() {
                state("[]".to_owned());
            }
            for (index, item) in items.iter().enumerate() {
                collect(item, &format!("{path}[{index}]"), values);
            }
        }
        Value::Table(table) => {
            if table.entries.is_empty() && !path.is_empty() {
                state("{}".to_owned());
            }
            for entry in &table.entries {
                collect(&entry.node, &child(path, &entry.key), values);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::{Files, parse_scene};

    const SCENE: &str = "gravity = [0, 0, -9.81]\n[time]\nend = 1\nstep = 1e-5\n\
        [domain]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[output]\ninterval = 0.1\n";

    fn entries(text: &str, overrides: &[&str]) -> BTreeMap<String, String> {
        let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
        let scene = parse_scene(Path::new("a.toml"), text, &overrides, Files::Unchecked).unwrap();
        scene.statement.entries().unwrap()
    }

    #[test]
    fn what_differs_is_named_with_both_values() {
        let before = entries(SCENE, &[]);
        assert_eq!(before["gravity[2]"], "-9.81");
        let same = entries(&SCENE.replace("end = 1\n", "end = 1.0 # s\n"), &[]);
        assert_eq!(differences(&before, &same, &[]), [""; 0]);
        let now = entries(
            SCENE,
            &[
                "gravity=[0, 0, -1.62]",
                "seed=3",
                "time.end=2",
                "time.step=2e-5",
            ],
        );
        assert_eq!(
            differences(&before, &now, &["time.end"]),
            [
                "gravity[2]: -9.81 then, -1.62 now",
                "seed: absent then, 3 now",
                "time.step: 0.00001 then, 0.00002 now",
            ]
        );
    }

    #[test]
    fn a_changed_file_is_another_scene() {
        let folder = tempfile::tempdir().unwrap();
        let table = folder.path().join("grains.csv");
        let text = format!(
            "{SCENE}[materials.m]\ndensity = 2500\nnormal = {{ law = \"linear\", stiffness = 1e3, dissipation = 0 }}\n[[particles]]\nmaterial = \"m\"\nfile = \"grains.csv\"\n"
        );
        let read = |content: &str| {
            std::fs::write(&table, content).unwrap();
            let path = folder.path().join("a.toml");
            let scene = parse_scene(&path, &text, &[], Files::MustExist).unwrap();
            scene.statement.entries().unwrap()
        };
        let (before, now) = (read("x,y,z\n1,2,3\n"), read("x,y,z\n1,2,4\n"));
        let lines = differences(&before, &now, &[]);
        assert_eq!(lines.len(), 1, "{lines:?}");
        assert!(lines[0].starts_with("content of file 1 (grains.csv): 12 bytes"));
        assert_eq!(differences(&before, &before, &[]), [""; 0]);
    }
}
