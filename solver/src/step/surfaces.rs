//! Sheets: what contacts do to their vertices, how these move, and the meshes that follow.

use super::{Engine, RunError};
use crate::neighbours::Images;
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

impl Engine {
    /// Half kicks of the vertices, as many as particles get in this step, and their drift; then the meshes follow.
    pub(super) fn advance_surfaces(&mut self, kicks: u32) -> Result<(), RunError> {
        if self.surfaces.is_empty() {
            return Ok(());
        }
        self.surface_motion = self.kick_surfaces(kicks, self.plan.physics().time_step());
        let first = self.plan.physics().walls().len();
        for (number, surface) in self.surfaces.iter().enumerate() {
            let wall = &mut self.walls[first + number];
            let followed =
                wall.follow(&surface.corners(), surface.way_since_listed(), &self.images);
            followed.map_err(|error| RunError::Surface {
                surface: self.plan.physics().surfaces()[number].name.clone(),
                step: self.step,
                time: self.time(),
                error,
            })?;
        }
        Ok(())
    }

    /// Half kicks of the vertices, and a drift of `drift` seconds.
    pub(super) fn kick_surfaces(&mut self, kicks: u32, drift: f64) -> SurfaceMotion {
        let (half, gravity) = (
            0.5 * self.plan.physics().time_step(),
            self.plan.physics().gravity(),
        );
        let mut all = SurfaceMotion::default();
        for surface in &mut self.surfaces {
            let motion = surface.advance(kicks, (half, drift), gravity);
            all.squared_speed = all.squared_speed.max(motion.squared_speed);
            all.sum_of_squares += motion.sum_of_squares;
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
        (self.forces.contacts)
            .visit_surface_loads(&mut |load| surfaces[load.surface as usize].add_load(load));
        for surface in &mut self.surfaces {
            surface.forces.clone_from(&surface.loads);
        }
        self.add_inner_forces();
    }

    /// Forces inside the sheets, pressure and drag go here: they are added to [`Surface::forces`], for the positions of the present step and
    /// the velocities of half a step before.
    fn add_inner_forces(&mut self) {}

    /// The sheets as they are now, in the order of the plan.
    #[must_use]
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    pub(super) fn saved_surfaces(&self) -> Vec<SavedSurface> {
        self.surfaces.iter().map(Surface::save).collect()
    }

    pub(super) fn restore_surfaces(&mut self, saved: &[SavedSurface]) -> Result<(), RunError> {
        let first = self.plan.physics().walls().len();
        if saved.len() != self.surfaces.len() {
            return Err(RunError::OtherPlan(format!(
                "it has {} membranes, the plan {}",
                saved.len(),
                self.surfaces.len()
            )));
        }
        let surfaces = self.surfaces.iter_mut().zip(&mut self.walls[first..]);
        for ((number, saved), (surface, wall)) in saved.iter().enumerate().zip(surfaces) {
            surface.restore(saved).map_err(RunError::OtherPlan)?;
            let way = surface.way_since_listed();
            let followed = wall.follow_anew(&surface.corners(), way, &self.images);
            followed.map_err(|error| RunError::Surface {
                surface: self.plan.physics().surfaces()[number].name.clone(),
                step: self.step,
                time: self.step as f64 * self.plan.physics().time_step(),
                error,
            })?;
        }
        Ok(())
    }
}
