//! What lies behind a one-sided wall is solid: Insertions place nothing there. A wall that acts on both sides has no solid side.

use glam::DVec3;

use crate::neighbours::Images;
use crate::walls::{Scratch, WallNow};

/// Whether a centre lies behind a wall that is there and acts on one side.
pub(super) fn is_behind_a_wall(walls: &[WallNow], images: &Images, centre: DVec3) -> bool {
    let mut scratch = Scratch::default();
    let mut there = walls.iter().filter(|wall| wall.state.present);
    there.any(|wall| wall.is_behind(images, centre, &mut scratch))
}

/// Whether a centre lies on the side from which a wall that is there, and acts on both sides, has come.
pub(super) fn is_in_wake(wall: &WallNow, images: &Images, centre: DVec3) -> bool {
    wall.state.present && wall.is_in_wake(images, centre, &mut Scratch::default())
}
