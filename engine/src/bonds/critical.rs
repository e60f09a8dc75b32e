//! The largest stable step of bonds.
//!
//! The largest angular frequency w of a structure is at most that of its elements alone, if each end has its mass and inertia shared among its bonds
//! (Irons & Treharne 1971); a step of 2/w is the largest that velocity Verlet bears. The modes of an element are tension, twist, and bending and
//! shear, which are coupled where the ends differ. Damping by velocities that are half a step old takes a part of it: sqrt(1 + z^2) - z for the
//! fraction z of critical.

use std::collections::HashMap;

use super::bond::Surroundings;
use super::element::{Element, LawOfBonds, Mobility, Modes, Section};
use super::{BondPlan, Gluing, StartOfBonds};
use crate::state::{MaterialIndex, inverse_inertia_factor, volume};

/// Bonds that a grain which is glued at touches is assumed to have: as many as touches in a packing that is just rigid.
const BONDS_OF_GRAIN: f64 = 6.0;

/// The smallest free grain of a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmallestGrain {
    /// Material.
    pub material: MaterialIndex,
    /// m
    pub radius: f64,
    /// kg/m^3
    pub density: f64,
}

/// Findings about bonds before a run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BondedStart {
    /// Bonds of the start, by entry.
    pub made: Vec<u64>,
    /// Those of them that lead to walls.
    pub to_walls: Vec<u64>,
    /// The critical step of each entry, s; infinite where it glues nothing.
    pub critical: Vec<f64>,
    /// The least of them.
    pub least: Option<LeastStep>,
}

/// The least critical step of the entries.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastStep {
    /// s
    pub time: f64,
    /// Key and name of the entry.
    pub of: String,
    /// How a user makes it longer.
    pub way_out: &'static str,
}

/// Finds the bonds of the start, and the largest stable step.
#[must_use]
pub fn look_ahead(
    plans: &[BondPlan],
    start: &StartOfBonds<'_>,
    grains: &[SmallestGrain],
) -> BondedStart {
    let (bonds, particles, walls) = start.bonds(plans);
    let around = Surroundings {
        particles: &particles,
        walls: &walls,
        cell: start.cell,
        inverse_inertia: inverse_inertia_factor(start.dimensions),
    };
    let mut count: HashMap<u32, f64> = HashMap::new();
    let ends = |rows: [u32; 2], is_wall: bool| match is_wall {
        true => vec![rows[0]],
        false => rows.to_vec(),
    };
    for bond in &bonds {
        for row in ends(bond.rows, bond.is_wall) {
            *count.entry(row).or_default() += 1.0;
        }
    }
    let (mut made, mut to_walls) = (vec![0; plans.len()], vec![0; plans.len()]);
    let mut critical = vec![f64::INFINITY; plans.len()];
    for bond in &bonds {
        let plan = bond.plan as usize;
        made[plan] += 1;
        to_walls[plan] += u64::from(bond.is_wall);
        let shared = |row: &u32| around.mobility(*row as usize).times(count[row]);
        let ends: Vec<Mobility> = ends(bond.rows, bond.is_wall).iter().map(shared).collect();
        let ends = [ends[0], ends.get(1).copied().unwrap_or_default()];
        let step = bond.element.critical_step(ends, plans[plan].damping);
        critical[plan] = critical[plan].min(step);
    }
    for (plan, critical) in plans.iter().zip(&mut critical) {
        if matches!(plan.when, Gluing::Contact { .. }) {
            *critical = plan.critical_at_touches(grains, start.dimensions);
        }
    }
    let slowest = critical.iter().zip(plans).min_by(|a, b| a.0.total_cmp(b.0));
    let least = slowest.filter(|(time, _)| time.is_finite());
    BondedStart {
        least: least.map(|(&time, plan)| LeastStep {
            time,
            of: format!("bonds.{}", plan.name),
            way_out: plan.way_out(),
        }),
        made,
        to_walls,
        critical,
    }
}

impl BondPlan {
    fn way_out(&self) -> &'static str {
        match self.law {
            LawOfBonds::Beam { .. } => {
                "or take a lower youngs_modulus, a smaller radius_ratio or less damping of the bonds"
            }
            LawOfBonds::Parallel { .. } => {
                "or take lower stiffnesses, a smaller radius_ratio or less damping of the bonds"
            }
        }
    }

    /// The critical step (s) of bonds between the smallest grains, and of those with walls.
    fn critical_at_touches(&self, grains: &[SmallestGrain], dimensions: u8) -> f64 {
        let fits = |grain: &&SmallestGrain| self.glues_to_walls(grain.material);
        let steps = grains.iter().filter(fits).flat_map(|grain| {
            let SmallestGrain {
                radius, density, ..
            } = *grain;
            let inverse_mass = 1.0 / (density * volume(radius, dimensions));
            let end = Mobility {
                inverse_mass,
                inverse_inertia: inverse_inertia_factor(dimensions) * inverse_mass
                    / (radius * radius),
            };
            let end = end.times(BONDS_OF_GRAIN);
            let section = Section {
                radius: self.radius_ratio * radius,
            };
            let step = move |length: f64, ends: [Mobility; 2]| {
                let element = Element::new(self.law, length, section, 0.0, ends);
                element.critical_step(ends, self.damping)
            };
            let pair = step(2.0 * radius, [end, end]);
            let at_wall =
                (!self.walls.is_empty()).then(|| step(radius, [end, Mobility::default()]));
            [Some(pair), at_wall]
        });
        steps.flatten().fold(f64::INFINITY, f64::min)
    }
}

impl Mobility {
    /// That of a part of the end: one of so many bonds has it for its own.
    fn times(self, bonds: f64) -> Self {
        Self {
            inverse_mass: bonds * self.inverse_mass,
            inverse_inertia: bonds * self.inverse_inertia,
        }
    }
}

impl Element {
    /// The critical step (s) of an element between ends of these mobilities; `damping`: fraction of critical.
    #[must_use]
    pub fn critical_step(&self, [a, b]: [Mobility; 2], damping: f64) -> f64 {
        let Modes {
            normal,
            shear,
            twist,
            bending,
        } = self.stiffness;
        let squared = self.length * self.length;
        let inverse_mass = a.inverse_mass + b.inverse_mass;
        let inverse_inertia = a.inverse_inertia + b.inverse_inertia;
        // Bending by the difference of the rotations, shear by their mean against the line of centres: coupled where the inertias differ.
        let shear = shear * squared;
        let of_shear = shear * (0.25 * inverse_inertia + inverse_mass / squared);
        let of_bending = bending * inverse_inertia;
        let coupling = 0.5 * (b.inverse_inertia - a.inverse_inertia) * (shear * bending).sqrt();
        let half = 0.5 * (of_shear - of_bending);
        let coupled = 0.5 * (of_shear + of_bending) + (half * half + coupling * coupling).sqrt();
        let fastest = (normal * inverse_mass)
            .max(twist * inverse_inertia)
            .max(coupled);
        2.0 / fastest.sqrt() * ((1.0 + damping * damping).sqrt() - damping)
    }
}
