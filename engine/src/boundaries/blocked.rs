//! Whether walls leave a region any place at all.

use glam::DVec3;
use mercury_common::random::Stream;

use super::Region;
use super::behind::is_behind_a_wall;
use super::placement::{PlacementRegion, Space, of_sphere, overlaps_wall};
use crate::walls::WallNow;

/// The number of random positions after which a region counts as blocked: a region of which a ten-thousandth is free is missed
/// with a probability of 5e-5, and with less than a hundred-thousandth an insertion would find positions as rarely.
pub const PLACES: u32 = 100_000;

/// The number of random positions from which the blocked share is estimated, if some are free: right to 3 %.
const FEW: u32 = 1_000;

/// The part of a region that walls leave free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blocked {
    /// Number of the wall that blocks most positions.
    pub wall: usize,
    /// Share of the places that lie behind or in walls; 1 if none is free.
    pub share: f64,
}

/// The blocked part of a region for spheres of this radius (m) among these walls; `None` without walls, or where the region
/// itself has no position.
pub fn blocked(
    region: &Region,
    radius: f64,
    space: Space<'_>,
    walls: &[WallNow],
) -> Option<Blocked> {
    let cell = space.cell;
    let room = PlacementRegion::new(region, space);
    let (sphere, extent) = ([(DVec3::ZERO, radius)], of_sphere(radius));
    if walls.is_empty() || !room.has_space(extent, cell) {
        return None;
    }
    let mut stream = Stream::new(0, "places between walls", 0);
    let mut in_the_way = vec![0_u32; walls.len()];
    let (mut tried, mut free) = (0, 0);
    while tried < if free > 0 { FEW } else { PLACES } {
        // If the region itself is missed, nothing is known about walls.
        let place = room.draw(&sphere, extent, &mut stream, cell)?;
        let wall = walls.iter().map(std::slice::from_ref).position(|wall| {
            overlaps_wall(wall, cell, place, radius) || is_behind_a_wall(wall, cell, place)
        });
        tried += 1;
        match wall {
            Some(wall) => in_the_way[wall] += 1,
            None => free += 1,
        }
    }
    let wall = (0..walls.len()).max_by_key(|&wall| in_the_way[wall])?;
    let share = 1.0 - f64::from(free) / f64::from(tried);
    Some(Blocked { wall, share })
}

/// At most this many random positions (m) in a region for spheres of this radius (m).
pub fn places(region: &Region, radius: f64, space: Space<'_>, number: usize) -> Vec<DVec3> {
    let cell = space.cell;
    let room = PlacementRegion::new(region, space);
    let (sphere, extent) = ([(DVec3::ZERO, radius)], of_sphere(radius));
    if !room.has_space(extent, cell) {
        return Vec::new();
    }
    let mut stream = Stream::new(0, "places in a region", 0);
    let draws = (0..number).filter_map(|_| room.draw(&sphere, extent, &mut stream, cell));
    draws.collect()
}
