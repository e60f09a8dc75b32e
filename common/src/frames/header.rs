//! Facts about a run in the metadata of its frames: what the indices mean and where the particles live.

use std::collections::BTreeMap;

use glam::DVec3;

use super::FrameSchema;
use super::schema::{GRAVITY_KEY, TITLE_KEY};

/// Facts about the run in a file of particles or contacts. Everything is optional to a reader.
///
/// Lists are one key per entry (`material.0`, `material.1`, ...) and vectors are three decimals with spaces between, so
/// that any language reads them without a parser.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FramesHeader {
    /// Title of the scene, key `title`.
    pub title: String,
    /// Names of the materials in the order of their indices, keys `material.0`, ...
    pub materials: Vec<String>,
    /// Names of the walls in the order of their indices, keys `wall.0`, ...
    pub walls: Vec<String>,
    /// Lower and upper corner of the domain, in m, keys `domain_min` and `domain_max`.
    pub domain: Option<(DVec3, DVec3)>,
    /// Along which axes the domain repeats, key `periodic`: a word such as `xy`, empty for none.
    pub periodic: [bool; 3],
    /// Number of space dimensions that the particles move in (2 or 3), key `dimensions`.
    pub dimensions: Option<u8>,
    /// Acceleration of gravity, in m/s^2, key `gravity`.
    pub gravity: Option<DVec3>,
}

fn write_vector(v: DVec3) -> String {
    format!("{:?} {:?} {:?}", v.x, v.y, v.z)
}

fn read_vector(text: &str) -> Option<DVec3> {
    let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
    let numbers: [f64; 3] = numbers.ok()?.try_into().ok()?;
    Some(DVec3::from_array(numbers))
}

impl FramesHeader {
    /// The entries for [`FrameSchema::with_metadata`].
    pub fn entries(&self) -> Vec<(String, String)> {
        let mut entries = vec![(TITLE_KEY.to_owned(), self.title.clone())];
        let lists = [("material", &self.materials), ("wall", &self.walls)];
        for (key, names) in lists {
            for (k, name) in names.iter().enumerate() {
                entries.push((format!("{key}.{k}"), name.clone()));
            }
        }
        if let Some((min, max)) = self.domain {
            entries.push(("domain_min".to_owned(), write_vector(min)));
            entries.push(("domain_max".to_owned(), write_vector(max)));
        }
        let axes = ["x", "y", "z"].into_iter().zip(self.periodic);
        let periodic = axes.filter(|(_, repeats)| *repeats).map(|(axis, _)| axis);
        entries.push(("periodic".to_owned(), periodic.collect()));
        if let Some(dimensions) = self.dimensions {
            entries.push(("dimensions".to_owned(), dimensions.to_string()));
        }
        if let Some(gravity) = self.gravity {
            entries.push((GRAVITY_KEY.to_owned(), write_vector(gravity)));
        }
        entries
    }

    /// Reads the entries back from the metadata of a file.
    ///
    /// # Errors
    /// A key has a value of another form; the two texts are the value found and the form expected.
    pub fn of(schema: &FrameSchema) -> Result<Self, [String; 2]> {
        let metadata = schema.metadata();
        let vector = |key: &str| -> Result<Option<DVec3>, [String; 2]> {
            let Some(text) = metadata.get(key) else {
                return Ok(None);
            };
            let expected = || [format!("`{text}` in {key}"), "three numbers".to_owned()];
            read_vector(text).map(Some).ok_or_else(expected)
        };
        let domain = match (vector("domain_min")?, vector("domain_max")?) {
            (Some(min), Some(max)) => Some((min, max)),
            _ => None,
        };
        let periodic = metadata.get("periodic").map_or("", String::as_str);
        if periodic.chars().any(|axis| !"xyz".contains(axis)) {
            let found = format!("`{periodic}` in periodic");
            return Err([found, "letters of x, y, z".to_owned()]);
        }
        let dimensions = match metadata.get("dimensions").map(|text| text.parse()) {
            None => None,
            Some(Ok(dimensions @ 1..=3)) => Some(dimensions),
            Some(_) => {
                let found = format!("`{}` in dimensions", metadata["dimensions"]);
                return Err([found, "1, 2 or 3".to_owned()]);
            }
        };
        Ok(Self {
            title: metadata.get(TITLE_KEY).cloned().unwrap_or_default(),
            materials: list(metadata, "material"),
            walls: list(metadata, "wall"),
            domain,
            periodic: ['x', 'y', 'z'].map(|axis| periodic.contains(axis)),
            dimensions,
            gravity: vector(GRAVITY_KEY)?,
        })
    }
}

/// Entries `key.0`, `key.1`, ... up to the first that is missing.
pub(super) fn list(metadata: &BTreeMap<String, String>, key: &str) -> Vec<String> {
    let entry = |k: usize| metadata.get(&format!("{key}.{k}")).cloned();
    (0..).map_while(entry).collect()
}
