//! Walls: where they stand at the present time, and what servos are told.

use super::Engine;

impl Engine {
    /// Moves the walls to the present time.
    pub(super) fn move_walls(&mut self) {
        let (time, dt) = (self.time(), self.plan.time_step);
        for (wall, servo) in self.plan.walls.iter().zip(&mut self.servos) {
            if let Some((motor, _)) = wall.motion.servo(time) {
                *servo = motor.advance(*servo, time, dt);
            }
        }
        for (index, (wall, state)) in
            (self.plan.walls.iter().zip(&mut self.wall_states)).enumerate()
        {
            if wall.motion.is_static() {
                state.present = wall.is_present(time, self.plan.time_step);
            } else {
                let driven = self.servos.get(index).copied().unwrap_or_default();
                *state = wall.driven_state(time, dt, &driven);
            }
        }
    }

    /// Tells the servos what their walls felt in the force evaluation just made.
    pub(super) fn answer_loads(&mut self) {
        if self.servos.is_empty() {
            return;
        }
        let (time, dt) = (self.time(), self.plan.time_step);
        let seen = self.observation();
        for (index, wall) in self.plan.walls.iter().enumerate() {
            let Some((motor, axis)) = wall.motion.servo(time) else {
                continue;
            };
            self.servos[index].next_velocity = if self.wall_states[index].present {
                // The load is that of the particles on the wall.
                let force = -seen.walls[index].0.force.dot(axis);
                motor.answer(force, &seen.grips[index], dt)
            } else {
                0.0
            };
        }
    }
}
