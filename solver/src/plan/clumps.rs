//! `[clumps.NAME]`: clump files as templates of bodies.

use std::path::PathBuf;

use mercury_common::error::FormatError;
use mercury_common::formats::clump::{ClumpFile, read_clump};
use mercury_common::formats::mesh::{TriangleMesh, read_mesh};
use mercury_common::scene::{Dimensions, Located, Scene, SceneError};

use mercury_engine::bodies::Clump;
use mercury_engine::contact::parameter::short;
use mercury_engine::state::MaterialIndex;

/// All clumps, in the order of the file; nothing if one of them cannot be read.
///
/// Mass and moments are the file's, scaled by the density of the material over that of the file: as for spheres it is the
/// material that gives the density, and a file made for density 1 serves for any.
pub(super) fn clumps(
    scene: &Scene,
    warnings: &mut Vec<String>,
    notes: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Option<Vec<Clump>> {
    let before = errors.len();
    let mut clumps = Vec::new();
    for clump in &scene.clumps {
        if scene.domain.dimensions == Dimensions::Two {
            let message = "clumps are bodies in space: domain.dimensions must be 3";
            errors.push(clump.name.error(message));
            continue;
        }
        let file = match read_clump(&clump.file.value) {
            Ok(file) => file,
            Err(found) => {
                errors.extend(found.0);
                continue;
            }
        };
        let density = *scene.materials[clump.material.value.0].density;
        let ratio = density / file.density;
        if (ratio - 1.0).abs() > 1e-9 {
            notes.push(format!(
                "clump `{}`: its file has density {} kg/m^3, its material {}: mass and moments of the file are scaled by {}",
                clump.name.value,
                short(file.density),
                short(density),
                short(ratio)
            ));
        }
        let surface = surface(&clump.name.value, &file, &clump.file, warnings);
        let built = Clump::new(
            &clump.name.value,
            MaterialIndex::new(clump.material.value.0 as u32),
            file.pebbles,
            file.mass * ratio,
            file.volume,
            file.principal_moments * ratio,
        );
        match built {
            Ok(built) => clumps.push(Clump { surface, ..built }),
            Err(error) => errors.push(clump.file.error(error.to_string())),
        }
    }
    (errors.len() == before).then_some(clumps)
}

/// The surface that a clump file names. Only pictures use it: where it cannot be read they show the pebbles, and a warning says
/// so.
fn surface(
    name: &str,
    file: &ClumpFile,
    named: &Located<PathBuf>,
    warnings: &mut Vec<String>,
) -> Option<TriangleMesh> {
    let path = file.surface_path(named)?;
    let read = match named.place.may_read(&path) {
        Ok(()) => read_mesh(&path)
            .inspect(|mesh| {
                let odd = mesh.warnings.iter();
                warnings.extend(odd.map(|warning| format!("{}: {warning}", path.display())));
            })
            .map_err(|error| {
                // On one line, as all warnings are.
                let error = FormatError {
                    help: None,
                    ..error
                };
                error.to_string()
            }),
        Err(error) => Err(error.message),
    };
    read.map_err(|error| {
        warnings.push(format!(
            "clump `{name}` is shown by its pebbles, its surface cannot be read: {error}"
        ));
    })
    .ok()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use crate::plan::parse_scene;
    use glam::DVec3;
    use mercury_common::scene::Files;

    /// A file of one density serves for a material of another: mass and moments grow with it, volume and sizes stay.
    #[test]
    fn mass_and_moments_are_those_of_the_material() {
        let place = tempfile::tempdir().unwrap();
        let path = |name: &str| place.path().join(name);
        let clump = "name = \"stone\"\ndensity = 1000\nmass = 1e-5\nvolume = 1e-8\n\
            principal_moments = [1e-11, 2e-11, 2.5e-11]\n\
            pebbles = [{ position = [0, 0, 0], radius = 1.5e-3 }]\n";
        fs::write(path("stone.clump.toml"), clump).unwrap();
        let text = "[time]\nend = 1.0\nstep = 1e-5\n\
            [domain]\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n[output]\ninterval = 0.1\n\
            [materials.rock]\ndensity = 2600\nnormal = { law = \"linear\", stiffness = 1000.0, restitution = 0.5 }\n\
            [clumps.stone]\nfile = \"stone.clump.toml\"\nmaterial = \"rock\"\n\
            [[particles]]\nclump = \"stone\"\nposition = [0, 0, 0]\n";
        let scene = parse_scene(&path("test.toml"), text, &[], Files::Unchecked).unwrap();
        let plan = crate::plan::plan(&scene).unwrap();
        let clump = &plan.physics().clumps[0];
        assert!((clump.mass / 2.6e-5 - 1.0).abs() < 1e-15);
        let expected = 2.6 * DVec3::new(1e-11, 2e-11, 2.5e-11);
        assert!((clump.moments / expected - 1.0).abs().max_element() < 1e-15);
        assert_eq!((clump.volume, clump.pebbles[0].radius), (1e-8, 1.5e-3));
    }

    #[test]
    fn a_run_knows_the_surface_of_a_clump_and_does_without_it() {
        let place = tempfile::tempdir().unwrap();
        let path = |name: &str| place.path().join(name);
        let clump = "name = \"ball\"\ndensity = 1000\nmass = 4.19e-6\nvolume = 4.19e-9\n\
            principal_moments = [1.676e-12, 1.676e-12, 1.676e-12]\nsurface = \"ball.stl\"\n\
            pebbles = [{ position = [0, 0, 0], radius = 1e-3 }]\n";
        fs::write(path("ball.clump.toml"), clump).unwrap();
        let facet = "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1e-3 0 0\nvertex 0 1e-3 0\nendloop\nendfacet\n";
        fs::write(path("ball.stl"), format!("solid a\n{facet}endsolid a\n")).unwrap();
        let text = "[time]\nend = 1.0\nstep = 1e-5\n\
            [domain]\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n[output]\ninterval = 0.1\n\
            [materials.ball]\ndensity = 1000\nnormal = { law = \"linear\", stiffness = 1000.0, restitution = 0.5 }\n\
            [clumps.ball]\nfile = \"ball.clump.toml\"\nmaterial = \"ball\"\n\
            [[particles]]\nclump = \"ball\"\nposition = [0, 0, 0]\n";
        let planned = || {
            let scene = parse_scene(&path("test.toml"), text, &[], Files::Unchecked).unwrap();
            crate::plan::plan(&scene).unwrap()
        };
        let plan = planned();
        let surface = plan.physics().clumps[0].surface.as_ref();
        assert_eq!(surface.map(|mesh| mesh.triangles.len()), Some(1));
        assert!(
            plan.notes().warnings().is_empty(),
            "{:?}",
            plan.notes().warnings()
        );

        let reported = |found: &str| {
            let plan = planned();
            assert_eq!(plan.physics().clumps[0].surface, None);
            let expected = format!(
                "clump `ball` is shown by its pebbles, its surface cannot be read: {}{found}",
                path("ball.stl").display()
            );
            let warnings = &plan.notes().warnings();
            assert!(
                warnings.len() == 1 && warnings[0].starts_with(&expected),
                "{warnings:?}, not {expected}"
            );
        };
        fs::write(path("ball.stl"), "").unwrap();
        reported(": the file is empty");
        let damaged = facet.replace("1e-3 0 0", "nan 0 0");
        fs::write(path("ball.stl"), format!("solid a\n{damaged}endsolid a\n")).unwrap();
        reported(":5:8: \"nan\" for a coordinate, expected a finite number");
        fs::remove_file(path("ball.stl")).unwrap();
        reported(": the file cannot be read: ");
    }
}
