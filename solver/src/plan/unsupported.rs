//! What the scene format knows and this version of the solver does not: said before anything runs, with what does instead.

use mercury_common::scene::{Place, Scene, SceneError};

/// Everything in the scene that cannot be run yet, in the order of the format.
#[must_use]
pub(super) fn unsupported(scene: &Scene) -> Vec<SceneError> {
    let mut found = Found(Vec::new());
    for membrane in &scene.membranes {
        found.add(&membrane.name.place, "membranes are", MEMBRANE);
    }
    found.0
}

const MEMBRANE: &str = "instead: a [[walls]] entry with a servo, which holds a pressure on a plane, box or disc (motion = [{ kind = \"servo\", pressure = 10e3, ... }]), or with shape = \"mesh\", which is rigid";

struct Found(Vec<SceneError>);

fn missing(place: &Place, what: &str, instead: &str) -> SceneError {
    let error = place.error(format!("{what} not in this version of mercury-solve"));
    error.with_help(instead)
}

impl Found {
    /// `what`: the thing and its verb; `instead`: what to do without it.
    fn add(&mut self, place: &Place, what: &str, instead: &str) {
        self.0.push(missing(place, what, instead));
    }
}
