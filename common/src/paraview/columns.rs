//! Flat columns as vectors again.

use std::collections::HashMap;

use glam::{DQuat, DVec3};

use crate::formats::vtu::VtuValues;
use crate::frames::{Column, ColumnKind, ColumnSpec};

/// Columns that belong together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Group {
    /// A column of its own.
    Single(usize),
    /// Three columns `..x`, `..y`, `..z`.
    Vector([usize; 3]),
    /// Four columns `..w`, `..x`, `..y`, `..z`.
    Quaternion([usize; 4]),
}

/// Meaning of the columns with a short stem in the frames of Mercury.
const STEMS: [(&str, &str); 10] = [
    ("", "position"),
    ("v", "velocity"),
    ("w", "angular_velocity"),
    ("f", "force"),
    ("t", "torque"),
    ("q", "orientation"),
    ("p", "contact_point"),
    ("b", "branch"),
    ("n", "normal"),
    ("i", "principal_moments"),
];

/// The groups of columns in their order, each with its name.
#[must_use]
pub fn groups(specs: &[ColumnSpec]) -> Vec<(String, Group)> {
    let stem = |k: usize, letter: char| -> Option<&str> {
        let spec = specs.get(k).filter(|spec| spec.kind == ColumnKind::F64)?;
        spec.name.strip_suffix(letter)
    };
    let triple = |k: usize| {
        let found = stem(k, 'x')?;
        let same = stem(k + 1, 'y') == Some(found) && stem(k + 2, 'z') == Some(found);
        same.then_some(found)
    };
    let mut groups = Vec::new();
    let mut k = 0;
    while k < specs.len() {
        if let (Some(found), Some(rest)) = (stem(k, 'w'), triple(k + 1))
            && found == rest
        {
            groups.push((
                full_name(found),
                Group::Quaternion([k, k + 1, k + 2, k + 3]),
            ));
            k += 4;
        } else if let Some(found) = triple(k) {
            groups.push((full_name(found), Group::Vector([k, k + 1, k + 2])));
            k += 3;
        } else {
            groups.push((specs[k].name.clone(), Group::Single(k)));
            k += 1;
        }
    }
    groups
}

fn full_name(stem: &str) -> String {
    let known = STEMS.iter().find(|(short, _)| *short == stem);
    let name = known.map_or(stem.trim_end_matches('_'), |(_, name)| name);
    name.to_owned()
}

/// Three columns of numbers as vectors; nothing if they are not numbers.
#[must_use]
pub fn vectors(columns: &[Column], [x, y, z]: [usize; 3]) -> Option<Vec<DVec3>> {
    let number = |k: usize| columns.get(k).and_then(Column::as_f64);
    let parts = number(x)?.iter().zip(number(y)?).zip(number(z)?);
    Some(parts.map(|((&x, &y), &z)| DVec3::new(x, y, z)).collect())
}

/// Description of the column that [`clump_column`] gives.
#[must_use]
pub fn clump_spec() -> ColumnSpec {
    ColumnSpec::new("clump", ColumnKind::OptionalU32, "1")
}

/// The kind of clump of each particle by the body that it is a part of, none for spheres of their own: `ids` and `clumps` are those of all bodies.
#[must_use]
pub fn clump_column(body: &[Option<u32>], ids: &[u32], clumps: &[u32]) -> Column {
    let clump_of: HashMap<u32, u32> = ids.iter().copied().zip(clumps.iter().copied()).collect();
    let of = |body: &Option<u32>| clump_of.get(&(*body)?).copied();
    Column::OptionalU32(body.iter().map(of).collect())
}

/// Takes a group as an array; nothing for text, which grids do not hold.
pub(super) fn take_values(columns: &mut [Column], group: &Group) -> Option<VtuValues<'static>> {
    Some(match group {
        Group::Vector(places) => vectors(columns, *places)?.into(),
        Group::Quaternion([w, x, y, z]) => {
            let real = columns.get(*w).and_then(Column::as_f64)?;
            let imaginary = vectors(columns, [*x, *y, *z])?;
            let parts = real.iter().zip(imaginary);
            let all = parts.map(|(&w, v)| DQuat::from_xyzw(v.x, v.y, v.z, w));
            all.collect::<Vec<_>>().into()
        }
        Group::Single(k) => match std::mem::replace(columns.get_mut(*k)?, Column::U8(Vec::new())) {
            Column::F64(v) => v.into(),
            Column::I32(v) => v.into(),
            Column::U8(v) => v.into(),
            Column::U32(v) => v.into(),
            Column::U64(v) => v.into(),
            // -1 stands for none, so that thresholds can leave it out.
            Column::OptionalU32(v) => {
                let all = v.into_iter().map(|v| v.map_or(-1, i64::from));
                all.collect::<Vec<_>>().into()
            }
            Column::Text(_) => return None,
        },
    })
}
