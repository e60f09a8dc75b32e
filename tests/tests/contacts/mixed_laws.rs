//! Contacts of several laws in one scene: the loop sorts those of a chunk by their laws, so that lanes hold one law each, and must bring every force
//! back to its own two particles.

use glam::{DVec3, dvec3};
use mercury_common::random::Stream;
use mercury_engine::contact::adhesion::liquid::Tables;
use mercury_engine::contact::registry::LawTable;
use mercury_engine::contact::{AnyNormal, Linear};
use mercury_engine::state::MaterialIndex;
use mercury_solver::plan::{Draft, NewParticle};
use mercury_tests::scenes::{add_material, frictionless, start};

const RADIUS: f64 = 0.01;
/// Of the springs between materials 0 and 0, 0 and 1, 1 and 1, N/m.
const STIFFNESS: [f64; 3] = [100.0, 250.0, 700.0];

/// A bar in which the first half of all contacts are of three laws and the others, further on, of one. Every particle feels the sum of k (2R - d) over
/// those that it overlaps. Two sums of six such numbers in other orders differ by a few of their last digits.
#[test]
fn contacts_of_one_law_after_those_of_several_act_on_their_own_particles() {
    let long = 60u32;
    let law = |stiffness| frictionless(AnyNormal::Linear(Linear::new(stiffness, 0.0)));
    let size = dvec3(0.02 * f64::from(long), 0.1, 0.1);
    // So short a step that nothing moves by a part in 1e-12 of an overlap.
    let mut scene = Draft::new(1e-12, (-size, size), 1000.0, law(STIFFNESS[0]));
    add_material(&mut scene, 1000.0);
    scene.laws = LawTable {
        materials: 2,
        laws: [0, 1, 1, 2]
            .map(|which| Some(law(STIFFNESS[which])))
            .to_vec(),
        tables: Tables::default(),
    };
    let mut random = Stream::new(3, "mixed bar", 0);
    let particles: Vec<NewParticle> = (0..16 * long)
        .map(|k| {
            let [i, j, layer] = [k % 4, k / 4 % 4, k / 16];
            let mut off = || random.uniform_in(-0.02, 0.02);
            let site = dvec3(f64::from(layer), f64::from(i), f64::from(j)) * 1.9;
            let place = (site + dvec3(off(), off(), off())) * RADIUS;
            let is_second = layer < long / 2 && random.uniform() < 0.5;
            NewParticle::at(place, RADIUS, MaterialIndex::new(u32::from(is_second)))
        })
        .collect();
    let mut engine = start(scene.with_particles(particles));
    engine.step(None).unwrap();
    let records = &engine.particles.records;
    for (row, one) in records.iter().enumerate() {
        let mut expected = DVec3::ZERO;
        for other in records {
            let apart = one.position - other.position;
            let overlap = 2.0 * RADIUS - apart.length();
            if apart != DVec3::ZERO && overlap > 0.0 {
                let which = one.material.index() + other.material.index();
                expected += STIFFNESS[which] * overlap * apart.normalize();
            }
        }
        let found = engine.particles.loads[row].force;
        assert!(
            (found - expected).length() < 1e-9,
            "at {}: {found} N, {expected} N",
            one.position
        );
    }
}
