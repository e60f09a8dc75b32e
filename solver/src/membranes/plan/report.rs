//! Warnings and lines of the report about sheets.

use glam::DVec3;
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::scene::{Membrane, Scene};

use crate::plan::motions;
use mercury_engine::contact::parameter::short;
use mercury_engine::membrane::{Elasticity, HoldCourse, Load, MembranePlan, Sheet};

/// Springs whose triangles scatter by more than this are warned about.
const SCATTER: f64 = 0.05;

/// A sheet that its own weight stretches by more than this is warned about.
const OWN_WEIGHT: f64 = 0.5;

/// Warnings of likely mistakes.
pub(super) fn doubts(
    scene: &Scene,
    membrane: &Membrane,
    sheet: &Sheet,
    mesh: &TriangleMesh,
    warnings: &mut Vec<String>,
) {
    let name = &membrane.name.value;
    if let Some(scatter) = sheet
        .scatter()
        .filter(|scatter| scatter.deviation > SCATTER)
    {
        warnings.push(format!(
            "membranes.{name}: its triangles are far from equilateral, so that springs scatter their tensions by {} % (root of the mean square; {} % at the worst triangle): elasticity = \"continuum\" is exact on any mesh",
            short((1000.0 * scatter.deviation).round() / 10.0),
            short((1000.0 * scatter.worst).round() / 10.0)
        ));
    }
    let law = sheet.law();
    let low = mesh.vertices.iter().copied().reduce(DVec3::min);
    let high = mesh.vertices.iter().copied().reduce(DVec3::max);
    let extent = low
        .zip(high)
        .map_or(0.0, |(low, high)| (high - low).length());
    let stretch = law.density * scene.gravity.length() * extent / law.youngs_modulus;
    if stretch > OWN_WEIGHT {
        warnings.push(format!(
            "membranes.{name}: hung up, it would stretch by {} of its length under its own weight: is youngs_modulus = {} Pa what is meant?",
            short((100.0 * stretch).round() / 100.0),
            short(law.youngs_modulus)
        ));
    }
}

/// How far the springs are from a sheet, for the report.
pub(crate) fn describe(membrane: &MembranePlan) -> Vec<String> {
    let sheet = &membrane.sheet;
    let topology = sheet.topology();
    let law = sheet.law();
    let mass: f64 = sheet.masses().iter().sum();
    let mut lines = vec![format!(
        "{} triangles, {} vertices, {} rims; {} m^2, {} kg, {} m thick",
        topology.triangles().len(),
        topology.vertices(),
        topology.rims().len(),
        short(sheet.rest_area()),
        short(mass),
        short(law.thickness)
    )];
    let stretching = match law.elasticity {
        Elasticity::Springs => {
            let far = sheet.scatter().map_or(String::new(), |scatter| {
                format!(
                    ", whose tensions scatter by {} % (root of the mean square), {} % at the worst triangle",
                    short((1000.0 * scatter.deviation).round() / 10.0),
                    short((1000.0 * scatter.worst).round() / 10.0)
                )
            });
            format!("springs{far}")
        }
        Elasticity::Continuum { poisson_ratio } => {
            format!("continuum, Poisson's ratio {}", short(poisson_ratio))
        }
    };
    let bending = law.bending.map_or("limp".to_owned(), |bending| {
        format!("bending stiffness {} N m", short(bending.stiffness))
    });
    lines.push(format!(
        "E t = {} N/m, {stretching}; {bending}",
        short(law.stiffness())
    ));
    for hold in &membrane.holds {
        let how = match &hold.ramp {
            HoldCourse::Velocity([Some(0.0), Some(0.0), Some(0.0)]) => "held".to_owned(),
            HoldCourse::Velocity(components) => {
                let words = components.map(|v| v.map_or("free".to_owned(), short));
                format!("move at [{}] m/s", words.join(", "))
            }
            HoldCourse::Motion(motion) => motions::lines(motion).join("; "),
            HoldCourse::Wall(_) => "go with a wall".to_owned(),
        };
        lines.push(format!(
            "hold `{}`, {} vertices: {how}",
            hold.name,
            hold.vertices.len()
        ));
    }
    let pressure = match &membrane.load {
        Load::Given(_) if membrane.load.is_none() => None,
        Load::Given(curve) => match curve.rows() {
            [(_, pressure)] => Some(format!("pressure {} Pa", short(*pressure))),
            rows => Some(format!("pressure by {} rows", rows.len())),
        },
        Load::Gas { gas, .. } => Some(format!(
            "gas of {} Pa in {} m^3",
            short(*gas),
            short(membrane.first_volume)
        )),
        Load::Fluid { bulk_modulus, .. } => Some(format!(
            "fluid of bulk modulus {} Pa in {} m^3",
            short(*bulk_modulus),
            short(membrane.first_volume)
        )),
    };
    lines.extend(pressure);
    lines.push(format!(
        "critical step {} s",
        short(membrane.rates().critical_step())
    ));
    lines
}
