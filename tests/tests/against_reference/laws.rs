//! Every combination of the parts of a contact law.

use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::rolling::FrictionSpring;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, LinearFriction, Luding,
    Mindlin, MindlinRescaled, PairLaw, PlannedNormal as _, Scale, SpringRotation,
};

/// For spheres of some 3 cm and 0.2 kg.
fn normals() -> Vec<AnyNormal> {
    AnyNormal::examples(&Scale {
        stiffness: 1e5,
        radius: 0.03,
        mass: 0.1,
    })
}

fn tangentials() -> Vec<AnyTangential> {
    let linear = LinearFriction {
        stiffness: 3e4,
        dissipation: 2.0,
        friction: 0.4,
        static_friction: 0.5,
        rotation: SpringRotation::Project,
        limits: CoulombLimits::Bounded,
    };
    let mindlin = Mindlin::new(6e5, 2.0 / 3.0, 0.1, 0.4, 0.4);
    let total = Mindlin::new(6e5, 1.0, 0.1, 0.3, 0.4).with_limits(CoulombLimits::Total);
    vec![
        AnyTangential::None,
        AnyTangential::Linear(linear),
        AnyTangential::Linear(LinearFriction {
            rotation: SpringRotation::Incremental,
            ..linear
        }),
        AnyTangential::Linear(LinearFriction {
            stiffness: 0.0,
            dissipation: 20.0,
            ..linear
        }),
        AnyTangential::Mindlin(mindlin),
        AnyTangential::Mindlin(total),
        AnyTangential::MindlinRescaled(MindlinRescaled { plain: mindlin }),
        AnyTangential::MindlinRescaled(MindlinRescaled { plain: total }),
    ]
}

/// With Coulomb's limit as other codes have it.
fn tangentials_of_other_codes() -> Vec<AnyTangential> {
    let elastic = Mindlin::new(6e5, 2.0 / 3.0, 0.1, 0.4, 0.4).with_limits(CoulombLimits::Elastic);
    vec![
        AnyTangential::Linear(LinearFriction {
            stiffness: 3e4,
            dissipation: 2.0,
            friction: 0.4,
            static_friction: 0.5,
            rotation: SpringRotation::Project,
            limits: CoulombLimits::Total,
        }),
        AnyTangential::Mindlin(elastic),
        AnyTangential::MindlinRescaled(MindlinRescaled { plain: elastic }),
    ]
}

fn rollings(rotation: SpringRotation) -> Vec<AnyRolling> {
    let spring = |stiffness, friction| FrictionSpring {
        stiffness,
        dissipation: 0.5,
        friction,
        static_friction: 1.2 * friction,
    };
    let luding = |stiffness, lever| {
        AnyRolling::Luding(Luding {
            rolling: spring(stiffness, 0.1),
            torsion: spring(stiffness, 0.05),
            lever,
            rotation,
        })
    };
    vec![AnyRolling::None, luding(Some(2e4), 1.0), luding(None, 2.0)]
}

/// Every combination of the three parts.
pub(crate) fn laws() -> Vec<AnyPairLaw> {
    let mut laws = combinations(tangentials());
    laws.extend(combinations(tangentials_of_other_codes()));
    laws
}

fn combinations(tangentials: Vec<AnyTangential>) -> Vec<AnyPairLaw> {
    let mut laws = Vec::new();
    for normal in normals() {
        for &tangential in &tangentials {
            // The rolling spring follows the contact as the sliding one does.
            let rotation = match tangential {
                AnyTangential::Linear(law) => law.rotation,
                _ => SpringRotation::Project,
            };
            for rolling in rollings(rotation) {
                laws.push(PairLaw {
                    normal,
                    tangential,
                    rolling,
                    adhesion: AnyAdhesion::None,
                });
            }
        }
    }
    laws
}
