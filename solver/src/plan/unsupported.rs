//! Parts of the scene format that this version of the solver does not support: reported before anything runs, with an
//! alternative.

use mercury_common::scene::{AtWalls, Place, Scene, SceneError};

/// Everything in the scene that cannot be run yet, in the order of the format.
#[must_use]
pub(super) fn unsupported(scene: &Scene) -> Vec<SceneError> {
    let mut found = Found(Vec::new());
    if *scene.liquid.evaporation > 0.0 {
        found.add(
            &scene.liquid.evaporation.place,
            "evaporation is",
            EVAPORATION,
        );
    }
    for spray in &scene.sprays {
        if *spray.mass {
            found.add(&spray.mass.place, "liquid with mass is", MASS);
        }
        if spray.at_walls == AtWalls::Film {
            found.add(&spray.name.place, "a film on walls is", WALL_FILM);
        }
    }
    found.0
}

const EVAPORATION: &str =
    "leave `evaporation` out, or make it 0: films and bridges keep their liquid then";
const MASS: &str = "leave `mass` out: particles keep their mass, and `momentum = true` gives them that of the droplets";
const WALL_FILM: &str = "leave `at_walls` out, or make it \"lost\" or \"bounce\"; what walls take is counted in .liquid.csv";

struct Found(Vec<SceneError>);

fn missing(place: &Place, what: &str, instead: &str) -> SceneError {
    let error = place.error(format!("{what} not in this version of mercury-solve"));
    error.with_help(instead)
}

impl Found {
    /// `what`: the thing and its verb; `instead`: the alternative.
    fn add(&mut self, place: &Place, what: &str, instead: &str) {
        self.0.push(missing(place, what, instead));
    }
}
