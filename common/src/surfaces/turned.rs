//! Profiles turned about an axis, as triangles.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::formats::mesh::TriangleMesh;

/// Chords of a circle.
const CHORDS: u32 = 72;
/// Chords of the half circle from pole to pole.
const PARALLELS: u32 = 36;

/// A sphere: a half circle turned about z.
pub(super) fn sphere(centre: DVec3, radius: f64) -> TriangleMesh {
    let profile: Vec<DVec2> = (0..=PARALLELS)
        .map(|k| {
            let (sin, cos) = libm::sincos(PI * f64::from(k) / f64::from(PARALLELS));
            // Exactly on the axis at the poles, where the sine is round-off.
            let r = if k == 0 || k == PARALLELS { 0.0 } else { sin };
            DVec2::new(radius * r, -radius * cos)
        })
        .collect();
    turned(centre, DVec3::Z, [DVec3::X, DVec3::Y], &profile)
}

/// One ring of vertices per corner of the profile, one vertex for a corner on the axis, and two triangles between
/// neighbours (one beside the axis).
pub(super) fn turned(
    origin: DVec3,
    direction: DVec3,
    across: [DVec3; 2],
    profile: &[DVec2],
) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let outward: Vec<DVec3> = (0..CHORDS)
        .map(|k| {
            let (sin, cos) = libm::sincos(TAU * f64::from(k) / f64::from(CHORDS));
            across[0] * cos + across[1] * sin
        })
        .collect();
    let mut rings = Vec::with_capacity(profile.len());
    for corner in profile {
        let first = mesh.vertices.len() as u32;
        let centre = origin + direction * corner.y;
        if corner.x > 0.0 {
            let ring = outward.iter().map(|&side| centre + side * corner.x);
            mesh.vertices.extend(ring);
            rings.push((first, true));
        } else {
            mesh.vertices.push(centre);
            rings.push((first, false));
        }
    }
    for pair in rings.windows(2) {
        let [(a, a_round), (b, b_round)] = [pair[0], pair[1]];
        for k in 0..CHORDS {
            let next = (k + 1) % CHORDS;
            let at = |first: u32, round: bool, k: u32| if round { first + k } else { first };
            let corners = [
                at(a, a_round, k),
                at(a, a_round, next),
                at(b, b_round, next),
                at(b, b_round, k),
            ];
            if a_round {
                mesh.triangles.push([corners[0], corners[1], corners[2]]);
            }
            if b_round {
                mesh.triangles.push([corners[0], corners[2], corners[3]]);
            }
        }
    }
    mesh
}
