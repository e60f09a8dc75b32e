//! Helpers that several tests use: random packings and tables.

#![allow(dead_code)]

use glam::DVec3;
use mercury_cg::state::{Contacts, Particles, Partner, Space, State};
use mercury_common::random::Stream;

/// A random packing of spheres that overlap, in a box that is periodic in x and y, with a floor at z = 0; forces, couples and
/// velocities are random, since the identities hold for any values. Every tenth sphere is fixed; there are two materials.
pub(crate) fn packing(count: usize, seed: u64, equal: bool) -> State {
    let mut stream = Stream::new(seed, "packing", 0);
    let mut uniform = |low: f64, high: f64| stream.uniform_in(low, high);
    let space = Space {
        min: DVec3::ZERO,
        max: DVec3::ONE,
        periodic: [true, true, false],
        dimensions: 3,
    };
    let mut p = Particles::default();
    for k in 0..count {
        let mut vector = |low: f64, high: f64| {
            DVec3::new(uniform(low, high), uniform(low, high), uniform(low, high))
        };
        let (x, v, w) = (vector(0.0, 1.0), vector(-1.0, 1.0), vector(-5.0, 5.0));
        let r = if equal { 0.08 } else { uniform(0.05, 0.1) };
        let volume = 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
        let material = (k % 2) as u32;
        let mass = if equal {
            1000.0
        } else {
            1000.0 + 500.0 * f64::from(material)
        } * volume;
        p.id.push(k as u32);
        p.material.push(material);
        p.flowing.push(k % 10 != 3);
        p.position.push(x);
        p.velocity.push(v);
        p.mass.push(mass);
        p.volume.push(volume);
        p.radius.push(r);
        p.angular_velocity.push(w);
        p.spin.push(0.4 * mass * r * r * w);
    }
    let mut c = Contacts::default();
    let mut push =
        |i: usize, partner: Partner, normal: DVec3, overlap: f64, distance: f64, p: &Particles| {
            let mut vector =
                || DVec3::new(uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(-1.0, 1.0));
            let arm = (p.radius[i] - 0.5 * overlap) * normal;
            c.particle.push(i as u32);
            c.partner.push(partner);
            c.point.push(p.position[i] - arm);
            c.arm.push(arm);
            c.partner_arm.push(if distance > 0.0 {
                arm - distance * normal
            } else {
                DVec3::ZERO
            });
            c.normal.push(normal);
            c.force.push(10.0 * overlap * normal + 0.2 * vector());
            c.couple.push(0.01 * vector());
        };
    for i in 0..count {
        for j in i + 1..count {
            let between = space.nearest(p.position[i] - p.position[j]);
            let distance = between.length();
            let overlap = p.radius[i] + p.radius[j] - distance;
            if overlap > 0.0 && (p.flowing[i] || p.flowing[j]) {
                push(
                    i,
                    Partner::Particle(j as u32),
                    between / distance,
                    overlap,
                    distance,
                    &p,
                );
            }
        }
        let overlap = p.radius[i] - p.position[i].z;
        if overlap > 0.0 && p.flowing[i] {
            push(i, Partner::Wall(0), DVec3::Z, overlap, 0.0, &p);
        }
    }
    State {
        time: 0.5,
        space,
        particles: p,
        contacts: Some(c),
        displacement: None,
    }
}

/// The force of all contacts on each particle, and their torque about its centre.
pub(crate) fn loads(state: &State) -> Vec<(DVec3, DVec3)> {
    let mut loads = vec![(DVec3::ZERO, DVec3::ZERO); state.particles.len()];
    let c = state.contacts.as_ref().unwrap();
    for k in 0..c.len() {
        let load = &mut loads[c.particle[k] as usize];
        load.0 += c.force[k];
        load.1 += c.couple[k] - c.arm[k].cross(c.force[k]);
        if let Partner::Particle(j) = c.partner[k] {
            let load = &mut loads[j as usize];
            load.0 -= c.force[k];
            load.1 -= c.couple[k] - c.partner_arm[k].cross(c.force[k]);
        }
    }
    loads
}

/// The numbers of a table with `skip` lines of heading.
pub(crate) fn table(text: &str, skip: usize) -> Vec<Vec<f64>> {
    text.lines()
        .skip(skip)
        .map(|line| {
            line.split_ascii_whitespace()
                .map(|word| word.parse().unwrap())
                .collect()
        })
        .collect()
}
