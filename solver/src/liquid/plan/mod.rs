//! Liquid of a scene: bridges against the grains that they join, and films of walls.

pub(crate) mod bridges;
mod wall_films;

pub(crate) use wall_films::wall_films;

use mercury_common::particle_properties::FILM_VOLUME;
use mercury_common::scene::Scene;
use mercury_engine::boundaries::InsertionPlan;
use mercury_engine::contact::registry::LawTable;
use mercury_engine::liquid::{LiquidPlan, Weight};
use mercury_engine::spray::SprayPlan;
use mercury_engine::state::StartValues;
use mercury_engine::walls::WallFilmPlan;

/// Films, bridges and droplets; `None` in scenes without liquid. `start`: values of properties of the start.
pub(crate) fn liquid(
    scene: &Scene,
    wall_films: Vec<Option<WallFilmPlan>>,
    laws: &LawTable,
    sprays: Option<&SprayPlan>,
    insertions: &[InsertionPlan],
    start: &[StartValues],
    time_step: f64,
) -> Option<LiquidPlan> {
    let has_liquid = !wall_films.is_empty()
        || laws.has_liquid()
        || sprays.is_some()
        || start.iter().any(|values| *values.property == FILM_VOLUME)
        || (insertions.iter().flat_map(|insertion| &insertion.mixture))
            .flat_map(|part| &part.properties)
            .any(|(property, _)| **property == FILM_VOLUME);
    has_liquid.then(|| LiquidPlan {
        neighbours: scene.liquid.neighbours,
        bridges_form: scene.liquid.bridges_form,
        evaporation: *scene.liquid.evaporation,
        weight: sprays
            .and_then(|sprays| sprays.nozzles.iter().find(|nozzle| nozzle.mass))
            .map(|nozzle| Weight {
                density: nozzle.liquid_density,
                gravity: *scene.gravity,
                lag: 0.5 * time_step,
            }),
        wall_films,
    })
}
