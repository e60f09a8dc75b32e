//! T20: oblique impacts of Chung & Ooi (2011), tests 4 to 8, where they slide all along, and beside measurements where they do not.

use glam::{DVec3, dvec3};
use mercury_solver::contact::normal::hertz_damping;
use mercury_solver::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Hertz, Mindlin, PairLaw,
};
use mercury_solver::plan::NewParticle;
use mercury_solver::state::{Particle, volume};

use super::Case;
use super::Tolerance::{Absolute, Relative};
use crate::closed_forms::{
    clamped_restitution, damping_ratio, effective_modulus, effective_shear_modulus,
    hertz_contact_time,
};
use crate::scenes::{advance, held, particle, plan, plane, sphere, start};

/// A body of the tests and its impact on a wall of its material.
#[derive(Clone, Copy)]
struct Impact {
    radius: f64,
    density: f64,
    /// Young's modulus, Pa, and Poisson's ratio.
    elasticity: (f64, f64),
    friction: f64,
    restitution: f64,
    /// Onto the wall, along it, m/s, and spin, rad/s.
    onto: f64,
    along: f64,
    spin: f64,
    /// On Mindlin's stiffness.
    factor: f64,
}

const STEPS: u64 = 2000;

impl Impact {
    fn law(&self) -> mercury_solver::contact::registry::AnyPairLaw {
        let damping = hertz_damping(self.restitution);
        let material = self.elasticity;
        let beta = (2.0f64 / 3.0).sqrt() * damping;
        PairLaw {
            normal: AnyNormal::Hertz(Hertz::new(effective_modulus(material, material), damping)),
            tangential: AnyTangential::Mindlin(Mindlin::new(
                effective_shear_modulus(material, material),
                self.factor,
                beta,
                self.friction,
                self.friction,
            )),
            rolling: AnyRolling::None,
            adhesion: AnyAdhesion::None,
        }
    }

    fn time_step(&self) -> f64 {
        let modulus = effective_modulus(self.elasticity, self.elasticity);
        let mass = self.density * volume(self.radius, 3);
        hertz_contact_time(modulus, mass, self.radius, self.onto) / STEPS as f64
    }

    /// The sphere after the impact on the plane y = 0.
    fn on_wall(&self) -> Particle {
        let mut plan = plan(self.time_step(), self.density, self.law());
        plan.walls.push(plane(DVec3::ZERO, DVec3::Y));
        self.after(plan.with_particles(vec![self.sphere()]))
    }

    /// The same on a sphere of five times the radius that does not move.
    fn on_sphere(&self) -> Particle {
        let plan = plan(self.time_step(), self.density, self.law());
        let radius = 5.0 * self.radius;
        let anvil = held(sphere(-radius * DVec3::Y, radius, DVec3::ZERO, DVec3::ZERO));
        self.after(plan.with_particles(vec![self.sphere(), anvil]))
    }

    fn sphere(&self) -> NewParticle {
        sphere(
            self.radius * DVec3::Y,
            self.radius,
            dvec3(self.along, -self.onto, 0.0),
            self.spin * DVec3::Z,
        )
    }

    fn after(&self, plan: mercury_solver::plan::Draft) -> Particle {
        let mut engine = start(plan);
        advance(&mut engine, 3 * STEPS);
        particle(&engine, 0)
    }

    /// What friction takes from the velocity in full sliding, m/s: mu times what presses, which ends when the sphere leaves with the
    /// speed of a contact without tension.
    fn taken(&self) -> f64 {
        let clamped = clamped_restitution(damping_ratio(self.restitution));
        self.friction * (1.0 + clamped) * self.onto
    }
}

/// Test 4: an alumina sphere at 3.9 m/s at an angle from the normal.
fn test_4(degrees: f64, factor: f64) -> Impact {
    let angle = degrees.to_radians();
    Impact {
        radius: 0.0025,
        density: 4000.0,
        elasticity: (3.8e11, 0.23),
        friction: 0.092,
        restitution: 0.98,
        onto: 3.9 * angle.cos(),
        along: 3.9 * angle.sin(),
        spin: 0.0,
        factor,
    }
}

/// Test 5: steel at 5 m/s onto the wall, psi mu times that along it.
fn test_5(psi: f64, factor: f64) -> Impact {
    Impact {
        radius: 1e-5,
        density: 7850.0,
        elasticity: (2.08e11, 0.3),
        friction: 0.3,
        restitution: 1.0,
        onto: 5.0,
        along: psi * 0.3 * 5.0,
        spin: 0.0,
        factor,
    }
}

/// Test 6: an aluminium sphere that spins; tan(alpha) = R spin / speed.
fn test_6(tangent: f64) -> Impact {
    Impact {
        radius: 0.1,
        density: 2700.0,
        elasticity: (7e10, 0.33),
        friction: 0.4,
        restitution: 0.5,
        onto: 0.2,
        along: 0.0,
        spin: tangent * 0.2 / 0.1,
        factor: 2.0 / 3.0,
    }
}

/// Rows of T20.
pub(super) fn cases() -> Vec<Case> {
    const SLIDING: &str = "rigid sphere that slides all along, by what presses (Walton 1993; Schwager & Poeschel 2007)";
    // The lever R - overlap/2, at most 0.4 % shorter (test 5), and the first steps, in which the spring loads.
    const NEAR: f64 = 5e-3;
    let mut cases = Vec::new();
    for (name, factor) in [("factor 2/3", 2.0 / 3.0), ("factor 1", 1.0)] {
        for degrees in [40.0f64, 50.0, 60.0, 75.0] {
            let impact = test_4(degrees, factor);
            cases.push(Case::new(
                format!("T20 engine: test 4, {degrees} degrees, {name}: v_t after over before"),
                1.0 - impact.taken() / impact.along,
                Relative(NEAR),
                SLIDING,
                move || impact.on_wall().velocity.x / impact.along,
            ));
            cases.push(Case::new(
                format!("T20 engine: test 4, {degrees} degrees, {name}: spin after (rad/s)"),
                -2.5 * impact.taken() / impact.radius,
                Relative(NEAR),
                SLIDING,
                move || impact.on_wall().angular_velocity.z,
            ));
        }
        for (degrees, measured) in [(9.6304, 0.6728), (20.0845, 0.5964), (49.5459, 0.8469)] {
            let impact = test_4(degrees, factor);
            cases.push(Case::new(
                format!("T20 engine: test 4, {degrees} degrees, {name}: v_t after over before, beside the measurement"),
                measured,
                // The measurements scatter by some hundredths; where it sticks the law is an approximation.
                Absolute(0.1),
                "measured by Kharaz, Gorham & Salman (2001), as printed in MFiX's DEM05",
                move || impact.on_wall().velocity.x / impact.along,
            ));
        }
        for psi in [8.0, 10.0, 13.0] {
            let impact = test_5(psi, factor);
            let scale = impact.friction * impact.onto;
            cases.push(Case::new(
                format!("T20 engine: test 5, psi = {psi}, {name}: slip after over mu v_n"),
                psi - 7.0,
                Absolute(NEAR * 7.0),
                SLIDING,
                move || {
                    let after = impact.on_wall();
                    (after.velocity.x + after.angular_velocity.z * impact.radius) / scale
                },
            ));
            cases.push(Case::new(
                format!("T20 engine: test 5, psi = {psi}, {name}: R spin after over mu v_n"),
                -5.0,
                Relative(NEAR),
                SLIDING,
                move || impact.on_wall().angular_velocity.z * impact.radius / scale,
            ));
        }
    }
    // The contact point moves by +spin R along x.
    for tangent in [3.0, 4.5, 8.0] {
        let impact = test_6(tangent);
        for (name, run) in [
            ("test 6, wall", Impact::on_wall as fn(&Impact) -> Particle),
            ("test 8, large heavy sphere", Impact::on_sphere),
        ] {
            cases.push(Case::new(
                format!("T20 engine: {name}, tan = {tangent}: v_t after (m/s)"),
                -impact.taken(),
                Relative(NEAR),
                SLIDING,
                move || run(&impact).velocity.x,
            ));
            cases.push(Case::new(
                format!("T20 engine: {name}, tan = {tangent}: R spin taken (m/s)"),
                2.5 * impact.taken(),
                Relative(NEAR),
                SLIDING,
                move || impact.radius * (impact.spin - run(&impact).angular_velocity.z),
            ));
        }
    }
    cases.extend(test_7());
    cases
}

/// Two equal spheres with equal and opposite spins: their contact points move alike, and nothing happens to either.
fn test_7() -> Vec<Case> {
    let impact = test_6(2.0);
    let run = move || {
        let plan = plan(impact.time_step(), impact.density, impact.law());
        let ball = |side: f64| {
            sphere(
                side * impact.radius * DVec3::X,
                impact.radius,
                -side * 0.2 * DVec3::X,
                -side * impact.spin * DVec3::Z,
            )
        };
        impact.after(plan.with_particles(vec![ball(-1.0), ball(1.0)]))
    };
    vec![
        Case::new(
            "T20 engine: test 7: tangential velocity after (m/s)",
            0.0,
            Absolute(1e-15),
            "no relative motion of the contact points",
            move || run().velocity.y,
        ),
        Case::new(
            "T20 engine: test 7: spin after over before",
            1.0,
            Relative(1e-13),
            "no relative motion of the contact points",
            move || run().angular_velocity.z / impact.spin,
        ),
    ]
}
