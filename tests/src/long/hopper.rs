//! A hopper that is filled with two materials of measured sizes and discharges: the sizes that came, and the flow.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result};
use mercury_common::frames::ParticleReader;
use mercury_pictures::charts::{Axis, Chart, ChartPage, Dash, Series};

use super::runs::{Run, finished_at};
use super::{Reported, outcome};
use crate::cases::Outcome;

/// Diameter of the outlet, m.
const OUTLET: f64 = 0.032;
/// Half angle of the cone: its radius grows by 44 mm in 60 mm.
const RISE: f64 = 0.06;
const RUN: f64 = 0.044;
/// When the gate opens, s.
const OPENS: f64 = 1.0;
/// kg/m3, m
const MATERIALS: [(&str, f64); 2] = [("grain", 1400.0), ("sand", 2600.0)];
/// The cylinder above the outlet in which the bulk density is taken before it opens: radius, lower and upper end, m. It lies in the
/// cone, three grains from its wall.
const CORE: [f64; 3] = [0.018, 0.02, 0.045];

/// Results of the run.
#[derive(Debug, Clone, PartialEq)]
struct Hopper {
    checks: Vec<Outcome>,
    size: (u64, u64),
    /// Discharge of the two materials: time (s), and mass that has passed (kg).
    passed: [Vec<[f64; 2]>; 2],
    /// Time, and D[3,2] of what passed since the row before, m; both materials.
    sizes: Vec<[f64; 2]>,
    rate: f64,
    steady: [f64; 2],
    law: Law,
    insertion: Vec<String>,
}

/// Beverloo's law and what goes into it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Law {
    bulk_density: f64,
    diameter: f64,
    flat: f64,
    conical: f64,
}

/// Runs the scene into a folder below `runs`, or takes the finished run that is there.
pub(super) fn tell(runs: &Path) -> Result<Reported> {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/hopper-psd.toml");
    let hopper = evaluate(&finished_at(&scene, "hopper-psd", &[], runs)?)?;
    Ok(Reported {
        text: hopper.text(),
        pictures: vec![("hopper-discharge.svg", hopper.chart())],
        checks: hopper.checks,
    })
}

fn evaluate(run: &Run) -> Result<Hopper> {
    let path = run.file("flux.csv");
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let mut passed = [vec![[0.0; 2]], vec![[0.0; 2]]];
    let mut sizes: Vec<[f64; 2]> = Vec::new();
    let mut volumes = 0.0;
    let mut surfaces = 0.0;
    for (material, (name, _)) in MATERIALS.iter().enumerate() {
        // Columns of the rows of one material.
        let mut rows =
            String::from("time,name,material,forward,backward,mass,volume,px,py,pz,d10,d32,d43\n");
        for line in text
            .lines()
            .filter(|line| line.split(',').nth(2) == Some(name))
        {
            rows.push_str(&line.replace(&format!("discharge,{name}"), "0,0"));
            rows.push('\n');
        }
        let mut sum = 0.0;
        for (k, [time, mass, volume, d32]) in
            super::runs::numbers(&rows, ["time", "mass", "volume", "d32"])?
                .into_iter()
                .enumerate()
        {
            sum += mass;
            passed[material].push([time, sum]);
            // 6 V / D[3,2] is a surface: the mean over both materials.
            let surface = if d32 > 0.0 { volume / d32 } else { 0.0 };
            volumes += volume;
            surfaces += surface;
            if material == 0 {
                sizes.push([volume, surface]);
            } else if let Some(both) = sizes.get_mut(k) {
                both[0] += volume;
                both[1] += surface;
            }
        }
    }
    let times: Vec<f64> = passed[0].iter().skip(1).map(|row| row[0]).collect();
    let sizes = (times.iter().zip(&sizes))
        .filter(|(_, [_, surface])| *surface > 0.0)
        .map(|(&time, [volume, surface])| [time, volume / surface])
        .collect();
    let total: Vec<[f64; 2]> = (passed[0].iter().zip(&passed[1]))
        .map(|(a, b)| [a[0], a[1] + b[1]])
        .collect();
    let (rate, steady) = slope(&total).context("nothing was discharged")?;
    let (bulk_density, solids) = core(run)?;
    let diameter = volumes / surfaces;
    // Beverloo, Leniger and van de Velde 1961, Chem. Eng. Sci. 15, 260; cones: Rose and Tanaka 1959 as Nedderman 1992, 10.4, gives it, with 45
    // degrees for the angle of the stagnant zone.
    let flat = 0.58 * bulk_density * 9.81_f64.sqrt() * (OUTLET - 1.4 * diameter).powf(2.5);
    let conical = flat * (RUN / RISE).powf(-0.35);
    let log = std::fs::read_to_string(run.folder().join("run.log"))?;
    let insertion: Vec<String> = (log.lines())
        .filter_map(|line| line.trim().strip_prefix("insertion"))
        .map(|line| line.trim().to_owned())
        .collect();
    let is_passed = |name: &&(&str, f64)| {
        let start = format!("sizes of {}:", name.0);
        insertion
            .iter()
            .any(|line| line.starts_with(&start) && line.contains("PASSED"))
    };
    let good = MATERIALS.iter().filter(is_passed).count();
    let checks = vec![
        outcome(
            "hopper-psd: materials whose sizes pass the check",
            2.0,
            good as f64,
            0.0,
            "what the report at the end says",
        ),
        outcome(
            "hopper-psd: mass that passed the plane less what came and is not above it at the end (kg)",
            0.0,
            total.last().map_or(f64::NAN, |row| row[1]) - below(run)?,
            // Sums of some thousand terms.
            1e-12,
            "nothing is lost: what was inserted is above the plane or passed it",
        ),
        outcome(
            "hopper-psd: bulk density above the outlet over that of a dense packing",
            1.0,
            solids / 0.6,
            0.1,
            "poured spheres fill 0.56 to 0.64 of the space; some 150 centres",
        ),
        outcome(
            "hopper-psd: rate of discharge (kg/s)",
            conical,
            rate,
            0.25 * conical,
            "Beverloo et al. 1961 with the cone of Rose and Tanaka 1959; C from 0.55 to 0.65, k from 1.2 to 2 (Nedderman 1992)",
        ),
    ];
    Ok(Hopper {
        checks,
        size: (run.particles, run.steps),
        passed,
        sizes,
        rate,
        steady,
        law: Law {
            bulk_density,
            diameter,
            flat,
            conical,
        },
        insertion,
    })
}

/// Slope (kg/s) between the times when a fifth and seven tenths had passed, and these times; by least squares.
fn slope(total: &[[f64; 2]]) -> Option<(f64, [f64; 2])> {
    let all = total.last()?[1];
    let part: Vec<&[f64; 2]> = (total.iter())
        .filter(|row| row[1] > 0.2 * all && row[1] < 0.7 * all)
        .collect();
    let (first, last) = (part.first()?[0], part.last()?[0]);
    let n = part.len() as f64;
    let mean = |k: usize| part.iter().map(|row| row[k]).sum::<f64>() / n;
    let (t, m) = (mean(0), mean(1));
    let above: f64 = part.iter().map(|row| (row[0] - t) * (row[1] - m)).sum();
    let below: f64 = part.iter().map(|row| (row[0] - t).powi(2)).sum();
    (below > 0.0).then(|| (above / below, [first, last]))
}

/// Bulk density (kg/m3) and solid fraction in the core just before the gate opens, by the centres in it.
fn core(run: &Run) -> Result<(f64, f64)> {
    let reader = ParticleReader::open(run.file("particles.arrow"))?;
    let mut found = None;
    for frame in reader.iter() {
        let frame = frame?;
        if frame.time > OPENS - 1e-9 {
            break;
        }
        let (mut mass, mut solid) = (0.0, 0.0);
        let each = frame
            .position
            .iter()
            .zip(&frame.radius)
            .zip(&frame.material);
        for ((position, radius), &material) in each {
            let is_inside =
                position.truncate().length() < CORE[0] && (CORE[1]..CORE[2]).contains(&position.z);
            if is_inside {
                let volume = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
                solid += volume;
                mass += MATERIALS[material as usize].1 * volume;
            }
        }
        let space = std::f64::consts::PI * CORE[0] * CORE[0] * (CORE[2] - CORE[1]);
        found = Some((mass / space, solid / space));
    }
    found.context("no frame before the gate opens")
}

/// Mass (kg) that is below the plane or gone at the end: what was inserted less what is above it.
fn below(run: &Run) -> Result<f64> {
    let frames = ParticleReader::open(run.file("particles.arrow"))?;
    let (mut most, mut left) = (0.0f64, 0.0);
    for frame in frames.iter() {
        let frame = frame?;
        let (mut all, mut above) = (0.0, 0.0);
        for ((position, radius), &material) in frame
            .position
            .iter()
            .zip(&frame.radius)
            .zip(&frame.material)
        {
            let mass =
                MATERIALS[material as usize].1 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
            all += mass;
            above += if position.z > -0.01 { mass } else { 0.0 };
        }
        // All is there before the gate opens.
        most = most.max(all);
        left = above;
    }
    Ok(most - left)
}

impl Hopper {
    fn text(&self) -> String {
        let Law {
            bulk_density,
            diameter,
            flat,
            conical,
        } = self.law;
        let [from, to] = self.steady;
        let mut page = String::new();
        let _ = writeln!(
            page,
            "\n`scenes/hopper-psd.toml` as it stands. Grain by a sieve analysis and sand by a lognormal law, by quota, 0.25 kg in all. The report at the end of the run ({} steps):\n\n```text\n{}\n```\n\n\
             ![Mass that has passed the plane below the outlet, and the mean diameter of what passes](pictures/hopper-discharge.svg)\n\n\
             Between {from:.2} and {to:.2} s, while a fifth to seven tenths of the mass pass, the rate is **{:.4} kg/s**. Beverloo's law (1961), W = C ρ √g (D - k d)^2.5 with C = 0.58 and k = 1.4, says {flat:.4} kg/s for a flat \
             bottom, with the bulk density {bulk_density:.0} kg/m³ before the gate opened and d = D[3,2] = {:.3} mm of what flowed out; times (tan θ tan φ)^-0.35 for a cone (Rose and Tanaka 1959), with tan θ = {RUN}/{RISE} and φ = 45°, **{conical:.4} kg/s**. \
             Ours is {:+.1} % off. The law has C between 0.55 and 0.65 and k between 1.2 and 2 for different materials (Nedderman 1992), some 25 % together.",
            self.size.1,
            self.insertion.join("\n"),
            self.rate,
            1e3 * diameter,
            100.0 * (self.rate / conical - 1.0)
        );
        page
    }

    fn chart(&self) -> ChartPage {
        let pairs = |rows: &[[f64; 2]]| rows.iter().map(|row| (row[0], row[1])).collect::<Vec<_>>();
        let mut mass = Chart::new(
            "Mass that has passed the plane below the outlet",
            Axis::linear("time", "s"),
            Axis::linear("mass", "kg"),
        );
        for ((name, _), rows) in MATERIALS.iter().zip(&self.passed) {
            mass = mass.with(Series::line(name, pairs(rows)));
        }
        let [from, to] = self.steady;
        let both = |time: f64| {
            let at = |rows: &Vec<[f64; 2]>| {
                let row = rows.iter().find(|row| row[0] >= time - 1e-9);
                row.map_or(0.0, |row| row[1])
            };
            self.passed.iter().map(at).sum::<f64>()
        };
        let start = both(from);
        let line = vec![(from, start), (to, start + self.law.conical * (to - from))];
        mass = mass
            .with(Series::line("both", {
                let rows = self.passed[0].iter().zip(&self.passed[1]);
                rows.map(|(a, b)| (a[0], a[1] + b[1])).collect()
            }))
            .with(Series::line("Beverloo, cone", line).dash(Dash::Dashed));
        let sizes = Chart::new(
            "Mean diameter D[3,2] of what passes in 0.02 s",
            Axis::linear("time", "s"),
            Axis::linear("diameter", "m"),
        )
        .with(Series::line("both materials", pairs(&self.sizes)));
        ChartPage::new("", 1, vec![mass, sizes])
    }
}
