//! A stone from a surface and 500 pebbles, spun.
//!
//! A rattleback turns back because its principal axes lie askew to the curvatures of its bottom (Walker 1896). Those of the reference
//! surface do not: its sections are ellipses along a principal axis. With its principal axes turned by 8 degrees it is a
//! rattleback, in the one sense or the other.

use std::sync::OnceLock;

use glam::{DQuat, DVec2, DVec3, dvec3};
use mclump::clump::{Built, Input, Options, build};
use mclump::inertia::comparison::Route;
use mclump::surface::prepare;
use mercury_common::formats::mesh::read_mesh;
use mercury_common::formats::pebble_list::read_pebble_list;
use mercury_solver::plan::NewBody;

use super::{Shapes, Table, solver_clump};
use crate::cases::Case;
use crate::cases::Tolerance::Absolute;

/// Lengths in mm, the density is 1: g is small, so that times are long.
const TABLE: Table = Table {
    stiffness: 1e7,
    restitution: 0.7,
    friction: 0.7,
    gravity: 10.0,
    step: 3e-4,
};
/// Angle between principal axes and pebbles, degrees.
const SKEW: f64 = 8.0;
/// Spin at the start, rad/s.
const SPIN: f64 = 0.7;
/// Time for which the stone is watched, s.
const WATCHED: f64 = 25.0;

fn built(shapes: &Shapes) -> Built {
    let mesh = read_mesh(shapes.file("mesh/Rattleback.stl")).expect("the reference mesh is right");
    let list = shapes.file("pebbles/rattleback_500_input.csv");
    let input = Input {
        name: "rattleback".to_owned(),
        surface: Some(prepare(mesh, false).expect("the reference mesh is closed")),
        pebbles: read_pebble_list(list).expect("the reference list is right"),
    };
    let options = Options {
        route: Some(Route::Surface),
        ..Options::default()
    };
    build(&input, &options).expect("the reference surface is a body")
}

/// Farthest spin against its start and least spin in its sense, over the start: of the stone with its pebbles turned by `skew`
/// degrees about the third principal axis.
fn spin_back(shapes: &Shapes, skew: f64, spin: f64) -> f64 {
    let mut file = built(shapes).file;
    let turn = DQuat::from_rotation_z(skew.to_radians());
    for pebble in &mut file.pebbles {
        pebble.position = turn * pebble.position;
    }
    // The curved side is up in the file.
    let orientation =
        DQuat::from_rotation_x(std::f64::consts::PI) * DQuat::from_mat3(&file.rotation);
    let body = NewBody {
        orientation,
        angular_velocity: dvec3(0.01, 0.01, spin),
        ..NewBody::at(dvec3(0.0, 0.0, 5.9), 0)
    };
    let mut engine = TABLE.with(&solver_clump(&file), body);
    let mut least = 1.0f64;
    let looks = 250;
    for _ in 0..looks {
        let steps = (WATCHED / TABLE.step) as u64 / looks;
        engine
            .steps_at_once(steps, None)
            .expect("the motion stays finite");
        least = least.min(engine.particles.bodies()[0].angular_velocity.z / spin);
    }
    least
}

/// Angle (degrees) between the long axis of the section at the height `z` (mm over the centre of mass, principal frame) and the
/// first principal axis.
fn section_angle(built: &Built, z: f64) -> f64 {
    let Some(mesh) = &built.surface else {
        return f64::NAN;
    };
    // Second moments of the polygon of all cuts, by Green's theorem; the order of the cuts does not matter, their sense does.
    let mut moments = [0.0; 6];
    for triangle in &mesh.triangles {
        let corners = triangle.map(|index| mesh.vertices[index as usize]);
        let mut cut = Vec::with_capacity(2);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            if (a.z - z) * (b.z - z) < 0.0 {
                let point: DVec3 = a + (b - a) * ((z - a.z) / (b.z - a.z));
                cut.push(point.truncate());
            }
        }
        if let [a, b] = cut[..] {
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let along = DVec2::new(-normal.y, normal.x);
            add_edge(
                &mut moments,
                if along.dot(b - a) < 0.0 {
                    [b, a]
                } else {
                    [a, b]
                },
            );
        }
    }
    let [area, x, y, xx, xy, yy] = moments;
    let (cx, cy) = (x / area, y / area);
    let (xx, xy, yy) = (
        xx / area - cx * cx,
        xy / area - cx * cy,
        yy / area - cy * cy,
    );
    (0.5 * f64::atan2(2.0 * xy, xx - yy)).to_degrees()
}

/// Adds the triangle of the origin and an edge to area, first and second moments (x, y, xx, xy, yy).
fn add_edge(moments: &mut [f64; 6], [a, b]: [DVec2; 2]) {
    let twice = a.perp_dot(b);
    for (sum, part) in moments.iter_mut().zip([
        twice / 2.0,
        twice * (a.x + b.x) / 6.0,
        twice * (a.y + b.y) / 6.0,
        twice * (a.x * a.x + a.x * b.x + b.x * b.x) / 12.0,
        twice * (2.0 * a.x * a.y + a.x * b.y + b.x * a.y + 2.0 * b.x * b.y) / 24.0,
        twice * (a.y * a.y + a.y * b.y + b.y * b.y) / 12.0,
    ]) {
        *sum += part;
    }
}

const WALKER: &str = "principal axes askew to the curvatures: it turns back in one direction of spin only (Walker 1896)";

/// A row: the stone's spin against its start; `back` if it must turn.
fn row(shapes: &Shapes, skew: f64, spin: f64, back: bool) -> Case {
    let shapes = shapes.clone();
    let (expected, allowed) = if back {
        // From a fifth to a half comes back; the rest went into impacts of pebbles.
        (-0.3, 0.2)
    } else {
        // It comes to rest on pebbles, which rock it a little.
        (0.0, 0.03)
    };
    Case::new(
        format!(
            "rattleback from the surface, axes turned by {skew:+} degrees, spun at {spin:+} rad/s: least spin over the start"
        ),
        expected,
        Absolute(allowed),
        WALKER,
        move || spin_back(&shapes, skew, spin),
    )
}

pub(super) fn quick(shapes: &Shapes) -> Vec<Case> {
    let of_section = shapes.clone();
    vec![
        Case::new(
            "rattleback from the surface: angle of its sections from the principal axis, largest (degrees)",
            0.0,
            Absolute(0.1),
            "this surface is no rattleback: its sections lie along the principal axis",
            move || {
                static ANGLE: OnceLock<f64> = OnceLock::new();
                *ANGLE.get_or_init(|| {
                    let built = built(&of_section);
                    // Up to 1.3 mm below the lowest point, where a section still is 40 mm long.
                    let heights = [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.5];
                    let angles = heights.map(|z| section_angle(&built, z).abs());
                    angles.into_iter().fold(0.0, f64::max)
                })
            },
        ),
        row(shapes, SKEW, -SPIN, true),
        row(shapes, -SKEW, SPIN, true),
    ]
}

pub(super) fn slow(shapes: &Shapes) -> Vec<Case> {
    vec![
        row(shapes, SKEW, SPIN, false),
        row(shapes, -SKEW, -SPIN, false),
    ]
}
