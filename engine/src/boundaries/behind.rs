//! Solid space behind one-sided walls: insertions place nothing there. A wall that acts on both sides has no solid side.

use glam::DVec3;

use crate::cell::Cell;
use crate::walls::{Scratch, WallNow};

/// Whether a centre lies behind a wall that is there and acts on one side.
pub(super) fn is_behind_a_wall(walls: &[WallNow], cell: &Cell, centre: DVec3) -> bool {
    let mut scratch = Scratch::default();
    let mut there = walls.iter().filter(|wall| wall.state.present);
    there.any(|wall| wall.is_behind(cell, centre, &mut scratch))
}

/// Whether a centre lies on the side from which a wall that is there, and acts on both sides, has come.
pub(super) fn is_in_wake(wall: &WallNow, cell: &Cell, centre: DVec3) -> bool {
    wall.state.present && wall.is_in_wake(cell, centre, &mut Scratch::default())
}
