//! What the scene format knows and this version of the solver does not: said before anything runs.

use mercury_common::scene::{ParticleSource, Place, Scene, SceneError, Start};

/// Everything in the scene that cannot be run yet, in the order of the format.
#[must_use]
pub(super) fn unsupported(scene: &Scene) -> Vec<SceneError> {
    let mut found = Found(Vec::new());
    for material in &scene.materials {
        if let Some(liquid) = &material.liquid {
            found.add(&liquid.place, "liquid bridges are");
        }
    }
    for contact in &scene.contacts {
        if contact.liquid.is_some() {
            found.add(&contact.place, "liquid bridges are");
        }
    }
    for wall in &scene.walls {
        if let Some(wear) = &wall.wear {
            found.add(&wear.place, "wear is");
        }
    }
    for particles in &scene.particles {
        match &particles.source {
            ParticleSource::One { particle, .. } | ParticleSource::Lattice { particle, .. } => {
                found.film(&particle.start);
            }
            ParticleSource::Clump { start, .. } => found.film(start),
            ParticleSource::Table { .. } | ParticleSource::Run { .. } => {}
        }
    }
    for membrane in &scene.membranes {
        found.add(&membrane.name.place, "membranes are");
    }
    for spray in &scene.sprays {
        found.add(&spray.name.place, "sprays are");
    }
    found.0
}

struct Found(Vec<SceneError>);

fn missing(place: &Place, what: &str) -> SceneError {
    place.error(format!("{what} not in this version of mercury-solve"))
}

impl Found {
    /// `what`: the thing and its verb.
    fn add(&mut self, place: &Place, what: &str) {
        self.0.push(missing(place, what));
    }

    fn film(&mut self, start: &Start) {
        let film = &start.film_volume;
        if **film > 0.0 {
            self.add(&film.place, "liquid films are");
        }
    }
}
