//! Clumps that a scene scales to another size than their file's.

use std::path::Path;

use mercury_solver::plan::{Plan, plan, read_scene};

/// An egg of `scale` times its file's size above a floor, with springs of constant stiffness.
fn planned(scale: f64) -> Plan {
    let clumps = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/clumps");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("egg.toml");
    let text = format!(
        "gravity = [0.0, 0.0, -9.81]\n\
         [time]\nend = 0.1\nstep = \"auto\"\n\
         [domain]\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n\
         [materials.wood]\ndensity = 1000.0\n\
         normal = {{ law = \"linear\", stiffness = 2e4, restitution = 1.0 }}\n\
         [clumps.egg]\nfile = {:?}\nmaterial = \"wood\"\n\
         [[walls]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, -0.5]\nnormal = [0, 0, 1]\nmaterial = \"wood\"\n\
         [[particles]]\nclump = \"egg\"\nposition = [0, 0, 0]\nscale = {scale}\n\
         [output]\ninterval = 0.1\n",
        clumps.join("egg.clump.toml")
    );
    std::fs::write(&file, text).unwrap();
    let scene = read_scene(&file, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    plan(&scene).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Inertia over the square of a lever is a mass, and a contact moves a body as a mass: all masses grow with the third power of
/// the size, and the critical step of a spring without a dashpot, 2 sqrt(m/k), with the power of three halves.
#[test]
fn the_critical_step_grows_with_the_three_halves_power_of_the_size() {
    let critical = |plan: &Plan| plan.notes().step().critical.as_ref().unwrap().time;
    let alone = critical(&planned(1.0));
    for scale in [0.5, 2.0, 3.0f64] {
        let expected = alone * scale.powf(1.5);
        let found = critical(&planned(scale));
        assert!(
            (found / expected - 1.0).abs() < 1e-12,
            "{scale}: {found} s, {expected} s"
        );
    }
}
