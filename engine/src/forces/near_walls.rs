//! Which particles are near which walls: found with the candidate list, so that a step tests only these.

use std::ops::Range;

use rayon::prelude::*;

use super::contact_loop::held_depth;
use crate::cell::Cell;
use crate::neighbours::{Block, Boxes, Grid, Margin};
use crate::state::{Particle, Particles, WallIndex};
use crate::walls::{Scratch, Shape, Touches, WallNow};

/// A particle that may touch a wall before the list is built again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NearWall {
    /// Row of the particle.
    pub row: u32,
    /// Index of the wall; a plan has no more walls than have a number.
    pub wall: WallIndex,
    /// Code of the particle's image that is near the wall.
    pub image: u32,
    /// Features of the wall that may be touched at once.
    pub features: u32,
}

/// Finds every particle whose surface is closer than `margin` and its `extra_skin` (m; empty for none) to a wall, by rows, and within a
/// row by walls and images. `grid`: the cells by which the particles are sorted.
///
/// Walls of finite extent are also met by images; an infinite wall is met once, and a mesh that continues periodically by the
/// image between its faces. `rows`: those that are of interest.
///
/// Each wall looks for blocks of cells that it may be near, and only the particles in them are tested: of many walls most are near
/// few particles.
#[must_use]
pub fn find_near_walls(
    particles: &Particles,
    extra_skin: &[f64],
    grid: &Grid,
    walls: &[WallNow],
    cell: &Cell,
    margin: &Margin,
    rows: &Range<usize>,
    parallel: bool,
) -> Vec<NearWall> {
    if walls.is_empty() {
        return Vec::new();
    }
    let records = &particles.records;
    let boxes = Boxes::new(grid, records, extra_skin, parallel);
    let most = margin.largest();
    let near_wall = |index: usize| {
        let (wall, mut scratch) = (&walls[index], Scratch::default());
        let (mut blocks, mut near) = (Vec::new(), Vec::new());
        let outer = wall.outer_box();
        for &code in wall.met_by() {
            let may_matter =
                |block: &Block| wall.may_be_near(&outer, block, most, (cell, code), &mut scratch);
            blocks.clear();
            boxes.find(may_matter, &mut blocks);
            near.extend(blocks.iter().map(|&block| (index as u16, code, block)));
        }
        near
    };
    let search = |near: &[(u16, u32, u32)]| {
        let mut tests = Tests {
            records,
            extra_skin,
            cell,
            margin,
            touches: Touches::default(),
            scratch: Scratch::default(),
        };
        let mut found = Vec::new();
        for &(index, code, block) in near {
            let wall = &walls[index as usize];
            let of_block = boxes.rows(block).filter(|row| rows.contains(row));
            found.extend(of_block.filter_map(|row| {
                let (image, features) = tests.test(wall, (row, 0.0), code)?;
                Some(NearWall {
                    row: row as u32,
                    wall: WallIndex::new(index),
                    image,
                    features,
                })
            }));
        }
        found
    };
    let found: Vec<Vec<NearWall>> = if parallel {
        let walls = (0..walls.len()).into_par_iter().with_min_len(8);
        let near: Vec<_> = walls.flat_map_iter(near_wall).collect();
        near.par_chunks(CHUNK).map(search).collect()
    } else {
        let near: Vec<_> = (0..walls.len()).flat_map(near_wall).collect();
        vec![search(&near)]
    };
    by_rows(&found, records.len())
}

/// Near walls of the vertices of a sheet as spheres, in any order: each with each wall, as deep as walls hold them from behind.
#[must_use]
pub fn near_walls_of_vertices(
    vertices: &[Particle],
    walls: &[WallNow],
    cell: &Cell,
    margin: &Margin,
) -> Vec<NearWall> {
    let mut tests = Tests {
        records: vertices,
        extra_skin: &[],
        cell,
        margin,
        touches: Touches::default(),
        scratch: Scratch::default(),
    };
    let mut found = Vec::new();
    for (row, vertex) in vertices.iter().enumerate() {
        let depth = held_depth(vertex.radius);
        for (index, wall) in walls.iter().enumerate() {
            for &code in wall.met_by() {
                if let Some((image, features)) = tests.test(wall, (row, depth), code) {
                    found.push(NearWall {
                        row: row as u32,
                        wall: WallIndex::new(index as u16),
                        image,
                        features,
                    });
                }
            }
        }
    }
    found
}

/// Blocks that are searched together.
const CHUNK: usize = 64;

/// The test of a single particle, with memory that is used again.
struct Tests<'a> {
    records: &'a [Particle],
    extra_skin: &'a [f64],
    cell: &'a Cell,
    margin: &'a Margin,
    touches: Touches,
    scratch: Scratch,
}

impl Tests<'_> {
    /// The image, among those with the code `met_by`, by which a particle is near a wall, and how many features may be touched. `depth`: how far
    /// beyond its radius it looks for the wall, m.
    #[inline]
    fn test(
        &mut self,
        wall: &WallNow,
        (row, depth): (usize, f64),
        met_by: u32,
    ) -> Option<(u32, u32)> {
        let record = &self.records[row];
        // Particles that contacts cannot move do not feel walls, but sheets feel them.
        if record.inverse_mass == 0.0 && wall.surface().is_none() {
            return None;
        }
        let image = wall.image_of(record.position, met_by);
        let centre = (wall.state).into_wall(record.position + self.cell.any_shift(image));
        let extra_skin = self.extra_skin.get(row).copied().unwrap_or_default();
        let margin = extra_skin + self.margin.to_walls(record);
        let reach = record.radius + depth + margin + wall.half_thickness();
        let features = match wall.shape() {
            // Most walls of most scenes.
            Shape::Plane(plane) => usize::from(plane.touch(centre, reach).is_some()),
            Shape::Mesh(mesh) => usize::from(mesh.may_be_near(centre, reach, &mut self.scratch)),
            shape => {
                shape.touches(centre, reach, &mut self.touches);
                self.touches.len()
            }
        };
        (features > 0).then_some((image, features as u32))
    }
}

/// Puts entries in the order of their rows; those of a row stay in the order in which they are.
fn by_rows(found: &[Vec<NearWall>], rows: usize) -> Vec<NearWall> {
    let mut next = vec![0u32; rows + 1];
    for near in found.iter().flatten() {
        next[near.row as usize + 1] += 1;
    }
    for row in 0..rows {
        next[row + 1] += next[row];
    }
    let nothing = NearWall {
        row: 0,
        wall: WallIndex::new(0),
        image: 0,
        features: 0,
    };
    let mut sorted = vec![nothing; found.iter().map(Vec::len).sum()];
    for near in found.iter().flatten() {
        let place = &mut next[near.row as usize];
        sorted[*place as usize] = *near;
        *place += 1;
    }
    sorted
}

#[cfg(test)]
mod tests;
