//! Which particles are near which walls: found with the candidate list, so that a step tests only those.

use rayon::prelude::*;

use crate::neighbours::Images;
use crate::state::{Particle, Particles};
use crate::walls::{Scratch, Shape, Touches, Wall, WallState, image_between_faces, images_met};

/// A particle that may touch a wall before the list is built again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NearWall {
    /// Row of the particle.
    pub row: u32,
    /// Index of the wall.
    pub wall: u16,
    /// Code of the particle's image that is near the wall.
    pub image: u8,
    /// Features of the wall that may be touched at once.
    pub features: u8,
}

/// Finds every particle whose surface is closer than `margin` and its `leeway` (m; empty for none) to a wall, by rows.
///
/// Walls that end inside a periodic domain are met by images too; a wall that spans a period is met once, a mesh that goes on for
/// ever by the image that is between its faces.
#[must_use]
pub fn find_near_walls(
    particles: &Particles,
    leeway: &[f64],
    walls: &[Wall],
    states: &[WallState],
    images: &Images,
    margin: f64,
    parallel: bool,
) -> Vec<NearWall> {
    let codes: Vec<Vec<u32>> = walls.iter().map(|wall| images_met(wall, images)).collect();
    let search = |(chunk, records): (usize, &[Particle])| {
        let mut found = Vec::new();
        let mut touches = Touches::default();
        let mut scratch = Scratch::default();
        for (index, wall) in walls.iter().enumerate() {
            for &code in &codes[index] {
                for (k, record) in records.iter().enumerate() {
                    let (state, place) = (&states[index], record.position);
                    let image = image_between_faces(wall, state, images, place, code);
                    let centre = state.into_wall(place + images.shift(image));
                    let leeway = leeway.get(chunk * CHUNK + k).copied().unwrap_or_default();
                    let reach = record.radius + leeway + margin;
                    let features = match &wall.shape {
                        // Most walls of most scenes.
                        Shape::Plane(plane) => usize::from(plane.touch(centre, reach).is_some()),
                        // Particles that contacts cannot move do not feel walls.
                        _ if record.inverse_mass == 0.0 => 0,
                        Shape::Mesh(mesh) => {
                            usize::from(mesh.may_be_near(centre, reach, &mut scratch))
                        }
                        shape => {
                            shape.touches(centre, reach, &mut touches);
                            touches.len()
                        }
                    };
                    if features > 0 && record.inverse_mass > 0.0 {
                        found.push(NearWall {
                            row: (chunk * CHUNK + k) as u32,
                            wall: index as u16,
                            image: image as u8,
                            features: features as u8,
                        });
                    }
                }
            }
        }
        // Stable: within a row the order of the walls stays.
        found.sort_by_key(|near| near.row);
        found
    };
    let records = &particles.records;
    let chunks: Vec<Vec<NearWall>> = if parallel {
        records.par_chunks(CHUNK).enumerate().map(search).collect()
    } else {
        records.chunks(CHUNK).enumerate().map(search).collect()
    };
    chunks.concat()
}

/// Rows that are searched together.
const CHUNK: usize = 1024;
