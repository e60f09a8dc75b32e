//! Doubtful settings of `[[membranes]]`.

use super::{HEAD, planned_with};

/// A sheet of this mesh and these keys above a ball, and the warnings about it.
fn warnings(material: &str, mesh: &str, youngs_modulus: &str, height: f64) -> Vec<String> {
    let text = format!(
        "{HEAD}\
        [materials.m]\ndensity = 1000.0\n{material}\n\
        [[particles]]\nmaterial = \"m\"\nradius = 0.02\nposition = [0.05, 0.04, {height:?}]\n\
        [[membranes]]\nname = \"sheet\"\n{mesh}\nmaterial = \"m\"\nthickness = 1e-3\nyoungs_modulus = {youngs_modulus}\nfixed = \"rim\"\n"
    );
    let plan = planned_with(&text, &["gravity=[0.0, 0.0, -9.81]"]);
    let plan = plan.unwrap_or_else(|errors| panic!("{errors}"));
    let all = plan.notes().warnings().iter();
    all.filter(|warning| warning.starts_with("membranes.sheet"))
        .cloned()
        .collect()
}

const ELASTIC: &str = "normal = { law = \"linear\", stiffness = 1000.0, restitution = 0.8 }";
const WET: &str = "normal = { law = \"linear\", stiffness = 1000.0, restitution = 0.8 }\n\
    liquid = { law = \"willett\", surface_tension = 0.07, contact_angle_degrees = 20.0, max_bridge_volume = 1e-9 }";
const DISC: &str = "shape = \"disc\"\naxis = [0.0, 0.0, 1.0]\norigin = [0.05, 0.04, 0.0]\nradius = 0.1\nedge = 0.02\nelasticity = \"continuum\"\npoisson_ratio = 0.3";

#[test]
fn doubtful_sheets_draw_warnings() {
    let none: [&str; 0] = [];
    assert_eq!(warnings(ELASTIC, DISC, "1e6", 0.1), none);

    // Its rings are not of equilateral triangles.
    let springs = DISC
        .replace("continuum", "springs")
        .replace("poisson_ratio = 0.3", "");
    let found = warnings(ELASTIC, &springs, "1e6", 0.1);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("far from equilateral"), "{found:?}");
    assert!(found[0].contains("elasticity = \"continuum\""), "{found:?}");

    let found = warnings(ELASTIC, DISC, "1e6", 0.005);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("it leads through"), "{found:?}");

    let found = warnings(ELASTIC, DISC, "2e3", 0.1);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("under its own weight"), "{found:?}");

    let found = warnings(WET, DISC, "1e6", 0.1);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("have liquid bridges"), "{found:?}");
}

/// A sheet that is stiff beyond all contacts sets the step where it can move, and has no part in it where all of it is held.
#[test]
fn a_sheet_that_is_held_all_over_sets_no_step() {
    let planned = |sheet: &str| {
        let text = format!(
            "{HEAD}[materials.m]\ndensity = 1000.0\n{ELASTIC}\n\
            [[particles]]\nmaterial = \"m\"\nradius = 0.02\nposition = [0.05, 0.04, 0.1]\n\
            [[particles]]\nmaterial = \"m\"\nradius = 0.02\nposition = [0.05, 0.04, 0.3]\n{sheet}"
        );
        let plan = planned_with(&text, &["time.step=auto"]);
        plan.unwrap_or_else(|errors| panic!("{errors}"))
            .physics()
            .time_step
    };
    let sheet = |held: &str| {
        format!(
            "[[membranes]]\nname = \"sheet\"\n{DISC}\nmaterial = \"m\"\nthickness = 1e-3\nyoungs_modulus = 1e10\nfixed = {held}\n"
        )
    };
    let without = planned("");
    let all = "{ shape = \"sphere\", origin = [0.0, 0.0, 0.0], radius = 1.0 }";
    assert!(planned(&sheet("\"rim\"")) < 0.5 * without);
    assert_eq!(planned(&sheet(all)), without);
}
