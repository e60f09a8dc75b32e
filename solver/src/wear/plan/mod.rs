//! How walls wear.

pub(crate) mod doubts;

use std::fmt::Write;

use mercury_common::scene::{Scene, Wear as SceneWear, WearLaw as SceneLaw};

use mercury_engine::contact::parameter::short;
use mercury_engine::walls::Wall;
use mercury_engine::wear::{WearBasis, WearLaw, WearPlan};

/// The walls of the plan that wear.
pub(crate) fn wear(scene: &Scene, walls: &[Wall]) -> Vec<WearPlan> {
    let plan = |(index, wall): (usize, &Wall)| {
        let mut of_scene = scene.walls.iter();
        let found = of_scene.find(|other| other.name.value == wall.name)?;
        Some(of_wall(index, found.wear.as_ref()?))
    };
    walls.iter().enumerate().filter_map(plan).collect()
}

fn of_wall(wall: usize, wear: &SceneWear) -> WearPlan {
    WearPlan {
        wall,
        law: law(&wear.law),
        acceleration: *wear.acceleration,
        moves: wear.moves,
        step: *wear.step,
        smoothing: *wear.smoothing,
        until_depth: wear
            .until_depth
            .as_deref()
            .copied()
            .unwrap_or(f64::INFINITY),
    }
}

fn law(law: &SceneLaw) -> WearLaw {
    match law {
        SceneLaw::Archard {
            coefficient,
            hardness,
            basis,
        } => WearLaw::Archard {
            rate: **coefficient / **hardness,
            basis: *basis,
        },
        SceneLaw::Finnie { constant } => WearLaw::Finnie {
            constant: **constant,
        },
        SceneLaw::Oka(oka) => WearLaw::Oka {
            // GPa, as the law is written.
            hardness: *oka.hardness / 1e9,
            // Given in mm^3/kg.
            erosion: *oka.reference_erosion * 1e-9,
            speed: *oka.reference_speed,
            diameter: *oka.reference_diameter,
            speed_exponent: *oka.speed_exponent,
            diameter_exponent: *oka.diameter_exponent,
            n1: *oka.n1,
            n2: *oka.n2,
        },
    }
}

/// How a wall wears, for the report.
pub(crate) fn describe(wear: &WearPlan) -> String {
    let mut words = match wear.law {
        WearLaw::Archard { rate, basis } => {
            let of = match basis {
                WearBasis::NormalLoad => "load times way",
                WearBasis::Sliding => "load times slip",
                WearBasis::FrictionWork => "work of friction",
            };
            format!("wears by archard: K/H = {} 1/Pa times {of}", short(rate))
        }
        WearLaw::Finnie { constant } => {
            format!("wears by finnie: {} m3/J", short(constant))
        }
        WearLaw::Oka { erosion, .. } => {
            format!(
                "wears by oka: {} mm3/kg at the reference",
                short(1e9 * erosion)
            )
        }
    };
    if wear.acceleration != 1.0 {
        let _ = write!(words, ", {} times as fast", short(wear.acceleration));
    }
    if !wear.moves {
        words += ", as a map: its surface stays";
    }
    if wear.until_depth.is_finite() {
        let _ = write!(words, "; the run ends at {} m", short(wear.until_depth));
    }
    words
}
