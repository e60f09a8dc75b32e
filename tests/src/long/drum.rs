//! Two sizes of spheres in a turning drum: how many of each are in each quarter.

use std::fmt::Write;
use std::path::Path;

use anyhow::{Result, ensure};
use glam::DVec3;
use mercury_common::formats::ene::EnergyReader;
use mercury_common::frames::ParticleReader;
use mercury_pictures::charts::{Axis, Chart, ChartPage, Series};

use super::runs::{Run, finished};
use super::{Reported, outcome};
use crate::cases::Outcome;

/// Particles of each material in the scene.
const THERE: [u64; 2] = [30_000, 8_000];
/// From when on the flow is steady, s: two thirds of a turn.
const STEADY: f64 = 2.0;

/// The quarters by the signs of x and z, in the order of the page. The drum turns so that its +x side rises.
pub(super) const QUARTERS: [&str; 4] = ["+x +z", "-x +z", "-x -z", "+x -z"];

/// Number of spheres of one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Counts {
    /// s.
    pub(super) time: f64,
    /// Numbers by quarter ([`QUARTERS`]) and material (small, large).
    pub(super) number: [[u64; 2]; 4],
}

impl Counts {
    /// Number of one material in all quarters.
    fn total(&self, material: usize) -> u64 {
        self.number.iter().map(|quarter| quarter[material]).sum()
    }

    /// Share of the large ones in the number of a quarter; none in an empty one.
    pub(super) fn share(&self, quarter: usize) -> Option<f64> {
        let [small, large] = self.number[quarter];
        (small + large > 0).then(|| large as f64 / (small + large) as f64)
    }
}

/// Results of the run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Found {
    pub(super) checks: Vec<Outcome>,
    /// Particles and steps.
    pub(super) size: (u64, u64),
    /// One row for each frame.
    pub(super) counts: Vec<Counts>,
}

/// The place in [`QUARTERS`].
fn quarter(position: DVec3) -> usize {
    match (position.x >= 0.0, position.z >= 0.0) {
        (true, true) => 0,
        (false, true) => 1,
        (false, false) => 2,
        (true, false) => 3,
    }
}

/// Reads the run and counts.
pub(super) fn evaluate(run: &Run) -> Result<Found> {
    let reader = ParticleReader::open(run.file("particles.arrow"))?;
    let mut counts = Vec::new();
    for frame in reader.iter() {
        let frame = frame?;
        let mut number = [[0; 2]; 4];
        for (&material, position) in frame.material.iter().zip(&frame.position) {
            // The scene names m1 and m2 first, and only they have particles.
            ensure!(material < 2, "a particle of material {material}");
            number[quarter(*position)][material as usize] += 1;
        }
        counts.push(Counts {
            time: frame.time,
            number,
        });
    }
    let lost = counts
        .iter()
        .flat_map(|row| [0, 1].map(|k| THERE[k].abs_diff(row.total(k))))
        .max();
    Ok(Found {
        checks: vec![
            outcome(
                "drum-soft: frames",
                51.0,
                counts.len() as f64,
                0.0,
                "one each 0.1 s",
            ),
            outcome(
                "drum-soft: spheres of a size that are missing in a frame",
                0.0,
                lost.map_or(f64::NAN, |lost| lost as f64),
                0.0,
                "nothing leaves the drum",
            ),
            outcome(
                "drum-soft: mean torque of the drum from 2 s on over the moment of the content's weight",
                1.0,
                balance(run)?,
                // 31 looks at a torque that scatters by about a tenth.
                0.1,
                "balance of angular momentum about the axis in the steady state",
            ),
        ],
        size: (run.particles, run.steps),
        counts,
    })
}

/// Mean torque of the drum about its axis over the mean moment of the weight of what is in it.
fn balance(run: &Run) -> Result<f64> {
    let torques = run.table("walls.csv", ["time", "ty"])?;
    let steady = torques.iter().filter(|row| row[0] >= STEADY - 1e-9);
    let torque = mean(steady.map(|row| row[1]));
    let mut moments = Vec::new();
    for row in EnergyReader::open(run.file("ene"))? {
        let row = row?;
        if row.time >= STEADY - 1e-9 && row.center_of_mass.z != 0.0 {
            // M g = -(gravitational energy)/z; the moment of (0, 0, -M g) at (x, ., z) about the axis is M g x.
            let weight = row.gravitational / row.center_of_mass.z;
            moments.push(weight * row.center_of_mass.x);
        }
    }
    // The torque of the drum on its content and that of the content on the drum are opposite.
    Ok(torque / mean(moments.into_iter()))
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0u32);
    for value in values {
        sum += value;
        count += 1;
    }
    sum / f64::from(count)
}

impl Found {
    fn text(&self) -> String {
        let mut page = String::new();
        let found = self;
        let (particles, steps) = found.size;
        let _ = write!(
            page,
            "\n`drum-soft`: {particles} particles, {steps} steps. 30,000 small (1 mm, m1) and 8,000 large spheres (2 mm, m2) in \
             a drum of 0.1 m radius that turns at 2 rad/s about y, \
             its +x side upwards: 1.6 turns. The soft variant of the benchmark. Numbers of small + large spheres in each \
             quarter, by the signs of x and z; the benchmark uses two opposite ones, \
             here +x +z (where the content is carried up) and -x -z (where it comes down):\n\n| t (s) |"
        );
        for name in QUARTERS {
            let _ = write!(page, " {name} |");
        }
        page.push_str("\n|---|---|---|---|---|\n");
        for row in found.counts.iter().step_by(5) {
            let _ = write!(page, "| {:.1} |", row.time);
            for [small, large] in row.number {
                let _ = write!(page, " {small} + {large} |");
            }
            page.push('\n');
        }
        page.push_str("\n![Share of large spheres in the number of each quarter over time](pictures/drum-quarters.svg)\n");
        if let (Some(first), Some(last)) = (found.counts.first(), found.counts.last()) {
            let share = |share: Option<f64>| share.map_or("none".to_owned(), |s| format!("{s:.3}"));
            page.push_str(
                "\nShare of large spheres, at the start and at the end (8/38 = 0.211 in all):",
            );
            for (k, name) in QUARTERS.iter().enumerate() {
                let _ = write!(
                    page,
                    "{} {name}: {}, {}",
                    if k == 0 { "" } else { ";" },
                    share(first.share(k)),
                    share(last.share(k))
                );
            }
            page.push_str(".\n");
        }
        page
    }

    fn chart(&self) -> ChartPage {
        let mut drum = Chart::new(
            "Large spheres over all spheres of a quarter (from 200 spheres on)",
            Axis::linear("time", "s"),
            Axis::linear("share", ""),
        );
        for (k, name) in QUARTERS.iter().enumerate() {
            let shares = (self.counts.iter())
                // A few spheres that fly through make no share.
                .filter(|row| row.number[k][0] + row.number[k][1] >= 200)
                .filter_map(|row| Some((row.time, row.share(k)?)));
            drum = drum.with(Series::line(name, shares.collect()));
        }
        ChartPage::of(drum)
    }
}

/// Runs the scene.
pub(super) fn tell(runs: &Path) -> Result<Reported> {
    let found = evaluate(&finished("drum-soft", "drum-soft", &[], runs)?)?;
    Ok(Reported {
        text: found.text(),
        pictures: vec![("drum-quarters.svg", found.chart())],
        checks: found.checks,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_belongs_to_the_quarter_of_its_signs() {
        for (x, z, name) in [
            (0.1, 0.2, "+x +z"),
            (-0.1, 0.2, "-x +z"),
            (-0.1, -0.2, "-x -z"),
            (0.1, -0.2, "+x -z"),
        ] {
            assert_eq!(QUARTERS[quarter(DVec3::new(x, 5.0, z))], name);
        }
    }

    #[test]
    fn an_empty_quarter_has_no_share() {
        let counts = Counts {
            time: 0.0,
            number: [[0, 0], [3, 1], [0, 2], [1, 0]],
        };
        assert_eq!(
            [0, 1, 2, 3].map(|k| counts.share(k)),
            [None, Some(0.25), Some(1.0), Some(0.0)]
        );
        assert_eq!([counts.total(0), counts.total(1)], [4, 3]);
    }
}
