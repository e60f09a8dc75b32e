//! A grain rolls off two beads, whatever they are made of, at the automatic step and at four times it.

use mercury_engine::contact::rolling::FrictionSpring;
use mercury_engine::contact::{AnyRolling, Luding, PairLaw, SlidingNormal, SpringRotation};
use mercury_tests::three_beads::{Beads, Groove, hertz_law, linear_law};

fn assert_falls(groove: Groove) {
    let time = groove.falls();
    assert!(time.is_some(), "{groove:?} hangs in the groove");
}

/// The automatic step is a 50th of the contact time.
const AUTOMATIC: f64 = 50.0;

/// The fault that the half-step rule mends, so that the tests below can fail: by the rule of the step the grain hangs.
#[test]
fn by_the_rule_of_the_step_the_grain_hangs() {
    let groove = Groove {
        rule: SlidingNormal::Step,
        ..Groove::new(Beads::Particles, 20.0, 0.5, AUTOMATIC / 4.0)
    };
    assert_eq!(groove.falls(), None);
    let walls = Groove {
        beads: Beads::Walls(0.0),
        ..groove
    };
    assert_eq!(walls.falls(), None);
}

#[test]
fn the_grain_falls_at_every_size_ratio() {
    for (ratio, friction) in [
        (4.0, 1.0),
        (8.0, 1.0),
        (20.0, 0.5),
        (50.0, 0.5),
        (100.0, 0.5),
    ] {
        for steps in [AUTOMATIC, AUTOMATIC / 4.0] {
            assert_falls(Groove::new(Beads::Particles, ratio, friction, steps));
        }
    }
    assert_falls(Groove::new(Beads::Particles, 20.0, 1.0, AUTOMATIC / 4.0));
    // The smaller the slope of the groove, the less friction holds a grain by the force with which its own weight pressed it in when it was put
    // there: at 300 and 0.5 it hangs, pressed in by the same 16 pm at a 13th and a 50th of the contact time.
    assert_falls(Groove::new(Beads::Particles, 300.0, 0.15, AUTOMATIC / 4.0));
    assert_falls(Groove::new(Beads::Walls(0.0), 300.0, 0.15, AUTOMATIC / 4.0));
}

#[test]
fn the_grain_falls_off_every_kind_of_beads() {
    for beads in [
        Beads::Walls(0.0),
        Beads::Walls(2.0),
        Beads::Meshes(0.0),
        Beads::Meshes(2.0),
        Beads::Pebbles(0.0),
        Beads::Pebbles(2.0),
    ] {
        // Over the edges of a tessellated bead a grain drops deeper into the groove, where friction of 1 holds it at a ratio of 8: at
        // every step, and by the same 18 nm at a 50th, a 200th and an 800th of the contact time.
        let coarse = if matches!(beads, Beads::Meshes(_)) {
            (8.0, 0.6)
        } else {
            (8.0, 1.0)
        };
        for (ratio, friction) in [coarse, (20.0, 0.5)] {
            assert_falls(Groove::new(beads, ratio, friction, AUTOMATIC / 4.0));
        }
        assert_falls(Groove::new(beads, 20.0, 0.5, AUTOMATIC));
    }
}

#[test]
fn the_grain_falls_with_every_law() {
    let groove = Groove::new(Beads::Particles, 20.0, 0.5, AUTOMATIC / 4.0);
    let incremental = linear_law(1e4, 0.5, SpringRotation::Incremental);
    assert_falls(Groove {
        law: incremental,
        ..groove
    });
    // Resistance to rolling and torsion that lets the grain go: 1 degree off the top the weight turns it by m g R sin(1 degree)
    // times the slope, 0.005 m g R; both contacts hold against it by 2 (mu_r + mu_o) R m g/(2 slope), 0.0012 m g R.
    let spring = FrictionSpring {
        stiffness: None,
        dissipation: 0.0,
        friction: 2e-4,
        static_friction: 2e-4,
    };
    for rotation in [SpringRotation::Project, SpringRotation::Incremental] {
        let rolling = AnyRolling::Luding(Luding {
            rolling: spring,
            torsion: spring,
            lever: 1.0,
            rotation,
        });
        assert_falls(Groove {
            law: PairLaw {
                rolling,
                ..linear_law(1e4, 0.5, rotation)
            },
            ..groove
        });
    }
    for rescaled in [false, true] {
        for beads in [Beads::Particles, Beads::Walls(0.0)] {
            // Four times the automatic step, which is 1e-7 s for the stiff one: 2.94 (m^2/(R E*^2 v))^(1/5)/50 at 1 m/s.
            for (modulus, step) in [(5e9, 4e-7), (5e8, 1e-6)] {
                assert_falls(Groove {
                    beads,
                    law: hertz_law(modulus, 0.5, rescaled),
                    step,
                    ..groove
                });
            }
        }
    }
}
