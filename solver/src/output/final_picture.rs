//! `<prefix>.final.png` and `.svg`: the last state, as `mercury-export png` draws it, with `--bonds` where there are any.

use std::path::Path;

use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::frames::sheets as sheets_of;
use mercury_common::surfaces::Placement;
use mercury_pictures::{
    BEHIND_LINES, ColourBy, Contact, ContactStyle, Frame, Options, Overview, Painter,
    SHEET_OPACITY, Sphere, Surface, moves, upwards, wall_surfaces, worn_triangles,
};

use super::wall_frames::surfaces;
use super::{FrameCopy, OutputError};
use crate::bonds::output::bond_frame;
use crate::plan::Plan;
use mercury_engine::state::{FIXED, PRESCRIBED};

/// Writes a file, and returns whether the next one is still needed.
pub type Put<'a> = dyn Fn(&Path, &[u8]) -> Result<bool, OutputError> + 'a;

/// Draws the last state of a run: colours show the depth of worn walls, where there are any; else the speed of particles, or their height where
/// everything is at rest.
///
/// # Errors
/// If a file cannot be written.
pub fn draw_final(
    folder: &Path,
    plan: &Plan,
    last: &FrameCopy,
    put: &Put<'_>,
) -> Result<(), OutputError> {
    let (frame, colour) = frame(plan, last);
    let options = Options {
        colour,
        contacts: ContactStyle::of_bonds("stress in bonds"),
        // Worn walls and bonds are seen through the particles.
        sphere_opacity: if last.wear.is_some() {
            0.25
        } else if last.bonds.is_empty() {
            1.0
        } else {
            BEHIND_LINES
        },
        ..Options::default()
    };
    let painter = Painter::new(&options, Overview::of(&frame, &options))?;
    let path = |ending: &str| folder.join(format!("{}.final.{ending}", plan.outputs().prefix()));
    let (image, svg) = painter.image_and_svg(&frame)?;
    if put(&path("png"), &image.png()?)? {
        put(&path("svg"), svg.as_bytes())?;
    }
    Ok(())
}

/// The view, and the quantity that its colours show.
fn frame(plan: &Plan, last: &FrameCopy) -> (Frame, ColourBy) {
    let particles = &last.particles;
    let flat = plan.physics().dimensions == 2;
    let grains = particles.iter().map(|p| (p.radius, p.velocity));
    let moves = moves(plan.physics().gravity, last.time, grains);
    let up = upwards(plan.physics().gravity, flat);
    let spheres = particles.iter().map(|particle| Sphere {
        centre: particle.position,
        radius: particle.radius,
        value: if last.wear.is_some() {
            f64::NAN
        } else if moves {
            particle.velocity.length()
        } else {
            particle.position.dot(up)
        },
        fixed: particle.flags & (FIXED | PRESCRIBED) != 0,
    });
    let names: Vec<String> = plan
        .physics()
        .walls
        .iter()
        .map(|wall| wall.name.clone())
        .collect();
    let standing: Vec<Option<Placement>> = (last.walls.iter())
        .map(|wall| {
            wall.present.then_some(Placement {
                rotation: wall.pose.rotation,
                translation: wall.pose.translation,
            })
        })
        .collect();
    let domain = plan.physics().cell.corners();
    let mut shapes = surfaces(plan);
    let mut grains = Vec::new();
    if let Some(wear) = &last.wear {
        let walls: Vec<u32> = wear.rows.iter().map(|(wall, _)| *wall as u32).collect();
        grains = worn_triangles(&wear.vertices, &walls, &shapes, &standing);
        shapes = wear.vertices.worn_surfaces(&shapes);
    }
    let mut all = wall_surfaces(&names, &shapes, &standing, domain);
    if let Some(sheets) = &last.membranes {
        // Frames of our own: triangles have their vertices.
        let meshes = sheets_of(&sheets.vertices, &sheets.triangles).unwrap_or_default();
        let triangles = |mesh: &TriangleMesh| {
            let all = 0..mesh.triangles.len();
            all.map(|k| mesh.corners(k)).collect()
        };
        all.extend(meshes.iter().map(|sheet| Surface {
            opacity: SHEET_OPACITY,
            ..Surface::wall(triangles(&sheet.mesh))
        }));
    }
    let bonds = bond_frame(last);
    let line = |row: usize| {
        let [from, to] = bonds.ends(row);
        let strength = bonds.tension[row].max(bonds.shear[row]).max(0.0);
        Contact { from, to, strength }
    };
    let frame = Frame {
        title: plan.outputs().title().to_owned(),
        time: Some(last.time),
        flat,
        gravity: plan.physics().gravity,
        domain: Some(domain),
        spheres: spheres.collect(),
        grains,
        surfaces: all,
        contacts: (0..bonds.len()).map(line).collect(),
        ..Frame::default()
    };
    let colour = if last.wear.is_some() {
        ColourBy::scalar("depth", "m")
    } else if moves {
        ColourBy::scalar("speed", "m/s")
    } else {
        ColourBy::scalar("height", "m")
    };
    (frame, colour)
}
