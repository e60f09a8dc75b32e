//! Stiffness and damping of a sheet against the motion of a wall that holds vertices of it: for the servo of that wall.
//!
//! The held vertices move as one, along the axis of the servo. So only what joins a held vertex to another one answers: triangles, edges and hinges on
//! the border of the held part. Their stiffness is the second derivative of their energy along the axis, at the present shape.

use glam::DVec3;

use super::elements::Fold;
use super::pressure::Load;
use super::sheet::{Elasticity, Sheet};
use crate::walls::WallStiffness;

/// Border of some vertices of a sheet: all that joins them to the others.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Border {
    /// Whether each vertex is one of them.
    pub is_held: Vec<bool>,
    /// Sum of their masses, kg.
    mass: f64,
    triangles: Vec<u32>,
    edges: Vec<u32>,
    hinges: Vec<u32>,
}

impl Border {
    /// Border of these vertices.
    pub(super) fn new(sheet: &Sheet, is_held: Vec<bool>) -> Self {
        let joins = |corners: &[u32]| {
            let mut held = corners.iter().map(|&k| is_held[k as usize]);
            let first = held.next();
            held.any(|other| Some(other) != first)
        };
        let topology = &sheet.topology;
        let numbered = |all: &mut dyn Iterator<Item = bool>| -> Vec<u32> {
            let all = (0u32..).zip(all);
            all.filter_map(|(k, is_in)| is_in.then_some(k)).collect()
        };
        let has_hinges = sheet.law.bending.is_some();
        let masses = sheet.masses().iter().zip(&is_held);
        Self {
            triangles: numbered(&mut topology.triangles().iter().map(|corners| joins(corners))),
            edges: numbered(&mut topology.edges().iter().map(|edge| joins(&edge.ends))),
            hinges: numbered(
                &mut (topology.hinges().iter())
                    .map(|hinge| has_hinges && joins(&corners_of(hinge))),
            ),
            mass: masses
                .filter(|(_, held)| **held)
                .map(|(mass, _)| mass)
                .sum(),
            is_held,
        }
    }
}

/// The corners beside a hinge, then its ends, as [`Fold::new`] takes them.
fn corners_of(hinge: &super::Edge) -> [u32; 4] {
    let ([one, other], [from, to]) = (hinge.opposite, hinge.ends);
    [one, other, from, to]
}

/// A sheet as it is now.
#[derive(Debug, Clone, Copy)]
pub(super) struct SheetShape<'a> {
    /// m
    pub positions: &'a [DVec3],
    /// 1/kg; 0 of those that are held.
    pub inverse_masses: &'a [f64],
    /// Coefficients of [`Sheet::dashpots`], N s/m.
    pub dashpots: &'a [f64],
}

impl Sheet {
    /// Adds what the sheet answers to a motion of the vertices within a border along the unit vector `axis`. `first`: the enclosed volume at the
    /// start, m^3.
    ///
    /// Each part counts like a contact with the free vertices that it moves: with the sum of their masses.
    pub(super) fn add_answer(
        &self,
        border: &Border,
        at: &SheetShape<'_>,
        axis: DVec3,
        (load, first): (&Load, f64),
        sum: &mut WallStiffness,
    ) {
        let mass_of = |corners: &[u32]| {
            let free = corners.iter().map(|&k| k as usize).filter(|&k| {
                let is_free = at.inverse_masses[k] > 0.0;
                is_free && !border.is_held[k]
            });
            // Vertices that are held elsewhere do not move at all.
            let mass: f64 = free.map(|k| self.masses()[k]).sum();
            if mass > 0.0 { mass } else { f64::INFINITY }
        };
        let place = |k: u32| at.positions[k as usize];
        let share = |k: u32| f64::from(u8::from(border.is_held[k as usize]));
        if let Elasticity::Continuum { poisson_ratio } = self.law.elasticity {
            for &triangle in &border.triangles {
                let corners = self.topology.triangles()[triangle as usize];
                let [a, b, c] = corners;
                let sides = [place(b) - place(a), place(c) - place(a)];
                let rates = [share(b) - share(a), share(c) - share(a)];
                let strained = &self.triangles[triangle as usize].strained;
                let stiffness = strained.stiffness_along(
                    sides,
                    rates,
                    axis,
                    self.law.stiffness(),
                    poisson_ratio,
                );
                sum.add_spring(mass_of(&corners), stiffness.max(0.0), 0.0);
            }
        }
        for &edge in &border.edges {
            let ends = self.topology.edges()[edge as usize].ends;
            let branch = place(ends[1]) - place(ends[0]);
            let (length, along) = (branch.length(), branch.dot(axis));
            let square = along * along / (length * length);
            let rest = &self.edges[edge as usize];
            let stiffness = match self.law.elasticity {
                Elasticity::Continuum { .. } => 0.0,
                // Across it the tension over the length, where it pulls.
                Elasticity::Springs => {
                    let across = (1.0 - rest.length / length).max(0.0);
                    rest.stiffness * (square + across * (1.0 - square))
                }
            };
            let dashpot = at.dashpots[edge as usize] * square;
            sum.add_spring(mass_of(&ends), stiffness, dashpot);
        }
        self.add_hinges(border, at, axis, mass_of, sum);
        sum.add_spring(f64::INFINITY, 0.0, self.law.drag * border.mass);
        if load.needs_volume() {
            let free = (0..self.masses().len()).filter(|&k| at.inverse_masses[k] > 0.0);
            let mass: f64 = free.map(|k| self.masses()[k]).sum();
            let stiffness = self.fluid_along(border, at.positions, axis, (load, first));
            sum.add_spring(mass, stiffness, 0.0);
        }
    }

    /// The hinges of a border: factor (d angle)^2, as in the critical step.
    fn add_hinges(
        &self,
        border: &Border,
        at: &SheetShape<'_>,
        axis: DVec3,
        mass_of: impl Fn(&[u32]) -> f64,
        sum: &mut WallStiffness,
    ) {
        let Some(bending) = self.law.bending else {
            return;
        };
        let area = |triangle: u32| {
            let corners = self.topology.triangles()[triangle as usize];
            let [a, b, c] = corners.map(|k| at.positions[k as usize]);
            0.5 * (b - a).cross(c - a)
        };
        for &hinge in &border.hinges {
            let edge = &self.topology.hinges()[hinge as usize];
            let corners = corners_of(edge);
            let [one, other] = edge.triangles.map(area);
            let fold = Fold::new(corners.map(|k| at.positions[k as usize]), one, other);
            // u is minus twice the gradient of the angle.
            let slopes = corners.iter().zip(fold.u);
            let held = slopes.filter(|(corner, _)| border.is_held[**corner as usize]);
            let rate: f64 = held.map(|(_, slope)| slope.dot(axis)).sum();
            let square = rate * rate;
            let stiffness = 0.25 * self.hinges[hinge as usize].factor * square;
            let dashpot = bending.damping * fold.length * square;
            sum.add_spring(mass_of(&corners), stiffness, dashpot);
        }
    }

    /// Stiffness of the enclosed fluid: -dp/dV times the volume that the held vertices sweep, times the area that it presses on at them.
    fn fluid_along(
        &self,
        border: &Border,
        positions: &[DVec3],
        axis: DVec3,
        (load, first): (&Load, f64),
    ) -> f64 {
        let mut pressed = 0.0;
        for corners in self.topology.triangles() {
            let [a, b, c] = corners.map(|k| positions[k as usize]);
            let along = 0.5 * (b - a).cross(c - a).dot(axis);
            let held = corners.iter().filter(|k| border.is_held[**k as usize]);
            pressed += along * held.count() as f64 / 3.0;
        }
        let gradient = self.volume_gradient(positions);
        let held = gradient
            .iter()
            .zip(&border.is_held)
            .filter(|(_, held)| **held);
        let swept: f64 = held.map(|(slope, _)| slope.dot(axis)).sum();
        let volume = self.enclosed(positions).volume;
        load.stiffness_at(volume, first) * (swept * pressed).abs()
    }
}
