//! Sheets: what contacts do to their vertices, how these move, and the meshes that follow.

use glam::DVec3;

use super::crossings::SEEN;
use super::{Core, RunError};
use crate::contact::parameter::short;
use crate::forces::{NearWall, Observation, near_walls_of_vertices};
use crate::membrane::{Fault, MembraneNow, MembranePlan, Moment, STRETCHES, SavedMembrane};
use crate::neighbours::{Images, Margin};
use crate::physics::GuardPolicy;
use crate::state::Particle;
use crate::surface::{SavedSurface, Surface, SurfaceMotion, SurfacePlan};
use crate::walls::{Wall, WallNow};

/// The sheets of a plan at rest, and the walls that borrow their shapes.
pub(super) fn start(
    plans: &[SurfacePlan],
    dt: f64,
    images: &Images,
) -> Result<(Vec<Surface>, Vec<WallNow>), RunError> {
    let mut surfaces = Vec::with_capacity(plans.len());
    let mut walls = Vec::with_capacity(plans.len());
    for (number, plan) in plans.iter().enumerate() {
        let made = Surface::new(plan).map_err(|error| RunError::Surface {
            surface: plan.name.clone(),
            step: 0,
            time: 0.0,
            error,
        });
        let (surface, wall): (Surface, Wall) = made?;
        let mut now = WallNow::new(&wall, dt, images);
        now.set_surface(number as u16);
        surfaces.push(surface);
        walls.push(now);
    }
    Ok((surfaces, walls))
}

/// The mechanics of the sheets, and what holds them at the start.
pub(super) fn start_membranes(
    (plans, surfaces): (&[MembranePlan], &mut [Surface]),
    at: &Moment<'_>,
) -> Vec<MembraneNow> {
    (plans.iter().zip(surfaces))
        .map(|(plan, surface)| MembraneNow::new(plan, surface, at))
        .collect()
}

/// Of the parts of an engine, as these are borrowed one by one.
macro_rules! moment {
    ($engine:ident) => {
        Moment {
            time: $engine.step as f64 * $engine.physics.time_step,
            dt: $engine.physics.time_step,
            gravity: $engine.physics.gravity,
            walls: &$engine.walls,
            images: &$engine.images,
            has_pool: $engine.pool.is_some(),
            width: $engine.width,
        }
    };
}

impl Core {
    /// Half kicks of the vertices, as many as particles get in this step, and their drift; then the meshes follow. A mesh that no particle is
    /// near is left where it was until the candidate list is built. `fastest`: of the particles, m/s.
    pub(super) fn advance_surfaces(&mut self, kicks: u32, fastest: f64) -> Result<(), RunError> {
        if self.surfaces.is_empty() {
            return Ok(());
        }
        self.surface_motion = self.kick_surfaces(kicks, self.physics.time_step);
        let physics = &self.physics;
        let first = physics.walls.len();
        // Others than contacts look for walls, too.
        let fastest = fastest.max(self.surface_motion.squared_speed.sqrt());
        let is_fast = !self.particles.is_empty()
            && fastest * physics.time_step > SEEN * physics.smallest_radius();
        let all = is_fast || self.needs.all_walls || self.boundaries.expects_more();
        for number in 0..self.surfaces.len() {
            if all || self.is_near[number] {
                self.follow_surface(number)?;
            } else {
                let way = self.surfaces[number].way_since_listed();
                self.walls[first + number].note_way(way);
                self.stale[number] = true;
            }
        }
        Ok(())
    }

    /// Puts the mesh of a sheet to where its vertices are.
    fn follow_surface(&mut self, number: usize) -> Result<(), RunError> {
        let first = self.physics.walls.len();
        let surface = &self.surfaces[number];
        let wall = &mut self.walls[first + number];
        let (corners, way) = (surface.corners(), surface.way_since_listed());
        // Triangles that were left behind for many steps may have turned.
        let is_stale = std::mem::take(&mut self.stale[number]);
        let images = &self.images;
        let mut follow = || {
            if is_stale {
                wall.follow_anew(&corners, way, images)
            } else {
                wall.follow(&corners, way, images)
            }
        };
        let followed = match self.pool.as_deref() {
            Some(pool) => pool.install(follow),
            None => follow(),
        };
        followed.map_err(|error| RunError::Surface {
            surface: self.physics.surfaces[number].name.clone(),
            step: self.step,
            time: self.step as f64 * self.physics.time_step,
            error,
        })
    }

    /// The candidate list is to be built: meshes that were left behind follow.
    pub(super) fn freshen_surfaces(&mut self) -> Result<(), RunError> {
        if self.particles.is_empty() {
            return Ok(());
        }
        let first = self.physics.walls.len();
        for number in 0..self.surfaces.len() {
            if self.stale[number] {
                self.follow_surface(number)?;
            }
            self.walls[first + number].fit();
        }
        Ok(())
    }

    /// Notes which sheets the particles of a new list are near.
    pub(super) fn note_near_surfaces(&mut self, near: &[NearWall]) {
        let first = self.physics.walls.len();
        self.is_near.fill(false);
        for near in near {
            if let Some(is_near) = near.wall.index().checked_sub(first) {
                self.is_near[is_near] = true;
            }
        }
    }

    /// Half kicks of the vertices, and a drift of `drift` seconds.
    pub(super) fn kick_surfaces(&mut self, kicks: u32, drift: f64) -> SurfaceMotion {
        let (half, gravity) = (0.5 * self.physics.time_step, self.physics.gravity);
        let mut all = SurfaceMotion::default();
        let at = moment!(self);
        let plans = &self.physics.membranes;
        for (number, surface) in self.surfaces.iter_mut().enumerate() {
            let motion = match self.membranes.get_mut(number) {
                Some(membrane) => membrane.advance(&plans[number], surface, (kicks, drift), &at),
                None => surface.advance(kicks, (half, drift), gravity),
            };
            all = all.merge(motion);
        }
        all
    }

    /// Adds up what contacts did to the vertices, and then all other forces on them.
    pub(super) fn load_surfaces(&mut self) {
        if self.surfaces.is_empty() {
            return;
        }
        self.surfaces.iter_mut().for_each(Surface::clear_loads);
        let surfaces = &mut self.surfaces;
        (self.contacts)
            .visit_surface_loads(&mut |load| surfaces[load.surface as usize].add_load(load));
        for (surface, loads) in self.surfaces.iter_mut().zip(&self.vertex_loads) {
            surface.add_vertex_loads(loads.iter().map(|load| load.force));
        }
        if self.membranes.is_empty() {
            for surface in &mut self.surfaces {
                surface.forces.clone_from(&surface.loads);
            }
        }
        self.add_inner_forces();
    }

    /// Whether vertices of some sheet touch walls.
    fn vertices_touch_walls(&self) -> bool {
        let mut plans = self.physics.surfaces.iter();
        plans.any(|plan| plan.touches_walls)
    }

    /// The vertices of all sheets as spheres, sheet by sheet; nothing if none touches walls.
    pub(super) fn all_vertex_spheres(&self) -> Vec<Vec<Particle>> {
        if !self.vertices_touch_walls() {
            return Vec::new();
        }
        let numbers = 0..self.surfaces.len();
        numbers.map(|number| self.vertex_spheres(number)).collect()
    }

    /// The vertices of a sheet as spheres of half its thickness; none if they do not touch walls.
    fn vertex_spheres(&self, number: usize) -> Vec<Particle> {
        let plan = &self.physics.surfaces[number];
        let surface = &self.surfaces[number];
        let count = if plan.touches_walls {
            surface.positions.len()
        } else {
            0
        };
        let sphere = |k: usize| Particle {
            position: surface.positions[k],
            radius: 0.5 * plan.thickness,
            velocity: surface.velocities[k],
            inverse_mass: surface.inverse_masses[k],
            angular_velocity: DVec3::ZERO,
            material: plan.material,
            flags: 0,
        };
        (0..count).map(sphere).collect()
    }

    /// Finds which vertices may touch walls before the next list; they and the walls each move by `skin` (m) until then.
    pub(super) fn list_vertices(&mut self, skin: f64) {
        if !self.vertices_touch_walls() {
            return;
        }
        let walls = &self.walls[..self.physics.walls.len()];
        let range = self.needs.range;
        let margin = Margin::of_skin(2.0 * skin + range);
        let near: Vec<Vec<NearWall>> = (0..self.surfaces.len())
            .map(|number| {
                let vertices = self.vertex_spheres(number);
                near_walls_of_vertices(&vertices, walls, &self.images, &margin)
            })
            .collect();
        self.contacts.adopt_vertices(&near);
    }

    /// Forces inside the sheets, pressure and drag go here: they are added to [`Surface::forces`], for the positions of the present step and
    /// the velocities of half a step before.
    fn add_inner_forces(&mut self) {
        let since = self.since_last();
        let at = moment!(self);
        let plans = self.physics.membranes.iter();
        for ((plan, surface), membrane) in (plans.zip(&mut self.surfaces)).zip(&mut self.membranes)
        {
            membrane.add_forces(plan, surface, since, &at);
            membrane.update_holds(plan, surface, &at);
        }
    }

    /// What sheets do to walls that hold their vertices is part of the loads of these walls.
    pub(super) fn add_holds_to_walls(&self, observation: &mut Observation) {
        let plans = self.physics.membranes.iter();
        for (plan, membrane) in plans.zip(&self.membranes) {
            for (wall, (load, power)) in observation.walls.iter_mut().enumerate() {
                let state = &self.walls[wall].state;
                let Some((force, torque)) = membrane.load_on_wall(plan, wall, state.reference)
                else {
                    continue;
                };
                load.add(force, torque);
                let at_reference = state.velocity.at(state.reference);
                *power -= force.dot(at_reference) + torque.dot(state.velocity.angular_velocity);
            }
        }
    }

    /// Sheets that are stretched or turned beyond the limits stop the run, or are counted.
    pub(super) fn guard_membranes(&mut self) -> Result<(), RunError> {
        let policy = self.physics.guard.policy;
        for (number, plan) in self.physics.membranes.iter().enumerate() {
            let surface = &self.surfaces[number];
            let Some(fault) = self.membranes[number].fault(plan, surface) else {
                continue;
            };
            let is_lost = matches!(fault, Fault::NotFinite { .. });
            if policy == GuardPolicy::Strict || is_lost {
                return Err(RunError::Guarded {
                    step: self.step,
                    time: self.time(),
                    what: self.words_of(number, &fault),
                    help: "the time step is too large for the sheet, or its loads are too large for its stiffness, or a hold is too fast; or go on with guard.policy = \"warn\"".to_owned(),
                });
            }
            if policy == GuardPolicy::Warn {
                self.membranes[number].faults += 1;
            }
        }
        Ok(())
    }

    fn words_of(&self, number: usize, fault: &Fault) -> String {
        let name = &self.physics.surfaces[number].name;
        let surface = &self.surfaces[number];
        let at = |vertex: u32| {
            let [x, y, z] = surface.positions[vertex as usize].to_array().map(short);
            format!("[{x}, {y}, {z}] m")
        };
        match *fault {
            Fault::Stretch { ends, stretch } => format!(
                "membranes.{name}: the edge between the vertices {} and {}, at {}, has {} of its length at rest; {} to {} are allowed",
                ends[0],
                ends[1],
                at(ends[0]),
                short(stretch),
                STRETCHES[0],
                STRETCHES[1]
            ),
            Fault::TurnedOver { triangle } => format!(
                "membranes.{name}: triangle {triangle}, at {}, turned over within a step",
                at(surface.triangles()[triangle as usize][0])
            ),
            Fault::NotFinite { vertex } => {
                format!("membranes.{name}: vertex {vertex} has left the numbers")
            }
        }
    }

    /// What a user should know of sheets, a line each.
    #[must_use]
    pub fn membrane_warnings(&self) -> Vec<String> {
        let names = self.physics.surfaces.iter();
        (names.zip(&self.membranes))
            .filter(|(_, membrane)| membrane.faults > 0)
            .map(|(surface, membrane)| {
                format!(
                    "membranes.{}: in {} steps an edge was shorter than {} or longer than {} of its length at rest, or a triangle turned over",
                    surface.name, membrane.faults, STRETCHES[0], STRETCHES[1]
                )
            })
            .collect()
    }

    /// The mechanics of the sheets, in the order of the plan; none where sheets have no inner forces.
    #[must_use]
    pub fn membranes(&self) -> &[MembraneNow] {
        &self.membranes
    }

    pub(super) fn saved_membranes(&self) -> Vec<SavedMembrane> {
        self.membranes.iter().map(MembraneNow::save).collect()
    }

    pub(super) fn restore_membranes(&mut self, saved: &[SavedMembrane]) -> Result<(), String> {
        if saved.len() != self.membranes.len() {
            return Err(format!(
                "it has the mechanics of {} membranes, the plan of {}",
                saved.len(),
                self.membranes.len()
            ));
        }
        let plans = self.physics.membranes.iter();
        for (((plan, surface), membrane), saved) in (plans.zip(&self.surfaces))
            .zip(&mut self.membranes)
            .zip(saved)
        {
            membrane.restore(plan, surface, saved)?;
        }
        Ok(())
    }

    /// The sheets as they are now, in the order of the plan.
    #[must_use]
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    pub(super) fn saved_surfaces(&self) -> Vec<SavedSurface> {
        self.surfaces.iter().map(Surface::save).collect()
    }

    pub(super) fn restore_surfaces(&mut self, saved: &[SavedSurface]) -> Result<(), String> {
        let first = self.physics.walls.len();
        if saved.len() != self.surfaces.len() {
            return Err(format!(
                "it has {} membranes, the plan {}",
                saved.len(),
                self.surfaces.len()
            ));
        }
        let surfaces = self.surfaces.iter_mut().zip(&mut self.walls[first..]);
        for ((number, saved), (surface, wall)) in saved.iter().enumerate().zip(surfaces) {
            surface.restore(saved)?;
            let way = surface.way_since_listed();
            let followed = wall.follow_anew(&surface.corners(), way, &self.images);
            let name = &self.physics.surfaces[number].name;
            followed.map_err(|error| format!("membranes.{name}: {error}"))?;
        }
        Ok(())
    }
}
