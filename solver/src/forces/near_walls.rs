//! Which particles are near which walls: found with the candidate list, so that a step tests only those.

use glam::DVec3;
use rayon::prelude::*;

use crate::neighbours::Images;
use crate::particles::{Particle, Particles};
use crate::walls::{
    Mesh, NearFacet, Scratch, Shape, Touches, Wall, WallState, image_between_faces, images_met,
};

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
    /// Of a mesh: index of the facets in [`NearWalls::meshes`]; otherwise [`NO_MESH`].
    pub mesh: u32,
}

/// [`NearWall::mesh`] of walls that are no mesh.
pub const NO_MESH: u32 = u32::MAX;

/// What [`find_near_walls`] finds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NearWalls {
    /// By rows.
    pub near: Vec<NearWall>,
    /// Facets near those that are near a mesh.
    pub meshes: NearMeshes,
}

/// The facets near each particle that is near a mesh, one list behind the other.
///
/// On a mesh that is finer than the skin a list is long, but few of its facets are touched. They are sifted now and then into a
/// shorter list with a thinner skin. That changes no result, so it is no part of the state.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NearMeshes {
    lists: Vec<List>,
    facets: Vec<NearFacet>,
    /// The sifted lists, each at the beginning of the room that its full list has.
    sifted: Vec<NearFacet>,
}

/// Where a list ends, and for which place of the particle it was made.
#[derive(Debug, Clone, Copy, PartialEq)]
struct List {
    centre: DVec3,
    end: usize,
    /// The place for which it was sifted; not a number if it was not.
    sifted_at: DVec3,
    sifted: usize,
}

/// Lists up to this length are not sifted.
const SHORT: usize = 6;
/// Thickness of the thinner skin over the radius.
const THIN: f64 = 0.03;

impl NearMeshes {
    /// Adds a list, made for a particle at `centre` (m, in the wall's frame). Returns its index.
    pub fn push(&mut self, centre: DVec3, facets: &[NearFacet]) -> u32 {
        self.facets.extend_from_slice(facets);
        let end = self.facets.len();
        self.lists.push(List {
            centre,
            end,
            sifted_at: DVec3::NAN,
            sifted: 0,
        });
        (self.lists.len() - 1) as u32
    }

    /// The place for which a list was made, and the facets that were within reach.
    #[must_use]
    pub fn list(&self, index: u32) -> (DVec3, &[NearFacet]) {
        let (begin, list) = self.find(index as usize);
        (list.centre, &self.facets[begin..list.end])
    }

    fn find(&self, index: usize) -> (usize, List) {
        let begin = match index {
            0 => 0,
            _ => self.lists[index - 1].end,
        };
        (begin, self.lists[index])
    }

    /// Replaces `touches` by the contacts of a sphere of `radius` (m) at `centre` (m, in the wall's frame).
    pub fn touches(
        &mut self,
        index: u32,
        mesh: &Mesh,
        centre: DVec3,
        radius: f64,
        scratch: &mut Scratch,
        touches: &mut Touches,
    ) {
        let (begin, list) = self.find(index as usize);
        let moved = centre.distance(list.centre);
        let near = &self.facets[begin..list.end];
        if near.len() <= SHORT {
            mesh.touches_of(near, moved, centre, radius, scratch, touches);
            return;
        }
        let mut since = centre.distance(list.sifted_at);
        let mut count = list.sifted;
        let within = since <= THIN * radius;
        if !within {
            self.sifted.resize(self.facets.len(), near[0]);
            let room = &mut self.sifted[begin..list.end];
            count = mesh.sift(near, moved, centre, radius * (1.0 + THIN), room);
            since = 0.0;
            let list = &mut self.lists[index as usize];
            (list.sifted_at, list.sifted) = (centre, count);
        }
        let sifted = &self.sifted[begin..begin + count];
        mesh.touches_of(sifted, since, centre, radius, scratch, touches);
    }

    /// Adds the lists of `other` behind these.
    fn append(&mut self, other: &Self) {
        let before = self.facets.len();
        self.facets.extend_from_slice(&other.facets);
        self.lists.extend(other.lists.iter().map(|list| List {
            end: list.end + before,
            ..*list
        }));
    }
}

/// Finds every particle whose surface is closer than `margin` (m) to a wall, by rows.
///
/// Walls that end inside a periodic domain are met by images too; a wall that spans a period is met once, a mesh that goes on for
/// ever by the image that is between its faces.
#[must_use]
pub fn find_near_walls(
    particles: &Particles,
    walls: &[Wall],
    states: &[WallState],
    images: &Images,
    margin: f64,
    parallel: bool,
) -> NearWalls {
    let codes: Vec<Vec<u32>> = walls.iter().map(|wall| images_met(wall, images)).collect();
    let search = |(chunk, records): (usize, &[Particle])| {
        let mut found = NearWalls::default();
        let mut touches = Touches::default();
        let (mut facets, mut scratch) = (Vec::new(), Scratch::default());
        for (index, wall) in walls.iter().enumerate() {
            for &code in &codes[index] {
                for (k, record) in records.iter().enumerate() {
                    let (state, place) = (&states[index], record.position);
                    let image = image_between_faces(wall, state, images, place, code);
                    let centre = state.into_wall(place + images.shift(image));
                    let reach = record.radius + margin;
                    let mut mesh = NO_MESH;
                    let features = match &wall.shape {
                        // Most walls of most scenes.
                        Shape::Plane(plane) => usize::from(plane.touch(centre, reach).is_some()),
                        // Particles that contacts cannot move do not feel walls.
                        _ if record.inverse_mass == 0.0 => 0,
                        Shape::Mesh(triangles) => {
                            facets.clear();
                            triangles.near(centre, reach, &mut scratch, &mut facets);
                            if !facets.is_empty() {
                                mesh = found.meshes.push(centre, &facets);
                            }
                            usize::from(!facets.is_empty())
                        }
                        shape => {
                            shape.touches(centre, reach, &mut touches);
                            touches.len()
                        }
                    };
                    if features > 0 && record.inverse_mass > 0.0 {
                        found.near.push(NearWall {
                            row: (chunk * CHUNK + k) as u32,
                            wall: index as u16,
                            image: image as u8,
                            features: features as u8,
                            mesh,
                        });
                    }
                }
            }
        }
        // Stable: within a row the order of the walls stays.
        found.near.sort_by_key(|near| near.row);
        found
    };
    let records = &particles.records;
    let chunks: Vec<NearWalls> = if parallel {
        records.par_chunks(CHUNK).enumerate().map(search).collect()
    } else {
        records.chunks(CHUNK).enumerate().map(search).collect()
    };
    let mut all = NearWalls::default();
    for chunk in &chunks {
        let before = all.meshes.lists.len() as u32;
        all.near.extend(chunk.near.iter().map(|near| NearWall {
            mesh: match near.mesh {
                NO_MESH => NO_MESH,
                mesh => mesh + before,
            },
            ..*near
        }));
        all.meshes.append(&chunk.meshes);
    }
    all
}

/// Rows that are searched together.
const CHUNK: usize = 1024;
