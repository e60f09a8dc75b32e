//! What the scene format knows and this version of the solver does not: said before anything runs, with what does instead.

use mercury_common::scene::{ParticleSource, Place, Scene, SceneError, Start};

/// Everything in the scene that cannot be run yet, in the order of the format.
#[must_use]
pub(super) fn unsupported(scene: &Scene) -> Vec<SceneError> {
    let mut found = Found(Vec::new());
    for material in &scene.materials {
        if let Some(liquid) = &material.liquid {
            found.add(&liquid.place, "liquid bridges are", LIQUID);
        }
    }
    for contact in &scene.contacts {
        if let Some(liquid) = &contact.liquid {
            found.add(&liquid.place, "liquid bridges are", LIQUID);
        }
    }
    for wall in &scene.walls {
        if let Some(wear) = &wall.wear {
            found.add(&wear.place, "wear is", WEAR);
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
        found.add(&membrane.name.place, "membranes are", MEMBRANE);
    }
    for spray in &scene.sprays {
        found.add(&spray.name.place, "sprays are", SPRAY);
    }
    found.0
}

/// Dry grains, or cohesion that this version has (Luding 2008).
const LIQUID: &str = "leave `liquid` out: the grains are dry then; grains that stick: normal = { law = \"plastic\", ... } with a `cohesion_stiffness` above 0";
/// Archard's law is the work of sliding, or the load times the way, over the hardness: both follow from this table.
const WEAR: &str = "leave `wear` out and set output.triangle_loads = true: pressure and power of sliding on each triangle, from which wear follows";
const MEMBRANE: &str = "instead: a [[walls]] entry with a servo, which holds a pressure on a plane, box or disc (motion = [{ kind = \"servo\", pressure = 10e3, ... }]), or with shape = \"mesh\", which is rigid";
const SPRAY: &str =
    "leave it out: this version runs dry grains; grains with a velocity come by [[insertions]]";
const FILM: &str = "leave `film_volume` out, or make it 0: the grains are dry then";

/// Of a particle whose film is in the table `file`, line by line.
pub(super) fn film_of_a_row(file: &Place, row: &str) -> SceneError {
    missing(
        file,
        &format!("{row}: liquid films are"),
        "leave the column film_volume out, or make it 0: the grains are dry then",
    )
}

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

    fn film(&mut self, start: &Start) {
        let film = &start.film_volume;
        if **film > 0.0 {
            self.add(&film.place, "liquid films are", FILM);
        }
    }
}
