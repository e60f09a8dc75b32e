//! State of a sheet that must be kept to go on later.

use glam::DVec3;

use super::Surface;

/// The state of a [`Surface`].
#[derive(Debug, Clone, PartialEq)]
pub struct SavedSurface {
    /// m
    pub positions: Vec<DVec3>,
    /// m/s
    pub velocities: Vec<DVec3>,
    /// 1/kg
    pub inverse_masses: Vec<f64>,
    /// N
    pub loads: Vec<DVec3>,
    /// N
    pub triangle_loads: Vec<DVec3>,
    /// N
    pub forces: Vec<DVec3>,
    /// Positions when the candidate list was built, m.
    pub listed: Vec<DVec3>,
    /// Distance beyond that of particles that it may go before the next list, m.
    pub room: f64,
}

crate::state::plain!(SavedSurface {
    positions,
    velocities,
    inverse_masses,
    loads,
    triangle_loads,
    forces,
    listed,
    room
});

impl Surface {
    /// State that must be kept.
    #[must_use]
    pub fn save(&self) -> SavedSurface {
        SavedSurface {
            positions: self.positions.clone(),
            velocities: self.velocities.clone(),
            inverse_masses: self.inverse_masses.clone(),
            loads: self.loads.clone(),
            triangle_loads: self.triangle_loads.clone(),
            forces: self.forces.clone(),
            listed: self.listed.clone(),
            room: self.room,
        }
    }

    /// Goes on from there.
    ///
    /// # Errors
    /// If it is the state of a sheet with other vertices or triangles, or one that no run can have.
    pub fn restore(&mut self, saved: &SavedSurface) -> Result<(), String> {
        let vertices = self.positions.len();
        let columns = [
            &saved.positions,
            &saved.velocities,
            &saved.loads,
            &saved.forces,
            &saved.listed,
        ];
        let fits = columns.iter().all(|column| column.len() == vertices)
            && saved.inverse_masses.len() == vertices
            && saved.triangle_loads.len() == self.plan.triangles.len();
        if !fits {
            return Err(format!(
                "it has a membrane of {} vertices and {} triangles, the plan one of {vertices} and {}",
                saved.positions.len(),
                saved.triangle_loads.len(),
                self.plan.triangles.len()
            ));
        }
        let is_mass = |inverse: &f64| inverse.is_finite() && *inverse >= 0.0;
        let places = columns.iter().copied().flatten();
        let is_room = saved.room.is_finite() && saved.room >= 0.0;
        if !is_room
            || !saved.inverse_masses.iter().all(is_mass)
            || !places.copied().all(DVec3::is_finite)
        {
            return Err("a membrane of it has numbers that no run has".to_owned());
        }
        self.positions.clone_from(&saved.positions);
        self.velocities.clone_from(&saved.velocities);
        self.inverse_masses.clone_from(&saved.inverse_masses);
        self.loads.clone_from(&saved.loads);
        self.triangle_loads.clone_from(&saved.triangle_loads);
        self.is_loaded = true;
        self.forces.clone_from(&saved.forces);
        self.listed.clone_from(&saved.listed);
        self.room = saved.room;
        Ok(())
    }
}
