//! Sheets: what contacts do to their vertices, how these move, and the meshes that follow.

use glam::DVec3;

use super::{Core, RunError};
use crate::cell::Cell;
use crate::forces::{NearWall, near_walls_of_vertices};
use crate::membrane::MembranePlan;
use crate::neighbours::Margin;
use crate::state::{Load, Particle};
use crate::surface::{SavedSurface, Surface, SurfaceLoad};
use crate::walls::{Wall, WallNow};

/// The sheets of a plan at rest, and the walls that borrow their shapes.
pub(super) fn start(
    plans: &[MembranePlan],
    dt: f64,
    cell: &Cell,
) -> Result<(Vec<Surface>, Vec<WallNow>), RunError> {
    let mut surfaces = Vec::with_capacity(plans.len());
    let mut walls = Vec::with_capacity(plans.len());
    for (number, MembranePlan { surface: plan, .. }) in plans.iter().enumerate() {
        let made = Surface::new(plan).map_err(|error| RunError::Surface {
            surface: plan.name.clone(),
            step: 0,
            time: 0.0,
            error,
        });
        let (surface, wall): (Surface, Wall) = made?;
        let mut now = WallNow::new(&wall, dt, cell);
        now.set_surface(number as u16, plan.thickness);
        surfaces.push(surface);
        walls.push(now);
    }
    Ok((surfaces, walls))
}

/// Largest part of a period by which a sheet may go farther than particles.
const LEAST_PART: f64 = 0.1;
/// Largest distance, in skins, that a sheet may go farther than particles where its vertices touch walls.
const MOST_BESIDE_WALLS: f64 = 4.0;

/// How far a place is from a box or its nearest image, m.
fn gap(place: DVec3, (low, high): (DVec3, DVec3), cell: &Cell) -> f64 {
    let mut gap = DVec3::ZERO;
    for axis in 0..3 {
        let (x, from, to) = (place[axis], low[axis], high[axis]);
        gap[axis] = if cell.is_periodic(axis) {
            let (size, length) = (cell.size()[axis], to - from);
            let ahead = (x - from).rem_euclid(size);
            if length >= size || ahead <= length {
                0.0
            } else {
                (ahead - length).min(size - ahead)
            }
        } else {
            (from - x).max(x - to).max(0.0)
        };
    }
    gap.length()
}

impl Core {
    /// Adds up what contacts did to the vertices; `of_walls`: what walls did to those of each sheet, nothing if none touches walls.
    pub(super) fn load_surfaces(&mut self, of_walls: &[Vec<Load>]) {
        if self.domain.surfaces.is_empty() {
            return;
        }
        self.domain
            .surfaces
            .iter_mut()
            .for_each(Surface::clear_loads);
        // In the order of the blocks, of all ranks.
        if self.is_divided() {
            let mut loads: Vec<SurfaceLoad> = Vec::new();
            (self.contacts).visit_surface_loads(&mut |load| loads.push(*load));
            self.join_ranks(&mut loads);
            for load in &loads {
                self.domain.surfaces[load.surface as usize].add_load(load);
            }
        } else {
            let surfaces = &mut self.domain.surfaces;
            (self.contacts)
                .visit_surface_loads(&mut |load| surfaces[load.surface as usize].add_load(load));
        }
        for (surface, loads) in self.domain.surfaces.iter_mut().zip(of_walls) {
            surface.add_vertex_loads(loads.iter().map(|load| load.force));
        }
    }

    /// Whether vertices of some sheet touch walls.
    fn vertices_touch_walls(&self) -> bool {
        let mut surfaces = self.domain.surfaces.iter();
        surfaces.any(|surface| surface.plan().touches_walls)
    }

    /// The vertices of all sheets as spheres, sheet by sheet; nothing if none touches walls.
    #[must_use]
    pub fn all_vertex_spheres(&self) -> Vec<Vec<Particle>> {
        if !self.vertices_touch_walls() {
            return Vec::new();
        }
        let numbers = 0..self.domain.surfaces.len();
        numbers.map(|number| self.vertex_spheres(number)).collect()
    }

    /// The vertices of a sheet as spheres of half its thickness; none if they do not touch walls.
    fn vertex_spheres(&self, number: usize) -> Vec<Particle> {
        let surface = &self.domain.surfaces[number];
        let plan = surface.plan();
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

    /// Notes for each sheet how much farther than particles it may go before the list is built anew: the gap between the box around it and the
    /// particle that is nearest, less what counts as near. `extra_skin` (m; empty for none).
    pub(super) fn note_rooms(&mut self, extra_skin: &[f64], margin: &Margin) {
        let first = self.physics.walls.len();
        let cell = &self.domain.cell;
        let periods = (0..3).filter(|&axis| cell.is_periodic(axis));
        // The images by which a sheet is met are those around the place where it was.
        let most = periods.fold(cell.diagonal(), |most, axis| {
            most.min(LEAST_PART * cell.size()[axis])
        });
        for (number, surface) in self.domain.surfaces.iter_mut().enumerate() {
            let outer = self.domain.walls[first + number].outer_box();
            let mut room = most;
            // More vertices are near walls where they may go farther.
            if surface.plan().touches_walls {
                room = room.min(MOST_BESIDE_WALLS * margin.skin);
            }
            for (row, record) in self.particles.records.iter().enumerate() {
                let reach = record.radius + extra_skin.get(row).copied().unwrap_or_default();
                let gap = gap(record.position, outer, cell) - reach - margin.to_walls(record);
                room = room.min(gap);
                if room <= 0.0 {
                    break;
                }
            }
            surface.room = room.max(0.0);
        }
    }

    /// Finds which vertices may touch walls before the next list; they and the walls each move by `skin` (m) until then, and sheets by their
    /// room more.
    pub(super) fn list_vertices(&mut self, skin: f64) {
        if !self.vertices_touch_walls() {
            return;
        }
        let walls = &self.domain.walls[..self.physics.walls.len()];
        let range = self.constants.needs.range;
        let near: Vec<Vec<NearWall>> = (0..self.domain.surfaces.len())
            .map(|number| {
                let vertices = self.vertex_spheres(number);
                let margin =
                    Margin::of_skin(2.0 * skin + range + self.domain.surfaces[number].room);
                near_walls_of_vertices(&vertices, walls, &self.domain.cell, &margin)
            })
            .collect();
        self.contacts.adopt_vertices(&near);
    }

    /// The sheets as they are now, in the order of the plan.
    #[must_use]
    pub fn surfaces(&self) -> &[Surface] {
        &self.domain.surfaces
    }

    pub(super) fn saved_surfaces(&self) -> Vec<SavedSurface> {
        self.domain.surfaces.iter().map(Surface::save).collect()
    }

    pub(super) fn restore_surfaces(&mut self, saved: &[SavedSurface]) -> Result<(), String> {
        let first = self.physics.walls.len();
        if saved.len() != self.domain.surfaces.len() {
            return Err(format!(
                "it has {} membranes, the plan {}",
                saved.len(),
                self.domain.surfaces.len()
            ));
        }
        let surfaces = self
            .domain
            .surfaces
            .iter_mut()
            .zip(&mut self.domain.walls[first..]);
        for (saved, (surface, wall)) in saved.iter().zip(surfaces) {
            surface.restore(saved)?;
            let way = surface.way_since_listed();
            let followed = wall.follow_anew(&surface.corners(), way, &self.domain.cell);
            let name = &surface.plan().name;
            followed.map_err(|error| format!("membranes.{name}: {error}"))?;
        }
        Ok(())
    }
}
