//! Sheets: what contacts do to their vertices, how these move, and the meshes that follow.

use glam::DVec3;

use super::{Core, RunError};
use crate::forces::{NearWall, near_walls_of_vertices};
use crate::neighbours::{Images, Margin};
use crate::state::{Load, Particle};
use crate::surface::{SavedSurface, Surface, SurfacePlan};
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
        now.set_surface(number as u16, plan.thickness);
        surfaces.push(surface);
        walls.push(now);
    }
    Ok((surfaces, walls))
}

impl Core {
    /// Adds up what contacts did to the vertices; `of_walls`: what walls did to those of each sheet, nothing if none touches walls.
    pub(super) fn load_surfaces(&mut self, of_walls: &[Vec<Load>]) {
        if self.surfaces.is_empty() {
            return;
        }
        self.surfaces.iter_mut().for_each(Surface::clear_loads);
        let surfaces = &mut self.surfaces;
        (self.contacts)
            .visit_surface_loads(&mut |load| surfaces[load.surface as usize].add_load(load));
        for (surface, loads) in self.surfaces.iter_mut().zip(of_walls) {
            surface.add_vertex_loads(loads.iter().map(|load| load.force));
        }
        if self.physics.membranes.is_empty() {
            for surface in &mut self.surfaces {
                surface.forces.clone_from(&surface.loads);
            }
        }
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
