//! Whether walls leave a region any place at all.

use mercury_common::random::Stream;

use super::Region;
use super::behind::is_behind_a_wall;
use super::placement::{Room, Space, of_sphere, overlaps_wall};
use super::thinning::Looks;
use crate::neighbours::Images;
use crate::walls::WallNow;

/// Places that are tried before a region counts as taken: one that has a ten-thousandth of itself free passes but for 5e-5, and with less than a
/// hundred-thousandth an insertion would find its places as rarely.
pub(crate) const PLACES: u32 = 100_000;

/// Which of these walls is in the way of most spheres of this radius (m), if all places that were tried in the region lie behind or
/// in walls; `None` as soon as one is free.
pub(crate) fn wall_in_the_way(
    region: &Region,
    radius: f64,
    space: Space,
    walls: &[WallNow],
) -> Option<usize> {
    let (low, high) = space.domain;
    let images = Images::new(low, high, space.periodic);
    let room = Room::new(region, space);
    let (sphere, extent) = ([(glam::DVec3::ZERO, radius)], of_sphere(radius));
    if walls.is_empty() || !room.has_space(extent) {
        return None;
    }
    let mut stream = Stream::new(0, "places between walls", 0);
    let mut in_the_way = vec![0_u32; walls.len()];
    for _ in 0..PLACES {
        // Where the region itself is missed nothing is known of walls.
        let place = room.draw(&sphere, extent, &mut stream, &images, &mut Looks::default())?;
        let wall = walls.iter().map(std::slice::from_ref).position(|wall| {
            overlaps_wall(wall, &images, place, radius) || is_behind_a_wall(wall, &images, place)
        });
        in_the_way[wall?] += 1;
    }
    (0..walls.len()).max_by_key(|&wall| in_the_way[wall])
}
