//! Surfaces as one line of text each: a word, then names with their numbers.

use std::collections::HashMap;
use std::fmt::Write as _;

use glam::{DVec2, DVec3};

use super::Surface;
use crate::formats::mesh::TriangleMesh;

/// Word for a mesh, whose triangles lie in a file of their own.
const MESH: &str = "mesh";

impl Surface {
    /// The surface as text that reads back exactly; of a mesh only that it is one.
    #[must_use]
    pub fn to_text(&self) -> String {
        let vector = |name: &str, v: DVec3| format!(" {name} {:?} {:?} {:?}", v.x, v.y, v.z);
        match self {
            Self::Plane { point, normal } => [
                "plane",
                &vector("point", *point),
                &vector("normal", *normal),
            ]
            .concat(),
            Self::Sphere { centre, radius } => {
                format!("sphere{} radius {radius:?}", vector("centre", *centre))
            }
            Self::Turned {
                origin,
                direction,
                across,
                profile,
                endless,
            } => {
                let mut text = String::from("turned");
                text += &vector("origin", *origin);
                text += &vector("direction", *direction);
                text += &vector("across", across[0]);
                text += &vector("beside", across[1]);
                let _ = write!(text, " endless {} profile", u8::from(*endless));
                for corner in profile {
                    let _ = write!(text, " {:?} {:?}", corner.x, corner.y);
                }
                text
            }
            Self::Mesh(_) => MESH.to_owned(),
        }
    }

    /// Reads the text back; a mesh comes without triangles.
    ///
    /// # Errors
    /// The text lacks a value, or a value is wrong.
    pub fn from_text(text: &str) -> Result<Self, String> {
        let mut words = text.split_whitespace();
        let kind = words.next().unwrap_or_default();
        let mut fields: HashMap<&str, Vec<f64>> = HashMap::new();
        let mut name = None;
        for word in words {
            match (word.parse::<f64>(), name) {
                (Ok(number), Some(name)) => fields.entry(name).or_default().push(number),
                (Ok(number), None) => return Err(format!("{number} before any name")),
                (Err(_), _) => name = Some(word),
            }
        }
        let numbers = |name: &str, count: usize| match fields.get(name) {
            Some(found) if found.len() == count => Ok(found.as_slice()),
            found => {
                let found = found.map_or(0, Vec::len);
                Err(format!(
                    "{found} numbers `{name}` of a {kind}, expected {count}"
                ))
            }
        };
        let vector = |name: &str| numbers(name, 3).map(DVec3::from_slice);
        match kind {
            "plane" => Ok(Self::Plane {
                point: vector("point")?,
                normal: vector("normal")?,
            }),
            "sphere" => Ok(Self::Sphere {
                centre: vector("centre")?,
                radius: numbers("radius", 1)?[0],
            }),
            "turned" => {
                let found = fields.get("profile").map_or(&[][..], Vec::as_slice);
                let (corners, rest) = found.as_chunks::<2>();
                if corners.is_empty() || !rest.is_empty() {
                    let found = found.len();
                    return Err(format!("{found} numbers `profile`, expected pairs"));
                }
                Ok(Self::Turned {
                    origin: vector("origin")?,
                    direction: vector("direction")?,
                    across: [vector("across")?, vector("beside")?],
                    profile: corners.iter().map(|&c| DVec2::from_array(c)).collect(),
                    endless: numbers("endless", 1)?[0] != 0.0,
                })
            }
            MESH => Ok(Self::Mesh(TriangleMesh::default())),
            other => Err(format!(
                "the surface `{other}`, expected plane, sphere, turned or mesh"
            )),
        }
    }
}
