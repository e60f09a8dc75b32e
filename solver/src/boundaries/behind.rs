//! What lies behind a one-sided wall is solid: nothing is inserted there.

use glam::DVec3;

use crate::neighbours::Images;
use crate::walls::{Scratch, WallNow};

/// Whether a centre lies behind a wall that is there and acts on one side.
pub(super) fn is_behind_a_wall(walls: &[WallNow], images: &Images, centre: DVec3) -> bool {
    let mut scratch = Scratch::default();
    let mut there = walls.iter().filter(|wall| wall.state.present);
    there.any(|wall| wall.is_behind(images, centre, &mut scratch))
}
