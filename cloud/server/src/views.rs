//! Walls and previews for the viewer. This part runs as a program of its own, in a cage (`check::view`): it reads meshes of users, which may
//! be larger than the memory of the server.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow};
use mercury_common::frames::{Column, FrameReader, FramesHeader, WallReader};
use mercury_common::surfaces::{Placement, Surface};
use serde::Serialize;

use crate::frames::numbers;

/// The most triangles of all walls of a view.
const MOST_TRIANGLES: usize = 200_000;

/// Nine coordinates of the corners of a triangle, in m.
type Triangle = [[f32; 3]; 3];

#[derive(Serialize)]
struct Wall {
    name: Option<String>,
    present: bool,
    /// Translation (m) and quaternion.
    pose: [f64; 7],
    /// Nine coordinates for each triangle, in m.
    #[serde(serialize_with = "flat")]
    corners: Vec<Triangle>,
}

fn flat<S: serde::Serializer>(
    triangles: &[Triangle],
    to: S,
) -> std::result::Result<S::Ok, S::Error> {
    to.collect_seq(triangles.iter().flatten().flatten())
}

/// The walls of a frame.
#[derive(Serialize)]
struct Walls {
    /// In s.
    time: f64,
    walls: Vec<Wall>,
    /// How many triangles these walls have, and how many they had before they were reduced.
    triangles: [usize; 2],
}

/// Frame 0 of a run.
#[derive(Serialize)]
struct Still {
    walls: Option<Walls>,
    /// Centres and radii of the particles, in m.
    grains: Vec<Vec<f32>>,
    /// Lower and upper corner, in m.
    domain: Option<[[f64; 3]; 2]>,
}

/// Writes the walls in frame `frame` of the run in `folder` as JSON, or without `frame` all of its last frame. Nothing, where there is
/// no such frame.
pub fn view(folder: &Path, frame: Option<usize>, to: impl Write) -> Result<()> {
    let mut to = BufWriter::new(to);
    match frame {
        Some(frame) => {
            let walls = file(folder, ".walls.arrow")?;
            if let Some(walls) = walls.map_or(Ok(None), |path| walls_in(&path, frame))? {
                serde_json::to_writer(&mut to, &walls)?;
            }
        }
        None => {
            let none = |end: &str| anyhow!("the run has no {end}");
            let walls = file(folder, ".walls.arrow")?.ok_or_else(|| none(".walls.arrow"))?;
            let particles = file(folder, ".particles.arrow")?;
            let particles = particles.ok_or_else(|| none(".particles.arrow"))?;
            serde_json::to_writer(&mut to, &still(&walls, &particles)?)?;
        }
    }
    Ok(to.flush()?)
}

/// The file in `folder` whose name has this end.
fn file(folder: &Path, end: &str) -> Result<Option<PathBuf>> {
    let mut names = fs::read_dir(folder)?.flatten().map(|entry| entry.path());
    Ok(names.find(|path| path.to_string_lossy().ends_with(end)))
}

fn still(walls: &Path, particles: &Path) -> Result<Still> {
    let particles = FrameReader::open(particles).map_err(|error| anyhow!("{error}"))?;
    let header =
        FramesHeader::of(particles.schema()).map_err(|found| anyhow!("{}", found.join(" ")))?;
    // The last frame: what is inserted in the first step is there.
    let columns = particles.columns(
        particles.len().saturating_sub(1),
        &["x", "y", "z", "radius"],
    );
    let columns = columns.map_err(|error| anyhow!("{error}"))?;
    let single = |column: &Column| {
        numbers(column)
            .into_iter()
            .map(|value| value as f32)
            .collect::<Vec<f32>>()
    };
    Ok(Still {
        walls: walls_in(walls, 0)?,
        grains: columns.iter().map(single).collect(),
        domain: header
            .domain
            .map(|(min, max)| [min.to_array(), max.to_array()]),
    })
}

fn walls_in(path: &Path, k: usize) -> Result<Option<Walls>> {
    let reader = WallReader::open(path).map_err(|error| anyhow!("{error}"))?;
    if reader.frames().info(k).is_none() {
        return Ok(None);
    }
    let frame = reader.frame(k).map_err(|error| anyhow!("{error}"))?;
    let Some(domain) = reader.header().domain else {
        return Ok(None);
    };
    let names = &reader.header().walls;
    let own = Placement::default();
    let mut walls = Vec::new();
    for (k, surface) in reader.surfaces().iter().enumerate() {
        // A plane ends at the domain wherever it is now; other surfaces are the same in each frame, and only stand
        // elsewhere.
        let plane = matches!(surface, Surface::Plane { .. });
        let placement = frame.placement[k];
        let mesh = surface.triangles(if plane { &placement } else { &own }, domain, &[]);
        let (q, x) = (placement.rotation, placement.translation);
        let pose = if plane {
            [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
        } else {
            [x.x, x.y, x.z, q.w, q.x, q.y, q.z]
        };
        let corners = (0..mesh.triangles.len())
            .map(|triangle| {
                mesh.corners(triangle)
                    .map(|corner| corner.to_array().map(|coordinate| coordinate as f32))
            })
            .collect();
        walls.push(Wall {
            name: names.get(k).map(ToString::to_string),
            present: frame.present[k],
            pose,
            corners,
        });
    }
    let count = |walls: &[Wall]| walls.iter().map(|wall| wall.corners.len()).sum::<usize>();
    let before = count(&walls);
    if before > MOST_TRIANGLES {
        for wall in &mut walls {
            let share = MOST_TRIANGLES as f64 * wall.corners.len() as f64 / before as f64;
            wall.corners = reduced(&wall.corners, share as usize);
        }
    }
    Ok(Some(Walls {
        time: frame.time,
        triangles: [count(&walls), before],
        walls,
    }))
}

/// A surface of at most `most` triangles: corners in one cell of a grid become their mean (Rossignac and Borrel 1993, vertex clustering).
fn reduced(triangles: &[Triangle], most: usize) -> Vec<Triangle> {
    if triangles.len() <= most {
        return triangles.to_vec();
    }
    let corners = || triangles.iter().flatten();
    let mut low = [f32::MAX; 3];
    let mut high = [f32::MIN; 3];
    for corner in corners() {
        for axis in 0..3 {
            low[axis] = low[axis].min(corner[axis]);
            high[axis] = high[axis].max(corner[axis]);
        }
    }
    let extent = (0..3)
        .map(|axis| high[axis] - low[axis])
        .fold(0.0, f32::max);
    // A surface meets about as many cells as the square of their number along an edge, with two triangles each.
    let mut cells = (most as f32).sqrt().ceil();
    while cells > 1.0 && extent > 0.0 {
        let cell = |corner: &[f32; 3]| -> [u32; 3] {
            std::array::from_fn(|axis| ((corner[axis] - low[axis]) / extent * cells) as u32)
        };
        let mut means: HashMap<[u32; 3], ([f64; 3], f64)> = HashMap::new();
        for corner in corners() {
            let (sum, count) = means.entry(cell(corner)).or_default();
            for axis in 0..3 {
                sum[axis] += f64::from(corner[axis]);
            }
            *count += 1.0;
        }
        let mut seen = HashSet::new();
        let kept: Vec<[[u32; 3]; 3]> = triangles
            .iter()
            .map(|triangle| triangle.each_ref().map(cell))
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .filter(|three| {
                let mut sorted = *three;
                sorted.sort_unstable();
                seen.insert(sorted)
            })
            .collect();
        if kept.len() <= most {
            let mean = |cell: [u32; 3]| {
                let (sum, count) = means[&cell];
                sum.map(|sum| (sum / count) as f32)
            };
            return kept.into_iter().map(|three| three.map(mean)).collect();
        }
        cells *= 0.8;
    }
    Vec::new()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 1 m in 2 * 300^2 triangles. The reduced one has corners that lie less than a cell apart, so its area is that of the square
    /// but for a cell along the four edges.
    #[test]
    fn a_reduced_surface_covers_what_the_whole_one_covers() {
        let n = 300;
        let at = |i: usize, j: usize| [i as f32 / n as f32, j as f32 / n as f32, 0.5];
        let mut square: Vec<Triangle> = Vec::new();
        for i in 0..n {
            for j in 0..n {
                square.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                square.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        let area = |triangles: &[Triangle]| -> f64 {
            let area = |[a, b, c]: &Triangle| {
                let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
                f64::from(u[0] * v[1] - u[1] * v[0]).abs() / 2.0
            };
            triangles.iter().map(area).sum()
        };
        let most = 5000;
        let few = reduced(&square, most);
        assert!(few.len() <= most && few.len() > most / 4, "{}", few.len());
        let cell = 1.0 / (few.len() as f64 / 2.0).sqrt();
        assert!((area(&few) - 1.0).abs() < 4.0 * cell, "{}", area(&few));
        assert!(few.iter().flatten().all(|corner| corner[2] == 0.5));
        assert_eq!(reduced(&square, square.len()), square);
        assert!(reduced(&square, 0).is_empty());
    }
}
