//! Largest part of a scene, by number of spheres: advice for a run that needs more memory than there is.

use mercury_common::scene::{ClumpPlace, Lattice, ParticleSource, Scene, SourceSpan};

use super::Plan;
use super::expected::at_start;
use crate::boundaries::plan::insertions::expected_inserted;

/// Largest part of a scene, by number of spheres.
#[derive(Debug, Clone)]
pub struct Largest<'a> {
    /// Where it stands.
    pub place: &'a SourceSpan,
    /// Name of the part: `this lattice`.
    pub what: &'static str,
    /// Number of spheres that it brings, at most.
    pub spheres: f64,
    /// Whether they come in any case, and not only if there are space and time for them.
    pub is_certain: bool,
}

/// The entry of a scene that brings the most spheres, bodies counted by their pebbles; none in a scene without particles. `plan`: of this
/// scene, or its sketch.
#[must_use]
pub fn largest<'a>(scene: &'a Scene, plan: &Plan) -> Option<Largest<'a>> {
    let physics = plan.physics();
    let pebbles = |clump: usize| {
        let clump = physics.clumps.get(clump);
        clump.map_or(1.0, |clump| clump.pebbles.len() as f64)
    };
    let mut all = Vec::new();
    let start = at_start(plan);
    let mut others = start.particles + start.pebbles;
    for (place, sites, clump) in lattices(scene) {
        let spheres = sites * clump.map_or(1.0, pebbles);
        others -= spheres;
        all.push(Largest {
            place,
            what: "this lattice",
            spheres,
            is_certain: true,
        });
    }
    // Tables and runs are not counted one by one.
    let other = scene.particles.iter().find(|entry| {
        let source = &entry.source;
        matches!(
            source,
            ParticleSource::Table { .. } | ParticleSource::Run { .. }
        )
    });
    all.extend(other.map(|entry| Largest {
        place: &entry.place,
        what: "tables and runs",
        spheres: others,
        is_certain: true,
    }));
    for insertion in &physics.insertions {
        let mut typed = scene.insertions.iter();
        let Some(typed) = typed.find(|typed| typed.name.value == insertion.name) else {
            continue;
        };
        let each = insertion.mixture.iter().map(|part| {
            let clump = part.clump.map(|clump| clump as usize);
            part.share * clump.map_or(1.0, pebbles)
        });
        all.push(Largest {
            place: &typed.place,
            what: "this insertion",
            spheres: expected_inserted(insertion, plan) * each.sum::<f64>(),
            is_certain: false,
        });
    }
    all.into_iter()
        .max_by(|one, other| one.spheres.total_cmp(&other.spheres))
}

/// Spheres and bodies on lattices, as many as there are sites, before any is made.
#[must_use]
pub fn lattice_grains(scene: &Scene) -> f64 {
    lattices(scene).map(|(_, sites, _)| sites).sum()
}

/// Each lattice: where it stands, how many sites it has, the clump on them.
fn lattices(scene: &Scene) -> impl Iterator<Item = (&SourceSpan, f64, Option<usize>)> {
    let sites = |lattice: &Lattice| lattice.sites().iter().product();
    scene
        .particles
        .iter()
        .filter_map(move |entry| match &entry.source {
            ParticleSource::Lattice { lattice, .. } => Some((&entry.place, sites(lattice), None)),
            ParticleSource::Clump {
                clump,
                at: ClumpPlace::Lattice(lattice),
                ..
            } => Some((&entry.place, sites(lattice), Some(clump.value.0))),
            _ => None,
        })
}
