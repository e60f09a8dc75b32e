//! Memory is estimated before it is taken, and what the machine does not have is refused.

use mercury_common::machine::MachineMemory;
use mercury_common::scene::{Files, Scene, SceneErrors};

use crate::plan::{parse_scene, plan, sketch};
use crate::run::{check_fit, memory, plan_within};

/// One material, a box of 1 m; the subject of the test follows.
const HEAD: &str = "[time]\nend = 1.0\nstep = \"auto\"\n[domain]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[output]\ninterval = 0.1\n\
    [materials.glass]\ndensity = 2500.0\nnormal = { law = \"linear\", stiffness = 1000.0, restitution = 0.8 }\n\
    tangential = { law = \"linear\", stiffness_ratio = 0.3, friction = 0.5 }\n";

fn scene(body: &str) -> Scene {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/good/a.toml");
    let text = format!("{HEAD}{body}");
    parse_scene(&path, &text, &[], Files::MustExist).unwrap_or_else(|errors| panic!("{errors}"))
}

fn lattice(spacing: f64) -> String {
    lattice_at(0.05, spacing)
}

/// 0.9 m wide.
fn lattice_at(min: f64, spacing: f64) -> String {
    let max = min + 0.9;
    format!(
        "[[particles]]\nmaterial = \"glass\"\nradius = 1e-5\n\
        lattice = {{ min = [{min:?}, {min:?}, {min:?}], max = [{max:?}, {max:?}, {max:?}], spacing = {spacing:?}, jitter = 1e-6 }}\n"
    )
}

fn rods(spacing: f64) -> String {
    format!(
        "[clumps.rod]\nfile = \"rod.clump.toml\"\nmaterial = \"glass\"\n\
        [[particles]]\nclump = \"rod\"\nscale = 0.01\norientation = \"random\"\n\
        lattice = {{ min = [0.04, 0.04, 0.04], max = [0.94, 0.94, 0.94], spacing = {spacing:?} }}\n"
    )
}

fn rain(number: &str) -> String {
    format!(
        "[[insertions]]\nname = \"rain\"\nregion = {{ shape = \"box\", min = [0, 0, 0], max = [1, 1, 1] }}\nmaterial = \"glass\"\n\
        psd = {{ kind = \"monodisperse\", diameter = 1e-4 }}\ntotal = {{ number = {number} }}\n"
    )
}

fn machine(total: f64) -> Option<MachineMemory> {
    Some(MachineMemory { total, free: total })
}

/// Key, message and help.
fn words(errors: &SceneErrors) -> Vec<String> {
    let words = |error: &mercury_common::scene::SceneError| {
        let help = error.help.as_deref().unwrap_or_default();
        format!("{}: {} | {help}", error.path(), error.message)
    };
    errors.0.iter().map(words).collect()
}

/// 10 x 10 x 10 sites (0.05 to 0.95 by 0.1), one of them alone, rods on 4 x 4 x 4, and all at once.
#[test]
fn a_sketch_needs_the_memory_of_the_whole() {
    let one = "[[particles]]\nmaterial = \"glass\"\nradius = 1e-5\nposition = [0.5, 0.51, 0.52]\n";
    for body in [
        lattice(0.1),
        rods(0.3),
        format!("{}{}{one}{}", rods(0.3), lattice(0.1), rain("1000")),
    ] {
        let scene = scene(&body);
        let (whole, sketch) = (plan(&scene).unwrap(), sketch(&scene).unwrap());
        let made =
            |plan: &crate::plan::Plan| plan.physics().particles.len() + plan.physics().bodies.len();
        assert!(made(&whole) > 60 && made(&sketch) <= 5);
        assert_eq!(memory(&sketch), memory(&whole));
        assert_eq!(whole.notes().counted().left_out, Default::default());
    }
}

/// 1 + 0.9/1e-3 = 901 sites along each axis: 731,432,701.
#[test]
fn a_lattice_that_does_not_fit_is_refused_before_it_is_made() {
    let body = format!("{}{}", lattice_at(0.0505, 0.1), lattice(1e-3));
    let errors = plan_within(&scene(&body), machine(24e9)).unwrap_err();
    let [error] = &words(&errors)[..] else {
        panic!("{errors}")
    };
    assert!(
        error.starts_with("particles[1]: the run is expected to need "),
        "{error}"
    );
    for part in [
        " TB of memory, and this machine has 24 GB; this lattice has 731,432,701 of its 731,433,701 spheres | ",
        "--force-memory",
    ] {
        assert!(error.contains(part), "{part:?} is not in {error}");
    }
    // 601 sites along each axis, three pebbles each; its other errors are reported, too, but nothing is made.
    let scene_of_rods = scene(&rods(1.5e-3));
    let errors = plan_within(&scene_of_rods, machine(24e9)).unwrap_err();
    assert!(
        words(&errors)[0].contains("this lattice has 651,245,403 of its 651,245,403 spheres"),
        "{errors}"
    );
    let wrong = lattice(1e-3).replace(
        "radius = 1e-5",
        "radius = 1e-5\nfixed = true\nvelocity = [1, 0, 0]",
    );
    let errors = plan_within(&scene(&wrong), machine(24e9)).unwrap_err();
    assert!(
        words(&errors)[0].contains("a fixed particle has a velocity"),
        "{errors}"
    );
}

#[test]
fn more_spheres_than_can_be_numbered_are_refused_on_any_machine() {
    // 1501 sites along each axis: 3.38e9, each less than 4e9.
    let body = format!("{}{}", lattice(6e-4), lattice_at(0.0503, 6e-4));
    for limit in [None, machine(1e15)] {
        let errors = plan_within(&scene(&lattice(1e-9)), limit).unwrap_err();
        let error = &words(&errors)[0];
        assert!(
            error.starts_with("particles[0].lattice: has 7.29")
                && error.contains("no more than 4e9 can be numbered"),
            "{error}"
        );
    }
    let errors = sketch(&scene(&body)).unwrap_err();
    let error = &words(&errors)[0];
    assert!(
        error.starts_with("particles[1].lattice: has 3.38")
            && error.contains("with those before it"),
        "{error}"
    );
}

#[test]
fn what_insertions_bring_is_counted_after_the_plan_is_reported() {
    let scene = scene(&rain("1000000000"));
    let (plan, needed) = plan_within(&scene, machine(24e9)).unwrap();
    assert_eq!(needed.spheres, 1e9);
    let small = machine(24e9).unwrap();
    let error = check_fit(&scene, &plan, &needed, small).unwrap_err();
    let error = &words(&SceneErrors(vec![error]))[0];
    assert!(
        error.starts_with("insertions.rain: the run is expected to need ")
            && error.contains(" TB of memory, and this machine has 24 GB; this insertion brings up to 1,000,000,000 of its 1,000,000,000 spheres"),
        "{error}"
    );
    let large = machine(2.0 * needed.peak()).unwrap();
    check_fit(&scene, &plan, &needed, large).unwrap();
    // The free memory changes: a lack of it is reported, not refused.
    let busy = MachineMemory { free: 0.0, ..large };
    check_fit(&scene, &plan, &needed, busy).unwrap();
    let reported = |machine| crate::plan::report(&plan, &needed, Some(machine));
    let line = |text: String| {
        text.lines()
            .find(|line| line.contains("this machine has"))
            .unwrap()
            .to_owned()
    };
    assert!(
        line(reported(small))
            .contains("24 GB, 24 GB of it free now: THE RUN DOES NOT FIT, it needs ")
    );
    assert!(
        line(reported(busy)).contains(" 0 B of it free now: less than the run needs at most, ")
    );
    assert!(!line(reported(large)).contains("needs"));
}

/// The largest of each kind is named; tables are one entry, as their rows are not counted one by one.
#[test]
fn the_largest_is_named() {
    let tiny = machine(1.0).unwrap();
    let largest = |body: &str| {
        let scene = scene(body);
        let plan = plan(&scene).unwrap();
        let error = check_fit(&scene, &plan, &memory(&plan), tiny).unwrap_err();
        words(&SceneErrors(vec![error]))[0].clone()
    };
    let table = "[[particles]]\nfile = \"some.csv\"\nmaterial = \"glass\"\n";
    assert!(largest(&format!("{}{}", lattice(0.3), rain("1000"))).starts_with("insertions.rain: "));
    assert!(largest(&format!("{}{}", lattice(0.1), rain("10"))).starts_with("particles[0]: "));
    let error = largest(table);
    assert!(
        error.starts_with("particles[0]: ") && error.contains("tables and runs"),
        "{error}"
    );
}
