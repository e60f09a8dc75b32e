//! How walls wear.

use mercury_common::scene::{Scene, Wear as SceneWear, WearLaw as SceneLaw};

use mercury_engine::walls::Wall;
use mercury_engine::wear::{WearLaw, WearPlan};

/// The walls of the plan that wear.
pub(super) fn wear(scene: &Scene, walls: &[Wall]) -> Vec<WearPlan> {
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
