//! The largest stable step.

use std::f64::consts::PI;

use glam::dvec3;

use super::{
    DENSITY, LENGTH, RADIUS, YOUNG, chain, close_to, elastic, glue, inputs, kinetic, mass, start,
};
use crate::bonds::{BondPlan, Gluing, SmallestGrain, StartOfBonds, look_ahead};
use crate::state::MaterialIndex;

/// The step that is named is stable, and twice that of a single pair is not.
#[test]
fn the_critical_step_is_that_of_the_stiffest_mode() {
    let materials = [crate::state::Material {
        name: "m".to_owned(),
        density: DENSITY,
    }];
    let critical = |count: usize, plan: BondPlan| {
        let inputs = inputs(1e-6, &chain(count), plan);
        let start = StartOfBonds {
            materials: &materials,
            dimensions: 3,
            particles: &inputs.particles,
            bodies: &[],
            clumps: &[],
            walls: &[],
            cell: &inputs.cell,
            seed: 0,
        };
        let grains = [SmallestGrain {
            material: MaterialIndex::new(0),
            radius: RADIUS,
            density: DENSITY,
        }];
        look_ahead(inputs.plans.all(), &start, &grains)
    };
    // A pair: tension has 2 k/m. Shear and bending of equal ends are not coupled: 12 k (1/(2 I) + 2/(m L^2)), and 2 E I_s/(L I).
    let pair = critical(2, glue());
    let (m, i) = (mass(), 0.4 * mass() * RADIUS * RADIUS);
    let k = YOUNG * PI * RADIUS.powi(4) / 4.0 / LENGTH / 3.125;
    let shear = 12.0 * k * (0.5 / i + 2.0 / (m * LENGTH * LENGTH));
    let fastest = f64::max(2.0 * 157_079.632_7 / m, shear);
    let least = pair.least.clone().unwrap();
    close_to(least.time, 2.0 / fastest.sqrt(), 1e-9);
    assert_eq!((pair.made[0], least.of.as_str()), (1, "bonds.glue"));
    // A chain: its ends share their mass among two bonds.
    let chained = critical(12, glue()).least.unwrap().time;
    close_to(chained, least.time / f64::sqrt(2.0), 0.2);
    let energy_after = |dt: f64, steps: u64| {
        let mut inputs = inputs(dt, &chain(12), glue());
        for (k, particle) in inputs.particles.iter_mut().enumerate() {
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            particle.velocity = dvec3(sign, 0.3 * sign, 0.0) * 1e-4;
        }
        let mut engine = start(inputs);
        engine.steps_at_once(steps, None).unwrap();
        kinetic(&engine) + elastic(&engine)
    };
    let calm = energy_after(0.1 * chained, 400);
    assert!(energy_after(0.95 * chained, 400) < 20.0 * calm);
    // Each step multiplies the fastest mode by some seven.
    assert!(energy_after(1.5 * chained, 10) > 1e6 * calm);
    // Glue at touches: with six bonds at each grain.
    let touching = BondPlan {
        when: Gluing::Contact {
            from: 0.0,
            until: 1.0,
        },
        ..glue()
    };
    let none = critical(2, touching);
    assert_eq!(none.made, [0]);
    close_to(none.critical[0], least.time / f64::sqrt(6.0), 1e-9);
}
