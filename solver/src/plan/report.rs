//! The plan as text: what `--check` prints.

use std::fmt::Write;

use mercury_cg::analysis::TimeMode;
use mercury_common::machine::MachineMemory;
use mercury_common::readable::bytes;

use super::meshes::describe;
use super::motions;
use super::passes::passes;
use super::{Disk, FieldPlan, Memory, PairPlan, Plan};
use mercury_engine::bonds::{BondPlan, BondedStart};
use mercury_engine::boundaries::expected_number;
use mercury_engine::boundaries::{FluxPart, Quantity, Rate, Total};
use mercury_engine::contact::parameter::short;
use mercury_engine::membrane::MembranePlan;
use mercury_engine::walls::{Shape, Wall};
use mercury_engine::wear::WearPlan;

/// The plan in aligned plain text, with the expected memory of its run beside that of the machine, if that is known.
#[must_use]
pub fn report(plan: &Plan, memory: &Memory, machine: Option<MachineMemory>) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_report(&mut text, plan, memory, machine);
    text
}

/// A step that is given is compared with the automatic one where they differ by this factor.
const FAR: f64 = 3.0;

/// A line `  name       value`.
fn line(text: &mut String, name: &str, value: &str) -> std::fmt::Result {
    writeln!(text, "  {name:<24}{value}")
}

/// Line of a field evaluation: the fields, places and times.
fn fields_line(fields: &FieldPlan) -> String {
    let evaluator = &fields.analysis.evaluator;
    let kernel = &evaluator.kernel;
    let mut words = format!(
        "`{}`, {} of {} at {} in {}, {} of width {} m, every {} s",
        fields.name,
        match fields.analysis.time {
            TimeMode::Average => "the mean".to_owned(),
            TimeMode::Frames => "blocks".to_owned(),
            TimeMode::Smooth { width, step } => {
                format!(
                    "means every {} s, smoothed over {} s,",
                    short(step),
                    short(width)
                )
            }
        },
        match fields.analysis.fields.len() {
            1 => "1 field".to_owned(),
            count => format!("{count} fields"),
        },
        match evaluator.place.len() {
            1 => "1 point".to_owned(),
            count => format!("{count} points"),
        },
        evaluator.coordinates,
        kernel.shape.name(),
        short(kernel.width),
        short(fields.interval)
    );
    if fields.from > 0.0 {
        words += &format!(" from {} s", short(fields.from));
    }
    if fields.until.is_finite() {
        words += &format!(" until {} s", short(fields.until));
    }
    words
}

fn heading(text: &mut String, title: &str) -> std::fmt::Result {
    writeln!(text, "\n{title}")
}

fn vector(v: glam::DVec3) -> String {
    let [x, y, z] = v.to_array().map(short);
    format!("[{x}, {y}, {z}]")
}

fn write_report(
    text: &mut String,
    plan: &Plan,
    memory: &Memory,
    machine: Option<MachineMemory>,
) -> std::fmt::Result {
    writeln!(text, "{}", plan.outputs().title())?;
    // First, as the rest is long, and may be wrong if these are right.
    if !plan.notes().warnings().is_empty() {
        heading(text, "Warnings")?;
        for warning in plan.notes().warnings() {
            writeln!(text, "  {warning}")?;
        }
    }
    heading(text, "Space")?;
    let corners = format!(
        "{} to {} m",
        vector(plan.physics().cell.low()),
        vector(plan.physics().cell.high())
    );
    line(text, "domain", &corners)?;
    let axes: Vec<&str> = (0..3)
        .filter(|&axis| plan.physics().cell.is_periodic(axis))
        .map(|axis| ["x", "y", "z"][axis])
        .collect();
    let periodic = if axes.is_empty() {
        "no axis".to_owned()
    } else {
        axes.join(", ")
    };
    line(text, "periodic", &periodic)?;
    let dimensions = match plan.physics().dimensions {
        2 => "2: discs in x-y, masses per unit length",
        _ => "3",
    };
    line(text, "dimensions", dimensions)?;
    line(
        text,
        "gravity",
        &format!("{} m/s^2", vector(plan.physics().gravity)),
    )?;

    particles(text, plan)?;
    walls(text, plan)?;
    heading(text, "Contacts")?;
    if plan.notes().pairs().is_empty() {
        writeln!(text, "  none: nothing in this scene can touch")?;
    }
    for pair in plan.notes().pairs() {
        write_pair(text, pair)?;
    }
    time(text, plan)?;

    heading(text, "What is done in a step")?;
    let all = passes(plan);
    for pass in all.iter().filter(|pass| pass.is_done) {
        line(text, pass.name, &pass.reason)?;
    }
    heading(text, "What is skipped, and why")?;
    for pass in all.iter().filter(|pass| !pass.is_done) {
        line(text, pass.name, &pass.reason)?;
    }
    heading(text, "Output")?;
    for (name, value) in Disk::of(plan).lines(plan) {
        line(text, name, &value)?;
    }
    let files = plan.outputs().files();
    let links =
        (plan.physics().steps as f64 * plan.physics().time_step / files.link_interval).floor();
    let kept = links.min(files.keep_checkpoints as f64);
    if kept > 0.0 {
        let size = bytes(kept * memory.checkpoint);
        line(
            text,
            "kept checkpoints",
            &format!("{kept} at most, about {size}"),
        )?;
    }
    write_memory(text, memory, machine)?;
    if !plan.notes().remarks().is_empty() {
        heading(text, "Notes")?;
        for note in plan.notes().remarks() {
            writeln!(text, "  {note}")?;
        }
    }
    Ok(())
}

fn write_memory(
    text: &mut String,
    memory: &Memory,
    machine: Option<MachineMemory>,
) -> std::fmt::Result {
    heading(text, "Memory, estimated")?;
    let spheres = memory.spheres.round();
    let mut steps = bytes(memory.steps);
    if spheres >= 1.0 {
        let _ = write!(steps, " for {} spheres", short(spheres));
    }
    line(text, "time loop", &steps)?;
    let most = format!(
        "{}, while a candidate list is built or a frame is written",
        bytes(memory.most)
    );
    line(text, "at most", &most)?;
    let checkpoint = format!(
        "{} besides, from the first one on",
        bytes(memory.checkpoint)
    );
    line(text, "checkpoints", &checkpoint)?;
    let start = format!(
        "{}, while tables are read and overlaps looked for; given back before the first step",
        bytes(memory.start)
    );
    line(text, "at the start", &start)?;
    let of_machine = match machine {
        None => "unknown: this system does not say".to_owned(),
        Some(machine) if memory.peak() > machine.total => {
            format!(
                "{machine}: THE RUN DOES NOT FIT, it needs {}",
                bytes(memory.peak())
            )
        }
        Some(machine) if memory.peak() > machine.free => {
            format!(
                "{machine}: less than the run needs at most, {}",
                bytes(memory.peak())
            )
        }
        Some(machine) => machine.to_string(),
    };
    line(text, "this machine has", &of_machine)
}

fn particles(text: &mut String, plan: &Plan) -> std::fmt::Result {
    heading(text, "Particles")?;
    let fixed = plan.physics().particles.iter().filter(|p| p.fixed).count();
    let prescribed = plan
        .physics()
        .particles
        .iter()
        .filter(|p| !p.fixed && p.is_prescribed())
        .count();
    let mut start = format!("{}", plan.physics().particles.len());
    for (count, what) in [(fixed, "fixed"), (prescribed, "prescribed")] {
        if count > 0 {
            let _ = write!(start, ", {count} {what}");
        }
    }
    line(text, "at the start", &start)?;
    if !plan.physics().bodies.is_empty() {
        let mut words = format!("{}", plan.physics().bodies.len());
        let fixed = plan
            .physics()
            .bodies
            .iter()
            .filter(|body| body.fixed)
            .count();
        let prescribed = plan
            .physics()
            .bodies
            .iter()
            .filter(|body| body.is_prescribed());
        for (count, what) in [(fixed, "fixed"), (prescribed.count(), "prescribed")] {
            if count > 0 {
                let _ = write!(words, ", {count} {what}");
            }
        }
        line(text, "bodies at the start", &words)?;
    }
    let densities: Vec<f64> = plan.physics().materials.iter().map(|m| m.density).collect();
    for insertion in &plan.physics().insertions {
        let mut words = match (
            insertion.total,
            expected_number(insertion, &densities, plan.physics().dimensions),
        ) {
            (Some(Total::Number(number)), _) => format!("{number} particles"),
            (Some(Total::Mass(mass)), Some(expected)) => {
                format!(
                    "{} kg, about {} particles",
                    short(mass),
                    short(expected.round())
                )
            }
            (Some(Total::Volume(volume)), Some(expected)) => {
                format!(
                    "{} m^3, about {} particles",
                    short(volume),
                    short(expected.round())
                )
            }
            (Some(_), _) => "until nothing fits any more".to_owned(),
            (None, _) => "no total".to_owned(),
        };
        match &insertion.rate {
            None => words.push_str(", as fast as they fit"),
            Some(Rate::Steady {
                quantity,
                per_second,
            }) => {
                let unit = match quantity {
                    Quantity::Number => "particles/s",
                    Quantity::Mass => "kg/s",
                    Quantity::Volume => "m^3/s",
                };
                let _ = write!(words, ", {} {unit}", short(*per_second));
            }
            Some(Rate::Table { amounts, .. }) => {
                let _ = write!(words, ", by a table of {} rows", amounts.rows().len());
            }
        }
        let _ = write!(words, ", from {} s", short(insertion.from));
        if insertion.until.is_finite() {
            let _ = write!(words, " until {} s", short(insertion.until));
        }
        line(text, &format!("insertion `{}`", insertion.name), &words)?;
        for part in &insertion.mixture {
            let what = match part.clump {
                None => plan.physics().materials[part.material.index()].name.clone(),
                Some(index) => format!("clump `{}`", plan.physics().clumps[index as usize].name),
            };
            let words = format!(
                "{what}, diameters {} to {} m{}",
                short(part.sizes.smallest()),
                short(part.sizes.largest()),
                match insertion.mixture.len() {
                    1 => String::new(),
                    _ => format!(", {} % of the particles", short(100.0 * part.share)),
                }
            );
            line(text, "", &words)?;
        }
    }
    for deletion in &plan.physics().deletions {
        line(text, "deletion", &format!("`{}`", deletion.name))?;
    }
    for region in plan.outputs().regions() {
        let words = format!(
            "`{}`, {} m^3 within the domain",
            region.name,
            short(region.volume)
        );
        line(text, "counted region", &words)?;
    }
    for flux in plan.outputs().fluxes() {
        let mut words = format!(
            "`{}`, across {} at {} m",
            flux.name,
            vector(flux.normal),
            vector(flux.point)
        );
        match flux.part {
            FluxPart::All => {}
            FluxPart::Disc(radius) => words += &format!(", within {} m", short(radius)),
            FluxPart::Rectangle([along, across]) => {
                words += &format!(
                    ", a rectangle with the sides {} and {} m",
                    vector(along),
                    vector(across)
                );
            }
        }
        line(text, "flux plane", &words)?;
    }
    for fields in &plan.outputs().files().fields {
        line(text, "fields", &fields_line(fields))?;
    }
    clumps(text, plan)?;
    if plan.physics().largest_radius() > 0.0 {
        let radii = format!(
            "{} to {} m, mean {} m",
            short(plan.physics().smallest_radius()),
            short(plan.physics().largest_radius()),
            short(plan.physics().mean_radius())
        );
        line(text, "radii", &radii)?;
    }
    for material in &plan.physics().materials {
        let density = format!("{} kg/m^3", short(material.density));
        line(text, &format!("density of {}", material.name), &density)?;
    }
    Ok(())
}

/// A table of the clumps, at scale 1 and with the density of their material.
fn clumps(text: &mut String, plan: &Plan) -> std::fmt::Result {
    if plan.physics().clumps.is_empty() {
        return Ok(());
    }
    writeln!(
        text,
        "  {:<16}{:>8}  {:>12}  {:<36}{:>14}{:>14}",
        "clump", "pebbles", "mass/kg", "principal moments/(kg m^2)", "d_volume/m", "r_circum/m"
    )?;
    for clump in &plan.physics().clumps {
        let [a, b, c] = clump.moments.to_array();
        let moments = format!("{a:.5e} {b:.5e} {c:.5e}");
        writeln!(
            text,
            "  {:<16}{:>8}  {:>12.5e}  {:<36}{:>14.6e}{:>14.6e}",
            clump.name,
            clump.pebbles.len(),
            clump.mass,
            moments,
            clump.equal_volume_diameter(),
            clump.radius
        )?;
    }
    Ok(())
}

fn walls(text: &mut String, plan: &Plan) -> std::fmt::Result {
    heading(text, "Walls")?;
    if plan.physics().walls.is_empty() {
        writeln!(text, "  none")?;
    }
    for (index, wall) in plan.physics().walls.iter().enumerate() {
        let mut words = plan.physics().materials[wall.material.index()].name.clone();
        if !wall.motion.is_static() {
            words.push_str(", moving");
        }
        if wall.from > 0.0 {
            let _ = write!(words, ", from {} s", short(wall.from));
        }
        if wall.until.is_finite() {
            let _ = write!(words, ", until {} s", short(wall.until));
        }
        line(text, &wall.name, &words)?;
        for motion in motions::lines(&wall.motion) {
            line(text, "", &motion)?;
        }
        if let Shape::Mesh(mesh) = &wall.shape {
            line(text, "", &describe(mesh))?;
        }
        let wear = plan.physics().plans.all::<WearPlan>().iter();
        for wear in wear.filter(|wear| wear.wall == index) {
            line(text, "", &crate::wear::plan::describe(wear))?;
        }
    }
    membranes(text, plan)
}

/// Sheets, where there are any.
fn membranes(text: &mut String, plan: &Plan) -> std::fmt::Result {
    let sheets = plan.physics().plans.all::<MembranePlan>();
    for (number, membrane) in sheets.iter().enumerate() {
        let surface = &membrane.surface;
        if number == 0 {
            heading(text, "Membranes")?;
        }
        let material = &plan.physics().materials[surface.material.index()].name;
        line(text, &surface.name, material)?;
        for words in crate::membranes::plan::describe(membrane) {
            line(text, "", &words)?;
        }
    }
    bonds(text, plan)
}

/// Glue, where there is any.
fn bonds(text: &mut String, plan: &Plan) -> std::fmt::Result {
    let plans = &plan.physics().plans;
    let Some(start) = plans.get::<BondedStart>() else {
        return Ok(());
    };
    heading(text, "Bonds")?;
    for (number, entry) in plans.all::<BondPlan>().iter().enumerate() {
        let words = crate::bonds::plan::describe(entry, number, start);
        line(text, &entry.name, &words)?;
    }
    Ok(())
}

fn write_pair(text: &mut String, pair: &PairPlan) -> std::fmt::Result {
    let [a, b] = &pair.names;
    let where_they_meet = match (pair.between_particles, pair.at_walls) {
        (true, true) => "particles and walls",
        (true, false) => "particles",
        _ => "walls",
    };
    writeln!(text, "  {a} - {b} ({where_they_meet})")?;
    for parameter in &pair.parameters {
        let value = format!("{} {}", parameter.value, parameter.unit);
        writeln!(
            text,
            "    {:<36}{:<22}{}",
            parameter.name,
            value.trim_end(),
            parameter.origin
        )?;
    }
    Ok(())
}

/// Conditions of an end at rest.
fn until_rest(plan: &Plan) -> String {
    let physics = plan.physics();
    let end = physics.steps as f64 * physics.time_step;
    let goes_on = |wall: &&Wall| wall.motion.windows().any(|[_, until]| until >= end);
    let mut reported = "or until the particles rest".to_owned();
    if let Some(wall) = physics.walls.iter().find(goes_on) {
        reported += &format!(", which they do not as long as wall `{}` moves", wall.name);
    } else if let Some(event) = physics.last_event() {
        reported += &format!(", but not before {event}");
    }
    reported
}

fn time(text: &mut String, plan: &Plan) -> std::fmt::Result {
    heading(text, "Time")?;
    let step = plan.notes().step();
    let steps = format!("{:e} s: {}", plan.physics().time_step, step.reason);
    line(text, "step", &steps)?;
    if let Some(automatic) = step.automatic {
        let times = plan.physics().time_step / automatic;
        if !(1.0 / FAR..FAR).contains(&times) {
            let far = if times < 1.0 {
                format!(
                    "{} times as long, for a run so much shorter",
                    short(1.0 / times)
                )
            } else {
                format!("{} of this one", short(1.0 / times))
            };
            line(
                text,
                "",
                &format!("\"auto\" would take {} s, {far}", short(automatic)),
            )?;
        }
    }
    let end = short(plan.physics().steps as f64 * plan.physics().time_step);
    line(
        text,
        "steps",
        &format!("{}, until {end} s", plan.physics().steps),
    )?;
    if plan.physics().until_at_rest {
        line(text, "", &until_rest(plan))?;
    }
    let speed = format!(
        "{} m/s: {}",
        short(step.reference_speed),
        step.reference_speed_reason
    );
    line(text, "reference speed", &speed)?;
    for (name, limit) in [
        ("shortest contact", &step.contact),
        ("critical step", &step.critical),
    ] {
        if let Some(limit) = limit {
            let words = format!(
                "{} s ({}); the step is {} of it",
                short(limit.time),
                limit.of,
                short(plan.physics().time_step / limit.time)
            );
            line(text, name, &words)?;
        }
    }
    if let Some(time) = step.rayleigh {
        let words = format!(
            "{} s; the step is {} of it",
            short(time),
            short(plan.physics().time_step / time)
        );
        line(text, "Rayleigh time", &words)?;
    }
    Ok(())
}
