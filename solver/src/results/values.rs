//! Where the values of results are read: the tables, energies and last frame of a run.

use std::path::Path;

use glam::DVec3;
use mercury_common::formats::delimited::Rows;
use mercury_common::formats::ene::{self, EnergyReader};
use mercury_common::frames::{Column, FLAG_FIXED, FrameReader, FramesHeader, WallReader};
use mercury_common::readable::significant;
use mercury_common::scene::{listed, nearest};
use mercury_common::surfaces::Surface;

/// A value at a time, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Row {
    pub(super) time: f64,
    pub(super) value: f64,
}

/// The values of a column in the rows of a name.
pub(super) fn rows(
    text: &str,
    name: &str,
    material: Option<&str>,
    column: &str,
) -> Result<Vec<Row>, String> {
    let table = Rows::new(text);
    let place = |wanted: &str| {
        let found = table.place(wanted);
        found.ok_or_else(|| format!("there is no column `{wanted}`"))
    };
    let (time_at, name_at, column_at) = (place("time")?, place("name")?, place(column)?);
    let material_at = table.place("material");
    let (mut names, mut materials, mut values) =
        (Vec::<String>::new(), Vec::<String>::new(), Vec::new());
    for row in table {
        if row[name_at] != name {
            if names.iter().all(|known| *known != row[name_at]) {
                names.push(row[name_at].to_string());
            }
            continue;
        }
        if let Some(at) = material_at {
            if materials.iter().all(|known| *known != row[at]) {
                materials.push(row[at].to_string());
            }
            if material.is_some_and(|material| material != row[at]) {
                continue;
            }
        }
        let number = |at: usize| {
            row[at]
                .parse::<f64>()
                .map_err(|_| format!("`{}` is no number", row[at]))
        };
        values.push(Row {
            time: number(time_at)?,
            value: number(column_at)?,
        });
    }
    if materials.is_empty() && !names.is_empty() && values.is_empty() && !text.contains(name) {
        return Err(format!(
            "nothing is named `{name}`; there are: {}",
            listed(names.iter().map(String::as_str))
        ));
    }
    if material.is_none() && materials.len() > 1 {
        return Err(format!(
            "`{name}` has rows of several materials: name one of {}",
            listed(materials.iter().map(String::as_str))
        ));
    }
    if let Some(material) =
        material.filter(|material| !materials.iter().any(|known| known == material))
    {
        return Err(format!(
            "`{name}` has no rows of `{material}`; there are: {}",
            listed(materials.iter().map(String::as_str))
        ));
    }
    Ok(values)
}

/// A column of `.ene`.
pub(super) fn energies(folder: &Path, prefix: &str, column: &str) -> Result<Vec<Row>, String> {
    let path = folder.join(format!("{prefix}.ene"));
    let reader = EnergyReader::open(&path).map_err(|error| error.to_string())?;
    let mut values = Vec::new();
    for row in reader {
        let row = row.map_err(|error| error.to_string())?;
        let at = ene::COLUMNS
            .iter()
            .position(|name| *name == column)
            .unwrap_or(0);
        values.push(Row {
            time: row.time,
            value: row.values()[at],
        });
    }
    Ok(values)
}

/// The time behind which the scene of a run schedules nothing, from its summary, s.
pub(super) fn settled(folder: &Path) -> Result<f64, String> {
    let path = folder.join("summary.json");
    let text = std::fs::read_to_string(&path).map_err(|error| super::lost(&path, &error))?;
    let summary: Option<serde_json::Value> = serde_json::from_str(&text).ok();
    let time = summary.and_then(|summary| summary["settled"].as_f64());
    time.ok_or_else(|| {
        format!(
            "{}: no number `settled`, the time from which `steady` counts: the run was made by an earlier version; give the time in numbers",
            path.display()
        )
    })
}

/// Gravity of a run, m/s^2.
pub(super) fn gravity(folder: &Path, prefix: &str) -> Result<DVec3, String> {
    let path = folder.join(format!("{prefix}.particles.arrow"));
    let reader = FrameReader::open(&path).map_err(|error| error.to_string())?;
    let header = FramesHeader::of(reader.schema()).map_err(|problem| problem.join(": "))?;
    let gravity = header.gravity.filter(|gravity| gravity.length() > 0.0);
    gravity.ok_or_else(|| "a tilt is that against gravity, and the scene has none".to_owned())
}

/// Vectors over time, from columns of their components.
fn vectors(columns: [Vec<Row>; 3]) -> Vec<(f64, DVec3)> {
    let [x, y, z] = columns;
    let all = x.into_iter().zip(y).zip(z);
    all.map(|((x, y), z)| (x.time, DVec3::new(x.value, y.value, z.value)))
        .collect()
}

/// Where the centre of mass of all that moves is, as seen along the axis about which a wall turns: in each row the distance from the wall's reference
/// point along gravity, and that at right angles to it, positive where the turning wall would carry it, m.
pub(super) fn turning(
    folder: &Path,
    prefix: &str,
    wall: &str,
    gravity: DVec3,
) -> Result<Vec<(Row, f64)>, String> {
    let path = folder.join(format!("{prefix}.walls.csv"));
    let text = std::fs::read_to_string(&path).map_err(|error| super::lost(&path, &error))?;
    let of_wall = |columns: [&str; 3]| {
        let [x, y, z] = columns.map(|column| rows(&text, wall, None, column));
        let read = || Ok([x?, y?, z?]);
        read()
            .map(vectors)
            .map_err(|problem: String| format!("{}: {problem}", path.display()))
    };
    let spins = of_wall(["wx", "wy", "wz"])?;
    let axis = spins.iter().find_map(|(_, spin)| spin.try_normalize());
    let axis =
        axis.ok_or_else(|| format!("wall `{wall}` never turns: a tilt is about its axis"))?;
    let down = (gravity - axis * gravity.dot(axis)).try_normalize();
    let down = down.ok_or_else(|| {
        format!("gravity lies along the axis of wall `{wall}`: there is no tilt about it")
    })?;
    let across = axis.cross(down);
    let [x, y, z] = ["centerOfMassX", "centerOfMassY", "centerOfMassZ"]
        .map(|column| energies(folder, prefix, column));
    let centres = vectors([x?, y?, z?]);
    let both = of_wall(["x", "y", "z"])?.into_iter().zip(centres);
    let seen = both.map(|((time, reference), (_, centre))| {
        let way = centre - reference;
        let value = way.dot(down);
        (Row { time, value }, way.dot(across))
    });
    // While nothing can move there is no centre of mass.
    Ok(seen.filter(|(along, _)| along.value.is_finite()).collect())
}

/// Columns of the last frame, rows of what is fixed left out.
fn last_frame(folder: &Path, prefix: &str, columns: &[&str]) -> Result<Vec<Vec<f64>>, String> {
    let path = folder.join(format!("{prefix}.particles.arrow"));
    let reader = FrameReader::open(&path).map_err(|error| error.to_string())?;
    let last = reader
        .len()
        .checked_sub(1)
        .ok_or_else(|| format!("{}: there are no frames", path.display()))?;
    let frame = reader.frame(last).map_err(|error| error.to_string())?;
    let specs = reader.schema().columns();
    let column = |name: &str| {
        let place = specs.iter().position(|spec| spec.name == name);
        place.and_then(|place| frame.columns.get(place))
    };
    let is_fixed = |row: usize| matches!(column("state"), Some(Column::U8(bits)) if bits[row] & FLAG_FIXED != 0);
    let free: Vec<usize> = (0..frame.rows()).filter(|&row| !is_fixed(row)).collect();
    let numbers = |name: &&str| -> Result<Vec<f64>, String> {
        let values = column(name).and_then(Column::as_f64).ok_or_else(|| {
            let known: Vec<&str> = (specs.iter().zip(&frame.columns))
                .filter(|(_, column)| column.as_f64().is_some())
                .map(|(spec, _)| spec.name.as_str())
                .collect();
            let hint = match nearest(name, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("there are: {}", listed(known.iter().copied())),
            };
            format!(
                "{}: there is no column `{name}` of numbers; {hint}",
                path.display()
            )
        })?;
        Ok(free.iter().map(|&row| values[row]).collect())
    };
    columns.iter().map(numbers).collect()
}

/// A column of the last frame, without what is fixed; `speed`, too.
pub(super) fn particles(folder: &Path, prefix: &str, column: &str) -> Result<Vec<f64>, String> {
    if column == "speed" {
        let v = last_frame(folder, prefix, &["vx", "vy", "vz"])?;
        let squares = v[0]
            .iter()
            .zip(&v[1])
            .zip(&v[2])
            .map(|((x, y), z)| x * x + y * y + z * z);
        return Ok(squares.map(f64::sqrt).collect());
    }
    Ok(last_frame(folder, prefix, &[column])?.swap_remove(0))
}

/// The slope of a heap about a vertical (z) axis in degrees: that of the straight line through the highest grain in each ring of
/// a mean diameter's width, from the axis to where the surface is two grains high. The axis goes through the mean place of all
/// grains.
pub(super) fn slope(folder: &Path, prefix: &str) -> Result<f64, String> {
    let columns = last_frame(folder, prefix, &["x", "y", "z", "radius"])?;
    let [x, y, z, radius] = &columns[..] else {
        return Err("there are no places".to_owned());
    };
    surface_slope(x, y, z, radius).ok_or_else(|| {
        "there is no heap: fewer than three rings are higher than two grains".to_owned()
    })
}

/// Largest kinetic energy of translation of a heap at rest, over m g d: ten times that with which `until_at_rest` ends a run.
const STILL: f64 = 1e-5;

/// Remark on the slope of a heap: that it still moves, or that no grain has come to the rim of what it lies on.
pub(super) fn slope_note(folder: &Path, prefix: &str) -> Option<String> {
    let names = ["x", "y", "z", "radius", "vx", "vy", "vz"];
    let columns = last_frame(folder, prefix, &names).ok()?;
    let [x, y, z, radius, vx, vy, vz] = &columns[..] else {
        return None;
    };
    let count = x.len() as f64;
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / count;
    let (x0, y0) = (mean(&mut x.iter().copied()), mean(&mut y.iter().copied()));
    let diameter = 2.0 * mean(&mut radius.iter().copied());
    let mut notes = Vec::new();

    let path = folder.join(format!("{prefix}.particles.arrow"));
    let header = FrameReader::open(&path).ok();
    let header = header.and_then(|frames| FramesHeader::of(frames.schema()).ok());
    let gravity = header
        .and_then(|header| header.gravity)
        .map_or(0.0, DVec3::length);
    let squares = vx.iter().zip(vy).zip(vz);
    let mut halves = squares.map(|((x, y), z)| 0.5 * (x * x + y * y + z * z));
    let share = mean(&mut halves) / (gravity * diameter);
    if share > STILL {
        let share = significant(share, 2);
        notes.push(format!(
            "not at rest: the kinetic energy of the grains is {share} m g d"
        ));
    }

    let lowest = z
        .iter()
        .zip(radius)
        .map(|(z, r)| z - r)
        .fold(f64::INFINITY, f64::min);
    let distance = |row: usize| libm::hypot(x[row] - x0, y[row] - y0) + radius[row];
    let foot = (0..x.len()).map(distance).fold(0.0, f64::max);
    if let Some((name, rim)) = plate_under(folder, prefix, DVec3::new(x0, y0, lowest), diameter)
        // A ring of the surface is a diameter wide.
        && foot < rim - diameter
    {
        notes.push(format!(
            "the heap ends at {} m from its axis and has not reached the rim of `{name}` at {} m: more grains make it higher",
            significant(foot, 3),
            significant(rim, 3)
        ));
    }
    (!notes.is_empty()).then(|| notes.join("; "))
}

/// Name and radius (m) of the horizontal disc about the axis through `foot` on which a heap lies, its centre to a diameter of a grain.
fn plate_under(folder: &Path, prefix: &str, foot: DVec3, diameter: f64) -> Option<(String, f64)> {
    let walls = WallReader::open(folder.join(format!("{prefix}.walls.arrow"))).ok()?;
    let last = walls.frame(walls.frames().len().checked_sub(1)?).ok()?;
    let all = walls.header().walls.iter().zip(walls.layout());
    let all = all.zip(last.placement.iter().zip(&last.present));
    let mut plates = all.filter_map(|((name, surface), (place, present))| {
        let Surface::Turned {
            origin,
            direction,
            profile,
            endless: false,
            ..
        } = surface
        else {
            return None;
        };
        let level = profile.first()?.y;
        let is_flat = profile.iter().all(|corner| corner.y == level);
        let centre = place.rotation * (*origin + *direction * level) + place.translation;
        let is_level = (place.rotation * *direction).z.abs() > 1.0 - 1e-9;
        let rim = profile.iter().map(|corner| corner.x).fold(0.0, f64::max);
        let is_under = (centre.z - foot.z).abs() < diameter
            && libm::hypot(centre.x - foot.x, centre.y - foot.y) < diameter;
        (*present && is_flat && is_level && is_under).then(|| (name.clone(), rim))
    });
    plates.next()
}

fn surface_slope(x: &[f64], y: &[f64], z: &[f64], radius: &[f64]) -> Option<f64> {
    let count = x.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
    let (x0, y0, diameter) = (mean(x), mean(y), 2.0 * mean(radius));
    let floor = z
        .iter()
        .zip(radius)
        .map(|(z, r)| z - r)
        .fold(f64::INFINITY, f64::min);
    let mut highest = Vec::<f64>::new();
    for row in 0..x.len() {
        let (dx, dy) = (x[row] - x0, y[row] - y0);
        let distance = (dx * dx + dy * dy).sqrt();
        let ring = (distance / diameter) as usize;
        // Particles that rolled far away are no part of the heap.
        if ring < 10_000 {
            highest.resize(highest.len().max(ring + 1), 0.0);
            highest[ring] = highest[ring].max(z[row] + radius[row] - floor);
        }
    }
    let foot = highest.iter().position(|&height| height < 2.0 * diameter);
    let flank = &highest[..foot.unwrap_or(highest.len())];
    if flank.len() < 3 {
        return None;
    }
    // Least squares over the rings.
    let n = flank.len() as f64;
    let at = |k: usize| (k as f64 + 0.5) * diameter;
    let middle = (0..flank.len()).map(at).sum::<f64>() / n;
    let height = flank.iter().sum::<f64>() / n;
    let over: f64 = flank
        .iter()
        .enumerate()
        .map(|(k, h)| (at(k) - middle) * (h - height))
        .sum();
    let under: f64 = (0..flank.len())
        .map(|k| (at(k) - middle) * (at(k) - middle))
        .sum();
    Some(libm::atan(-over / under).to_degrees())
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec2};
    use mercury_common::frames::{
        ParticleColumns, ParticleFrame, ParticleWriter, WallFrame, WallWriter,
    };
    use mercury_common::surfaces::Placement;

    use super::*;

    #[test]
    fn the_slope_of_a_cone_is_its_angle() {
        // Grains of diameter 1 on the surface of a cone of 30 degrees, at the middles of 20 rings.
        let (mut x, mut y, mut z) = (Vec::new(), Vec::new(), Vec::new());
        for ring in 0..20 {
            for part in 0..36 {
                let (r, a) = (
                    f64::from(ring) + 0.5,
                    f64::from(part) * std::f64::consts::TAU / 36.0,
                );
                x.push(7.0 + r * a.cos());
                y.push(r * a.sin() - 3.0);
                z.push((20.0 - r) * 30f64.to_radians().tan());
            }
        }
        let angle = surface_slope(&x, &y, &z, &vec![0.5; x.len()]).unwrap();
        // The mean of the places is the axis to round-off; which of a ring's grains is highest does not matter.
        assert!((angle - 30.0).abs() < 1e-9, "{angle}");
        assert_eq!(surface_slope(&x[..4], &y[..4], &z[..4], &[0.5; 4]), None);
        assert_eq!(surface_slope(&[], &[], &[], &[]), None);
    }

    /// A heap of 45 degrees whose outermost grains, at (5, 4) m, reach 0.5 m + sqrt(41) m = 6.903 m from the axis, on a plate with this rim (m), its grains with this speed (m/s).
    fn note_of(rim: f64, speed: f64) -> Option<String> {
        let folder = tempfile::tempdir().unwrap();
        let header = FramesHeader {
            walls: vec!["plate".to_owned()],
            gravity: Some(DVec3::new(0.0, 0.0, -10.0)),
            ..FramesHeader::default()
        };
        let mut frame = ParticleFrame::default();
        for (x, y) in (-6..=6).flat_map(|x| (-6..=6).map(move |y| (f64::from(x), f64::from(y)))) {
            let distance = libm::hypot(x, y);
            for layer in 0..7 {
                let z = 0.5 + f64::from(layer);
                if z <= 7.0 - distance {
                    frame.id.push(frame.id.len() as u32);
                    frame.position.push(DVec3::new(x, y, z));
                    frame.velocity.push(DVec3::new(0.0, speed, 0.0));
                }
            }
        }
        let count = frame.id.len();
        frame.radius = vec![0.5; count];
        (frame.mass, frame.volume) = (vec![1.0; count], vec![1.0; count]);
        (frame.material, frame.flags) = (vec![0; count], vec![0; count]);
        let columns = ParticleColumns::default();
        let path = folder.path().join("a.particles.arrow");
        ParticleWriter::create(path, &header, &columns)
            .unwrap()
            .append(frame)
            .unwrap();
        let plate = Surface::Turned {
            origin: DVec3::ZERO,
            direction: DVec3::Z,
            across: [DVec3::X, DVec3::Y],
            profile: vec![DVec2::ZERO, DVec2::new(rim, 0.0)],
            endless: false,
        };
        let walls = WallFrame {
            present: vec![true],
            placement: vec![Placement {
                rotation: DQuat::IDENTITY,
                translation: DVec3::ZERO,
            }],
            ..WallFrame::default()
        };
        let path = folder.path().join("a.walls.arrow");
        WallWriter::create(path, &header, &vec![plate])
            .unwrap()
            .append(walls)
            .unwrap();
        // The highest grain of each ring lies on an axis, a diameter below that of the ring before.
        assert!((slope(folder.path(), "a").unwrap() - 45.0).abs() < 1e-9);
        slope_note(folder.path(), "a")
    }

    #[test]
    fn a_heap_that_moves_or_has_not_reached_its_rim_says_so() {
        // A ring is one diameter, 1 m, wide.
        assert_eq!(note_of(7.9, 0.0), None);
        let note = note_of(7.91, 0.0).unwrap();
        assert!(note.contains("ends at 6.9 m"), "{note}");
        assert!(note.contains("the rim of `plate` at 7.91 m"), "{note}");
        // v^2/2 over g d is 1e-5 at 1.414 cm/s.
        assert_eq!(note_of(7.9, 0.0141), None);
        let note = note_of(7.9, 0.0142).unwrap();
        assert!(
            note.starts_with("not at rest: the kinetic energy of the grains is "),
            "{note}"
        );
    }

    /// A drum about the y axis that turns by its rule carries its grains by 30 degrees from gravity: turned about y, -z goes to (-sin, 0, -cos).
    #[test]
    fn a_tilt_is_positive_where_the_wall_carries_the_grains() {
        let folder = tempfile::tempdir().unwrap();
        let (sine, cosine) = (0.5, 0.75f64.sqrt());
        for (spin, sign) in [(2.0, 1.0), (-2.0, -1.0)] {
            let walls = format!(
                "time,name,x,y,z,wx,wy,wz\n0,drum,1,2,3,0,0,0\n0.5,drum,1,2,3,0,{spin},0\n"
            );
            std::fs::write(folder.path().join("a.walls.csv"), walls).unwrap();
            let (x, z) = (1.0 - 0.1 * sine, 3.0 - 0.1 * cosine);
            let energies = format!(
                "time gravitEnergy traKineticEnergy rotKineticEnergy elasticEnergy centerOfMassX centerOfMassY centerOfMassZ\n0 0 0 0 0 {x} 7 {z}\n0.5 0 0 0 0 {x} 7 {z}\n"
            );
            std::fs::write(folder.path().join("a.ene"), energies).unwrap();
            let turned = turning(folder.path(), "a", "drum", DVec3::new(0.0, 0.0, -9.81)).unwrap();
            assert_eq!(turned.len(), 2);
            for (along, across) in turned {
                // Round-off of differences of numbers up to 3, over a way of 0.1.
                assert!((along.value - 0.1 * cosine).abs() < 1e-14);
                assert!((across - sign * 0.1 * sine).abs() < 1e-14);
            }
        }
        let along_axis = turning(folder.path(), "a", "drum", DVec3::Y).unwrap_err();
        assert!(along_axis.contains("gravity lies along"), "{along_axis}");
    }

    #[test]
    fn values_of_rows() {
        let table =
            "time,name,material,fx\n0,a,m,1\n0,\"b, c\",m,7\n1,a,m,3\n1,a,n,9\n2,a,m,5\n2,a,m,1";
        let values = |name: &str, material: Option<&str>| -> Vec<(f64, f64)> {
            let rows = rows(table, name, material, "fx").unwrap().into_iter();
            rows.map(|row| (row.time, row.value)).collect()
        };
        let expected = [(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)];
        assert_eq!(values("a", Some("m")), expected);
        assert_eq!(values("b, c", None), [(0.0, 7.0)]);
        for (name, material, part) in [
            ("a", None, "several materials: name one of m, n"),
            ("a", Some("o"), "no rows of `o`; there are: m, n"),
            ("q", None, "nothing is named `q`; there are: a, b, c"),
        ] {
            let error = rows(table, name, material, "fx").unwrap_err();
            assert!(error.contains(part), "{error}");
        }
        assert!(
            rows(table, "a", Some("m"), "fy")
                .unwrap_err()
                .contains("`fy`")
        );
        assert!(rows("", "a", None, "fx").is_err());
    }
}
