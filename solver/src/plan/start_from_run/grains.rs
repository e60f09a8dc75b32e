//! Grains of another run, from its checkpoint, as particles and bodies of this scene.

use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;

use mercury_common::formats::clump::Pebble;
use mercury_common::particle_properties::{
    OfClump, PARTICLE_PROPERTIES, ParticleProperty, PropertyValue,
};
use mercury_common::scene::{Dimensions, Located, Scene, SceneError};

use super::state::{State, complete, is_finite};
use super::{Earlier, EarlierRow, Grain};
use crate::plan::{NewBody, NewParticle, PrescribedMotion};
use mercury_engine::bodies::Clump;
use mercury_engine::state::{
    BodyPebble, FIXED, MaterialIndex, PEBBLE, Particles, Prescribed, PrescribedBody,
};

/// A checkpoint as particles of this scene.
pub(super) fn of_state(
    mut state: State,
    folder: &Located<PathBuf>,
    scene: &Scene,
    clumps: &[Clump],
) -> Result<Earlier, SceneError> {
    let dimensions = match scene.domain.dimensions {
        Dimensions::Two => 2,
        Dimensions::Three => 3,
    };
    if state.head.dimensions != dimensions {
        return Err(folder.error(format!(
            "that run has {} dimensions, this scene {dimensions}",
            state.head.dimensions
        )));
    }
    complete(&mut state);
    if !is_finite(&state.particles) {
        let error = folder.error(
            "a position, size, velocity or property in the last state of that run is not a finite number",
        );
        return Err(
            error.with_help("it went wrong before its end: stop it earlier, and start from there")
        );
    }
    let State {
        path,
        head,
        checksum,
        particles: state,
        pairs,
        near_walls,
        liquid_left,
        ..
    } = state;
    let material = |name: &String| {
        let mut known = scene.materials.iter();
        let found = known.position(|material| material.name.value == *name);
        found.ok_or_else(|| {
            let message = format!("there are particles of the material `{name}` in that run, and no such material in this scene");
            folder.error(message).with_help(format!("add [materials.{name}]"))
        })
    };
    // Only the materials of particles: walls may have had others, and bodies follow their clump in this scene.
    let spheres = state.records.iter();
    let used: BTreeSet<usize> = spheres
        .filter(|record| record.flags & PEBBLE == 0)
        .map(|record| record.material.index())
        .collect();
    let materials = (head.materials.iter().enumerate())
        .map(|(index, name)| match used.contains(&index) {
            true => material(name),
            false => Ok(usize::MAX),
        })
        .collect::<Result<Vec<usize>, SceneError>>()?;

    let prescribed = state.prescribed.iter();
    let prescribed: HashMap<usize, &Prescribed> =
        prescribed.map(|one| (one.row.index(), one)).collect();
    let mut rows = vec![None; state.len()];
    let mut particles = Vec::new();
    for row in state.rows_by_id() {
        let row = row as usize;
        let record = &state.records[row];
        if record.flags & PEBBLE != 0 {
            continue;
        }
        let there = record.material.index();
        rows[row] = Some(EarlierRow {
            grain: Grain::Particle(particles.len()),
            material: [there, materials[there]],
        });
        let prescribed = prescribed.get(&row);
        let particle = NewParticle {
            velocity: record.velocity,
            angular_velocity: record.angular_velocity,
            fixed: record.flags & FIXED != 0,
            prescribed: prescribed
                .and_then(|one| PrescribedMotion::boxed(one.velocity, one.angular_velocity)),
            ..NewParticle::at(
                record.position,
                record.radius,
                MaterialIndex::new(materials[there] as u32),
            )
        };
        particles.push((particle, properties(&state, &[row])));
    }
    let mut bodies = Vec::new();
    let prescribed_bodies = state.bodies.iter().flat_map(|all| &all.prescribed);
    let prescribed_bodies: HashMap<usize, &PrescribedBody> = prescribed_bodies
        .map(|one| (one.body.index(), one))
        .collect();
    for (index, body) in state.bodies().iter().enumerate() {
        // There are bodies.
        let Some(all) = &state.bodies else { break };
        let pebbles = &all.pebbles[body.pebbles()];
        let name = &head.clumps[body.clump as usize];
        let Some(clump) = clumps.iter().position(|clump| clump.name == *name) else {
            let message = format!(
                "there are bodies of the clump `{name}` in that run, and no such clump in this scene"
            );
            return Err(folder
                .error(message)
                .with_help(format!("add [clumps.{name}]")));
        };
        let template = &clumps[clump];
        let mut scale = body.radius / template.radius;
        if (scale - 1.0).abs() < 1e-12 {
            // But for round-off of the division.
            scale = 1.0;
        }
        let same = |(here, there): (&Pebble, &BodyPebble)| {
            let radius = state.records[there.row.index()].radius;
            let off = (here.position * scale - there.offset).length();
            (here.radius * scale - radius).abs().max(off) <= 1e-9 * body.radius
        };
        if pebbles.len() != template.pebbles.len()
            || !template.pebbles.iter().zip(pebbles).all(same)
        {
            return Err(folder.error(format!("the clump `{name}` has other pebbles in that run")));
        }
        for (number, pebble) in pebbles.iter().enumerate() {
            rows[pebble.row.index()] = Some(EarlierRow {
                grain: Grain::Pebble(index, number),
                material: [body.material.index(), template.material.index()],
            });
        }
        let prescribed = prescribed_bodies.get(&index);
        let of_body: Vec<usize> = pebbles.iter().map(|pebble| pebble.row.index()).collect();
        let body = NewBody {
            scale,
            orientation: body.orientation,
            velocity: body.velocity,
            angular_velocity: body.angular_velocity,
            fixed: body.is_fixed(),
            prescribed_velocity: prescribed.map_or([None; 3], |one| one.velocity),
            prescribed_angular_velocity: prescribed.map_or([None; 3], |one| one.angular_velocity),
            ..NewBody::at(body.position, clump as u32)
        };
        bodies.push((body, properties(&state, &of_body)));
    }
    let rows: Option<Vec<EarlierRow>> = rows.into_iter().collect();
    Ok(Earlier {
        folder: folder.value.clone(),
        files: vec![path],
        is_frame: false,
        key: folder.place.key().to_owned(),
        checksum,
        head,
        rows: rows.ok_or_else(|| folder.error("a pebble of that run is of no body"))?,
        pairs,
        near_walls,
        liquid_left,
        particles,
        bodies,
        first: (0, 0),
    })
}

/// Properties of a particle, or of a body with these rows, that are not the default.
fn properties(state: &Particles, rows: &[usize]) -> Vec<PropertyValue> {
    let value = |property: &'static ParticleProperty| {
        let column = state.columns.get(property.name)?;
        let sum: f64 = rows.iter().map(|&row| column[row]).sum();
        let value = match property.of_clump {
            OfClump::Sum => sum,
            OfClump::Mean => sum / rows.len() as f64,
        };
        property.differs(value).then_some((property, value))
    };
    PARTICLE_PROPERTIES.iter().filter_map(value).collect()
}
