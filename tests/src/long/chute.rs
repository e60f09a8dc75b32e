//! The chute of the project: what must be true of a steady flow whatever the grains do, by the fields of `mercury-cg`.

use std::fmt::Write;
use std::path::Path;

use anyhow::{Context, Result};
use mercury_cg::CgError;
use mercury_cg::analysis::{Block, TimeMode};
use mercury_cg::coordinates::Coordinates;
use mercury_cg::input::{FrameChoice, Given};
use mercury_cg::options::Cells;
use mercury_cg::setup::Wanted;
use mercury_cg::state::State;
use mercury_pictures::charts::{Axis, Chart, ChartPage, Dash, Hue, Series};

use super::runs::{Run, finished_at};
use super::{Reported, outcome};
use crate::cases::Outcome;

/// Gravity of the scene along the slope and into it, m/s^2: 9.81 at 24 degrees.
const GRAVITY: [f64; 2] = [3.990086, 8.961881];
/// From when on the flow is steady, s.
const STEADY: f64 = 2.0;
/// Where the flow is dense.
const DENSE: f64 = 0.3;

/// Mean fields at one height.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Row {
    /// m
    z: f64,
    volume_fraction: f64,
    /// Down the slope, m/s.
    velocity: f64,
    /// Normal to the slope, Pa.
    normal: f64,
    /// Standard error of it.
    normal_error: f64,
    /// Along the slope, Pa.
    shear: f64,
    /// Weight of the layers above, into the slope, Pa.
    weight: f64,
}

/// Results of the run.
#[derive(Debug, Clone, PartialEq)]
struct Profiles {
    rows: Vec<Row>,
    frames: usize,
    particles: u64,
}

/// Runs the scene into a folder below `runs`, or takes the finished run that is there.
pub(super) fn tell(runs: &Path) -> Result<Reported> {
    // The stress of the whole layer trembles by a seventh from one moment to the next, and forgets it within some milliseconds.
    let overrides = ["output.interval=0.005", "output.data=false"].map(str::to_owned);
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/chute.toml");
    let run = finished_at(&scene, "chute", &overrides, runs)?;
    let block = fields(&run)?;
    let profiles = Profiles {
        frames: block.frames,
        particles: run.particles,
        rows: rows(&block)?,
    };
    Ok(Reported {
        checks: checks(&profiles.rows)?,
        text: profiles.text(),
        pictures: vec![("chute-profiles.svg", profiles.chart())],
    })
}

/// Means over the steady time at 80 heights: `mercury-cg chute --coordinates Z --grid 80 --from 2 --average time`.
fn fields(run: &Run) -> Result<Block> {
    let names = [
        "volume_fraction",
        "density",
        "velocity",
        "stress",
        "boundary_force",
    ];
    let wanted = Wanted {
        fields: names.map(str::to_owned).to_vec(),
        coordinates: Some(Coordinates::Cartesian([false, false, true])),
        grid: Some(Cells(vec![80])),
        time: Some(TimeMode::Average),
        errors: true,
        ..Wanted::default()
    };
    let (source, fields) = wanted.open(&run.file("particles.arrow"), &Given::default())?;
    let steady =
        |state: &Result<State, CgError>| state.as_ref().map_or(true, |state| state.time >= STEADY);
    let states = || source.states(FrameChoice::All).filter(steady);
    let first = states().next().context("the run has no frames")??;
    let analysis = wanted.analysis(source.materials(), &first, fields)?;
    let mut found = None;
    let (_, damage) = analysis.run(states(), |block| {
        found = Some(block);
        Ok(())
    })?;
    if let Some(damage) = damage {
        return Err(damage.into());
    }
    found.context("no frame is of the steady time")
}

/// Profiles, and the weight of what is above the middle of each cell.
fn rows(block: &Block) -> Result<Vec<Row>> {
    let column = |name: &str| {
        let found = block.columns.iter().find(|column| column.name == name);
        found.with_context(|| format!("no column {name}"))
    };
    let values = |name: &str| Ok::<_, anyhow::Error>(&column(name)?.values);
    let (fraction, density) = (values("volume_fraction")?, values("density")?);
    let (velocity, shear) = (values("velocity_x")?, values("stress_xz")?);
    let normal = column("stress_zz")?;
    let errors = normal.errors.as_ref().context("no standard errors")?;
    let held = values("boundary_force_z")?;
    let cell = (block.space.max.z - block.space.min.z) / density.len() as f64;
    let mut above = 0.0;
    let mut rows: Vec<Row> = (0..density.len())
        .rev()
        .map(|k| {
            // The weight that the fixed grains of the bottom hold does not rest on the grains below.
            let own = (density[k] * GRAVITY[1] - held[k]) * cell;
            let weight = above + 0.5 * own;
            above += own;
            Row {
                z: block.space.min.z + (k as f64 + 0.5) * cell,
                volume_fraction: fraction[k],
                velocity: velocity[k],
                normal: normal.values[k],
                normal_error: errors[k],
                // Of the upper on the lower, down the slope.
                shear: -shear[k],
                weight,
            }
        })
        .collect();
    rows.reverse();
    Ok(rows)
}

fn dense(rows: &[Row]) -> impl Iterator<Item = &Row> {
    rows.iter().filter(|row| row.volume_fraction > DENSE)
}

fn checks(rows: &[Row]) -> Result<Vec<Outcome>> {
    let slope = GRAVITY[0] / GRAVITY[1];
    let ratios = || dense(rows).map(|row| row.shear / row.normal);
    let base = dense(rows).next().context("nothing is dense")?;
    let pairs = rows.iter().zip(&rows[1..]);
    let inside = pairs.filter(|(low, high)| {
        low.volume_fraction > DENSE && high.volume_fraction > DENSE && high.velocity <= low.velocity
    });
    Ok(vec![
        outcome(
            "chute: smallest shear over normal stress where the volume fraction is above 0.3",
            slope,
            ratios().fold(f64::INFINITY, f64::min),
            0.03 * slope,
            "tan 24 at every height: momentum along the slope over momentum into it",
        ),
        outcome(
            "chute: largest shear over normal stress where the volume fraction is above 0.3",
            slope,
            ratios().fold(0.0, f64::max),
            0.03 * slope,
            "tan 24 at every height: momentum along the slope over momentum into it",
        ),
        outcome(
            "chute: normal stress at the base over the weight above",
            1.0,
            base.normal / base.weight,
            0.02,
            "a steady flow carries its weight",
        ),
        outcome(
            "chute: heights at which the velocity does not grow",
            0.0,
            inside.count() as f64,
            0.0,
            "shear at every height, as in Bagnold's profile",
        ),
    ])
}

impl Profiles {
    fn text(&self) -> String {
        let mut page = String::new();
        let _ = writeln!(
            page,
            "\n`scenes/chute.toml` with `--set output.interval=0.005 --set output.data=false`: {} grains, 200 of them fixed, flow down 24 degrees. Means over {} frames from 2 to 3 s, Gaussian of one mean diameter (1 mm). The weight is that of what is above, less what the fixed \
             grains hold; errors are standard errors of the mean by batches. The same by hand: [from a chute to a stress profile](how-to/from-a-chute-to-a-stress-profile.md).\n\n\
             | height (mm) | volume fraction | velocity (m/s) | normal stress (Pa) | weight above (Pa) | normal / weight | shear / normal |\n|---|---|---|---|---|---|---|",
            self.particles, self.frames
        );
        for row in dense(&self.rows).step_by(3) {
            let _ = writeln!(
                page,
                "| {:.2} | {:.4} | {:.4} | {:.2} ± {:.2} | {:.2} | {:.4} | {:.4} |",
                1e3 * row.z,
                row.volume_fraction,
                row.velocity,
                row.normal,
                row.normal_error,
                row.weight,
                row.normal / row.weight,
                row.shear / row.normal
            );
        }
        page.push_str(
            "\nBagnold's profile of a layer of height H is u(z) = u(0) + U (1 - (1 - z/H)^(3/2)); the grey line in the picture is the one through the lowest and the highest of these heights, with H where the volume \
             fraction falls below 0.3. Grains at the rough bottom and at the surface are not in it.\n\n\
             ![Volume fraction, velocity, stresses and their ratio over the height](pictures/chute-profiles.svg)\n",
        );
        page
    }

    fn chart(&self) -> ChartPage {
        let rows = || self.rows.iter().filter(|row| row.volume_fraction > 0.01);
        let line = |value: fn(&Row) -> f64| rows().map(|row| (row.z, value(row))).collect();
        let height = || Axis::linear("height", "m");
        let chart = |title, unit| Chart::new(title, height(), Axis::linear(title, unit));
        let edge = |sign: f64| -> Vec<(f64, f64)> {
            rows()
                .map(|row| (row.z, row.normal + sign * 2.0 * row.normal_error))
                .collect()
        };
        let inside: Vec<&Row> = dense(&self.rows).collect();
        let bagnold: Vec<(f64, f64)> = match (inside.first(), inside.last()) {
            (Some(low), Some(high)) => {
                let share = |z: f64| {
                    let rest = ((high.z - z) / (high.z - low.z)).clamp(0.0, 1.0);
                    1.0 - rest * rest.sqrt()
                };
                let velocity = |z: f64| low.velocity + (high.velocity - low.velocity) * share(z);
                inside.iter().map(|row| (row.z, velocity(row.z))).collect()
            }
            _ => Vec::new(),
        };
        let ratio: Vec<(f64, f64)> = inside
            .iter()
            .map(|row| (row.z, row.shear / row.normal))
            .collect();
        let slope: Vec<(f64, f64)> = inside
            .iter()
            .map(|row| (row.z, GRAVITY[0] / GRAVITY[1]))
            .collect();
        let charts = vec![
            chart("volume fraction", "").with(Series::line("", line(|row| row.volume_fraction))),
            chart("velocity", "m/s")
                .with(Series::line("down the slope", line(|row| row.velocity)))
                .with(
                    Series::line("Bagnold", bagnold)
                        .hue(Hue::Grey)
                        .dash(Dash::Dashed),
                ),
            chart("stress", "Pa")
                .with(Series::band("", edge(-1.0), edge(1.0)))
                .with(Series::line("normal", line(|row| row.normal)))
                .with(Series::line("shear", line(|row| row.shear)))
                .with(
                    Series::line("weight above", line(|row| row.weight))
                        .hue(Hue::Grey)
                        .dash(Dash::Dashed),
                ),
            chart("shear over normal stress", "")
                .with(Series::line("measured", ratio))
                .with(
                    Series::line("tan 24", slope)
                        .hue(Hue::Grey)
                        .dash(Dash::Dashed),
                ),
        ];
        ChartPage::new("", 2, charts)
    }
}
