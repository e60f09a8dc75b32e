//! Walls: their positions at the present time, their shapes, and the loads that servos receive.

use glam::{DQuat, DVec3};

use super::{Core, Engine, RunError};
use crate::forces::Observation;
use crate::state::WallIndex;
use crate::walls::{Drive, SectionBox, Shape, WallError, area};

impl Engine {
    /// Gives walls the surfaces that parts set.
    pub(super) fn reshape_walls(&mut self) -> Result<(), RunError> {
        if !self.constants.needs.reshapes_walls {
            return Ok(());
        }
        let Self { core, parts, .. } = self;
        for part in parts {
            for new in part.reshape_walls(core) {
                core.reshape_wall(new.wall, &new.corners)?;
                let wall = &mut core.domain.walls[new.wall.index()];
                let moving = wall.set_corner_velocities(new.velocities);
                moving.map_err(|error| core.wall_error(new.wall, error))?;
            }
        }
        Ok(())
    }
}

impl Core {
    /// Moves the walls to the present time.
    pub(super) fn move_walls(&mut self) {
        let (time, dt) = (self.time(), self.physics.time_step);
        for (wall, now) in self.physics.walls.iter().zip(&mut self.domain.walls) {
            now.advance(wall, time, dt, &self.domain.cell);
        }
    }

    /// Puts the corners of a mesh wall, by its number in the plan, to new places in the wall's frame, m: [`crate::walls::WallNow::reshape`]. It acts
    /// from the next step on, at rest in that frame: parts that move a surface give its velocities
    /// ([`Part::reshape_walls`](super::Part::reshape_walls)).
    ///
    /// # Errors
    /// If there is no such wall, or it cannot take these places; it stays as it was then.
    pub fn reshape_wall(&mut self, wall: WallIndex, corners: &[DVec3]) -> Result<(), RunError> {
        let Some(now) = self.domain.walls.get_mut(wall.index()) else {
            return Err(self.wall_error(wall, WallError::OtherShape));
        };
        let changed = now.reshape(corners, &self.domain.cell);
        changed.map_err(|error| self.wall_error(wall, error))
    }

    /// Drives a wall whose motion the scene leaves to another program, as [`Core::next_drive`] says.
    ///
    /// # Errors
    /// As of that.
    pub fn drive_wall(
        &mut self,
        wall: WallIndex,
        until: f64,
        to: (DVec3, DQuat),
        velocities: [DVec3; 2],
    ) -> Result<(), RunError> {
        let drive = self.next_drive(wall, until, to, velocities)?;
        self.domain.walls[wall.index()].set_drive(drive);
        Ok(())
    }

    /// The motion of a wall from now until `until` (s): [`crate::walls::WallNow::next_drive`].
    ///
    /// # Errors
    /// If there is no such wall, its motion is that of the scene, or a number is not finite.
    pub fn next_drive(
        &self,
        wall: WallIndex,
        until: f64,
        to: (DVec3, DQuat),
        velocities: [DVec3; 2],
    ) -> Result<Drive, RunError> {
        let of_plan = self.physics.walls.get(wall.index());
        let drive = match of_plan.zip(self.walls().get(wall.index())) {
            Some((of_plan, now)) => now.next_drive(of_plan, [self.time(), until], to, velocities),
            None => Err(WallError::NotExternal),
        };
        drive.map_err(|error| self.wall_error(wall, error))
    }

    /// Exchanges the surface of another wall for one of the same kind: [`crate::walls::WallNow::exchange`].
    ///
    /// # Errors
    /// As [`Core::reshape_wall`].
    pub fn exchange_wall(&mut self, wall: WallIndex, shape: Shape) -> Result<(), RunError> {
        let Some(now) = self.domain.walls.get_mut(wall.index()) else {
            return Err(self.wall_error(wall, WallError::OtherShape));
        };
        let changed = now.exchange(shape, &self.domain.cell);
        changed.map_err(|error| self.wall_error(wall, error))
    }

    /// Passes the loads of the force evaluation just made to the servos of their walls.
    pub(super) fn answer_loads(&mut self, observation: &Observation) {
        let physics = &self.physics;
        let (time, dt) = (self.time(), physics.time_step);
        let (min, max) = physics.cell.corners();
        let room = SectionBox::new(min, max, physics.dimensions);
        for (index, wall) in self.physics.walls.iter().enumerate() {
            for (number, (motor, axis)) in wall.motion.servos(time).enumerate() {
                let mut state = self.domain.walls[index].servos[number];
                if self.domain.walls[index].state.present {
                    // The load is that of the particles on the wall.
                    let force = -observation.walls[index].0.force.dot(axis);
                    let area = motor.area(|| area(&self.domain.walls, index, axis, &room));
                    let stiffness = &observation.wall_stiffness[index];
                    motor.follow(&mut state, (force, area), stiffness, (time, dt));
                } else {
                    state.next_velocity = 0.0;
                }
                self.domain.walls[index].servos[number] = state;
            }
        }
    }

    /// Error of a wall, by its name.
    pub(crate) fn wall_error(&self, wall: WallIndex, error: WallError) -> RunError {
        let of_plan = self.physics.walls.get(wall.index());
        RunError::Wall {
            wall: of_plan.map_or(wall.to_string(), |wall| wall.name.clone()),
            error,
        }
    }
}
