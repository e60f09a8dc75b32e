//! A steel sphere is shot into a bed of 25,000 spheres.

use std::fmt::Write;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use mercury_pictures::charts::{Axis, Chart, ChartPage, Series};

use super::runs::{Run, finished, numbers};
use super::{Reported, outcome};
use crate::cases::Outcome;

/// Height of the intruder by LIGGGHTS; the file describes how it was made.
const LIGGGHTS: &str = include_str!("penetration-25k.liggghts.csv");
/// End of the run, s: after the impact at 0.0207 s, the dive, and the rebound from the floor. The scene's is 0.1 s.
pub(super) const END: f64 = 0.045;
/// End of the comparison of heights, s: the floor is met. The intruder bounces back from a handful of beads crushed between it
/// and the floor: from there on the path is chaotic (see the page).
const COMPARED: f64 = 0.03;

/// Shots from just above the bed, with the sphere shifted sideways by so much along x and y (m): what differs by less than any bed of beads can
/// be built.
pub(super) const SHIFTS: [[f64; 2]; 9] = [
    [0.0, 0.0],
    [1e-6, 0.0],
    [-1e-6, 0.0],
    [0.0, 1e-6],
    [0.0, -1e-6],
    [1e-5, 0.0],
    [-1e-5, 0.0],
    [0.0, 1e-5],
    [0.0, -1e-5],
];
/// Heights of the shots by LIGGGHTS; the file describes how they were made.
const LIGGGHTS_SHOTS: &str = include_str!("penetration-shots.liggghts.csv");
/// When the shots begin in the scene's time, and how long they last, s: the sphere has left the floor.
pub(super) const SHOT: [f64; 2] = [0.0202, 0.014];
/// Over which time speeds are taken at the end of a shot, s.
const SPAN: f64 = 3e-3;

/// Changes of the scene that make it such a shot.
pub(super) fn shot([x, y]: [f64; 2]) -> Vec<String> {
    vec![
        // Where free fall has brought it.
        format!("particles.intruder.position=[{x:?},{y:?},-0.0430015]"),
        "particles.intruder.velocity=[0.0,0.0,-5.198162]".to_owned(),
        "materials.m1.tangential.stiffness_factor=1.0".to_owned(),
        "materials.steel.tangential.stiffness_factor=1.0".to_owned(),
        format!("time.end={}", SHOT[1]),
    ]
}

/// The end of a shot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Flight {
    /// m.
    pub(super) height: f64,
    /// m/s.
    pub(super) speed: f64,
}

impl Flight {
    fn of(rows: &[[f64; 2]]) -> Result<Self> {
        let [early, late] = [SHOT[1] - SPAN, SHOT[1]].map(|time| at(rows, time));
        let (early, late) = early.zip(late).context("a shot is short")?;
        // In free flight this is the speed in the middle.
        Ok(Self {
            height: late,
            speed: (late - early) / SPAN - 0.5 * 9.81 * SPAN,
        })
    }

    /// Height after some more free flight, m.
    pub(super) fn after(self, time: f64) -> f64 {
        self.height + self.speed * time - 0.5 * 9.81 * time * time
    }
}

/// Mean and standard deviation.
pub(super) fn spread(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    let squares: f64 = values.map(|x| (x - mean).powi(2)).sum();
    [mean, (squares / (count - 1.0)).sqrt()]
}

/// Results of the run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Found {
    pub(super) checks: Vec<Outcome>,
    /// Particles and steps.
    pub(super) size: (u64, u64),
    /// Time (s) and height (m) of the intruder in our run.
    pub(super) ours: Vec<[f64; 2]>,
    /// Time (s) and height (m) of the intruder by LIGGGHTS.
    pub(super) theirs: Vec<[f64; 2]>,
    /// Our ends of the shots and those of LIGGGHTS, in the order of [`SHIFTS`].
    pub(super) shots: Vec<[Flight; 2]>,
}

/// Both codes' ends of the shots.
fn flights(shots: &[Run]) -> Result<Vec<[Flight; 2]>> {
    let theirs = numbers(LIGGGHTS_SHOTS, ["x_m", "y_m", "time_s", "height_m"])?;
    let pairs = SHIFTS.iter().zip(shots);
    pairs
        .map(|(shift, run)| {
            let rows = theirs.iter().filter(|row| row[..2] == shift[..]);
            let rows: Vec<[f64; 2]> = rows.map(|row| [row[2], row[3]]).collect();
            let ours = Flight::of(&run.table("track.csv", ["time", "z"])?)?;
            Ok([ours, Flight::of(&rows)?])
        })
        .collect()
}

/// Reads the runs and compares.
pub(super) fn evaluate(run: &Run, shots: &[Run]) -> Result<Found> {
    let ours = run.table("track.csv", ["time", "z"])?;
    let theirs = numbers(LIGGGHTS, ["time_s", "height_m"])?;
    let mut worst = 0.0f64;
    for &[time, height] in theirs.iter().filter(|row| row[0] < COMPARED + 1e-9) {
        let here = at(&ours, time).context("the run has no such time")?;
        worst = worst.max((here - height).abs());
    }
    ensure!(at(&theirs, END).is_some(), "LIGGGHTS' table is short");
    let rebound = |rows: &[[f64; 2]]| {
        let [early, late] = [0.04, END].map(|time| at(rows, time));
        // The speed in the middle of a flight.
        Some((late? - early?) / (END - 0.04))
    };
    let rebound = |rows| rebound(rows).context("a table is short");
    let (back, back_there) = (rebound(&ours)?, rebound(&theirs)?);
    let free = at(&ours, 0.02).context("the run is short")?;
    let shots = flights(shots)?;
    let [height, height_there] =
        [0, 1].map(|code| spread(shots.iter().map(move |shot| 1e3 * shot[code].height)));
    let [speed, speed_there] =
        [0, 1].map(|code| spread(shots.iter().map(move |shot| shot[code].speed)));
    Ok(Found {
        checks: vec![
            outcome(
                "penetration-25k: height of the intruder just before the impact (m)",
                // 0.06 - 5 t - g t^2/2 at 0.02 s.
                0.06 - 5.0 * 0.02 - 0.5 * 9.81 * 0.02 * 0.02,
                free,
                1e-9,
                "free fall",
            ),
            outcome(
                "penetration-25k: height of the intruder until it meets the floor at 0.03 s, largest difference (mm)",
                0.0,
                1e3 * worst,
                1.0,
                "LIGGGHTS 3.8, same particles, mesh, law and step (`benches/penetration.py`)",
            ),
            outcome(
                "penetration-25k: speed of the intruder at 0.0425 s, thrown back by the floor (m/s)",
                back_there,
                back,
                // Shifts of the start by 1e-9 and 1e-6 m give 1.74 to 2.17 m/s: half of that range.
                0.2,
                "LIGGGHTS 3.8; the scatter of a chaotic rebound",
            ),
            outcome(
                "penetration-25k: nine shots, mean height after the rebound, at 0.0342 s (mm)",
                height_there[0],
                height[0],
                1.0,
                "LIGGGHTS 3.8, the same nine shots, the same law (`benches/penetration.py --shots`)",
            ),
            outcome(
                "penetration-25k: nine shots, mean speed after the rebound (m/s)",
                speed_there[0],
                speed[0],
                // Three standard errors of the difference of two means, if both codes scatter as LIGGGHTS does.
                3.0 * speed_there[1] * (2.0 / SHIFTS.len() as f64).sqrt(),
                "LIGGGHTS 3.8, the same nine shots; three standard errors",
            ),
        ],
        size: (run.particles, run.steps),
        ours,
        theirs,
        shots,
    })
}

/// The height at a time (s).
pub(super) fn at(rows: &[[f64; 2]], time: f64) -> Option<f64> {
    let row = rows.iter().find(|row| (row[0] - time).abs() < 1e-7)?;
    Some(row[1])
}

impl Found {
    /// Time (s) and height (m) of the lowest point that was written.
    pub(super) fn lowest(&self) -> [f64; 2] {
        let rows = self.ours.iter().copied();
        rows.min_by(|a, b| a[1].total_cmp(&b[1]))
            .unwrap_or([f64::NAN; 2])
    }

    /// Time (s) and height (m) at the end.
    pub(super) fn last(&self) -> [f64; 2] {
        self.ours.last().copied().unwrap_or([f64::NAN; 2])
    }
}

impl Found {
    fn text(&self) -> String {
        let mut page = String::new();
        let found = self;
        let (particles, steps) = found.size;
        let [low_time, low] = found.lowest();
        let [end, last] = found.last();
        let _ = write!(
            page,
            "\n`penetration-25k` to 0.045 s of its 0.1 s (then the intruder flies): {particles} particles, {steps} steps. A steel sphere of 10 mm radius hits a bed \
             of 25,000 spheres of 1 mm radius at 5.2 m/s, goes through it to the floor and is thrown back. Gravity 9.81 m/s², stiffness factor 2/3, damping √(2/3) β_n while sticking.\n\n\
             Height of its centre by both codes:\n\n| t (ms) | Mercury (mm) | LIGGGHTS (mm) | difference (mm) |\n|---|---|---|---|\n"
        );
        for &[time, theirs] in &found.theirs {
            let ms = (time * 1e3).round();
            let shown = ms >= 18.0 && (ms as u64).is_multiple_of(3);
            if let (true, Some(ours)) = (shown, at(&found.ours, time)) {
                let _ = writeln!(
                    page,
                    "| {ms} | {:.3} | {:.3} | {:+.3} |",
                    1e3 * ours,
                    1e3 * theirs,
                    1e3 * (ours - theirs)
                );
            }
        }
        let _ = writeln!(
            page,
            "\nLowest height written: {:.2} mm at {:.0} ms (at -80.24 mm it would touch the floor). At the end, {:.0} ms: {:.2} mm.\n\n\
             The dive is the same to a quarter of a millimetre. What throws the intruder back are the few beads that it crushes against the floor, and how they lie decides the speed of the rebound: no code can \
             repeat that of another one (shots below that differ by a thousandth of a bead's radius scatter by more). So a single path says nothing from the floor on.\n\n\
             ![Height of the intruder over time by both codes](pictures/penetration.svg)",
            1e3 * low,
            1e3 * low_time,
            1e3 * end,
            1e3 * last
        );
        self.shots_section(&mut page);
        page
    }

    /// Means of the shots, which the scatter leaves to compare.
    fn shots_section(&self, page: &mut String) {
        let shots = &self.shots;
        let [begin, lasts] = SHOT;
        let rest = END - begin - lasts;
        let _ = write!(
            page,
            "\n### Nine shots by both codes\n\nThe same from just above the bed ({:.1} ms, -43.0015 mm, -5.198162 m/s), shifted sideways by up to 1e-5 m (a hundredth of a bead's radius), with the Mindlin factor 1 in Mercury too, so that \
             the laws are the same. Height and speed {:.1} ms after the start of the scene, when the intruder flies:\n\n\
             | shift in x, y (m) | Mercury (mm) | (m/s) | LIGGGHTS (mm) | (m/s) |\n|---|---|---|---|---|\n",
            1e3 * begin,
            1e3 * (begin + lasts)
        );
        for ([x, y], [ours, theirs]) in SHIFTS.iter().zip(shots) {
            let _ = writeln!(
                page,
                "| {x:e}, {y:e} | {:.3} | {:.3} | {:.3} | {:.3} |",
                1e3 * ours.height,
                ours.speed,
                1e3 * theirs.height,
                theirs.speed
            );
        }
        let all = |code: usize, value: fn(Flight, f64) -> f64| {
            spread(shots.iter().map(move |shot| value(shot[code], rest)))
        };
        let difference = |value: fn(Flight, f64) -> f64| {
            let [[ours, s], [theirs, t]] = [all(0, value), all(1, value)];
            [ours - theirs, ((s * s + t * t) / shots.len() as f64).sqrt()]
        };
        let heights = |code| all(code, |flight, _| 1e3 * flight.height);
        let speeds = |code| all(code, |flight, _| flight.speed);
        let row = |name: &str, k: usize| {
            format!(
                "| {name} | {:.3} | {:.3} | {:.3} | {:.3} |\n",
                heights(0)[k],
                speeds(0)[k],
                heights(1)[k],
                speeds(1)[k]
            )
        };
        page.push_str(&row("mean", 0));
        page.push_str(&row("standard deviation", 1));
        let [now, error] = difference(|flight, _| 1e3 * flight.height);
        let [later, later_error] = difference(|flight, rest| 1e3 * flight.after(rest));
        let _ = writeln!(
            page,
            "\nThe mean heights differ by {now:+.2} mm, with a standard error of {error:.2} mm; flown on freely to {:.0} ms, by {later:+.2} mm with one of {later_error:.2} mm.",
            1e3 * END
        );
    }

    fn chart(&self) -> ChartPage {
        let heights = |rows: &[[f64; 2]]| rows.iter().map(|row| (row[0], row[1])).collect();
        let penetration = Chart::new(
            "Height of the centre of the intruder",
            Axis::linear("time", "s"),
            Axis::linear("height", "m"),
        )
        .with(Series::line("Mercury", heights(&self.ours)))
        .with(Series::points("LIGGGHTS", heights(&self.theirs)));
        ChartPage::of(penetration)
    }
}

/// Runs the scene, and the shots from just above the bed.
pub(super) fn tell(runs: &Path) -> Result<Reported> {
    // Later the intruder only flies.
    let end = [format!("time.end={END}")];
    let run = finished("penetration-25k", "penetration-25k", &end, runs)?;
    let shots: Result<Vec<Run>> = SHIFTS
        .iter()
        .enumerate()
        .map(|(k, &shift)| {
            let name = format!("penetration-shot-{k}");
            finished("penetration-25k", &name, &shot(shift), runs)
        })
        .collect();
    let found = evaluate(&run, &shots?)?;
    Ok(Reported {
        text: found.text(),
        pictures: vec![("penetration.svg", found.chart())],
        checks: found.checks,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The shots begin where they do in the table of LIGGGHTS, and every one is in it.
    #[test]
    fn shots_are_those_of_the_table() {
        // Where free fall has brought the sphere.
        let [begin, _] = SHOT;
        assert!((0.06 - 5.0 * begin - 0.5 * 9.81 * begin * begin + 0.0430015).abs() < 1e-7);
        assert!((5.0 + 9.81 * begin - 5.198162).abs() < 1e-12);
        let rows = numbers(LIGGGHTS_SHOTS, ["x_m", "y_m", "time_s", "height_m"]).unwrap();
        for shift in SHIFTS {
            assert_eq!(rows.iter().filter(|row| row[..2] == shift).count(), 14);
        }
    }

    #[test]
    fn a_free_flight_goes_on() {
        let height = |t: f64| 0.02 + 2.0 * t - 0.5 * 9.81 * t * t;
        let rows: Vec<[f64; 2]> = (0..=14)
            .map(|k| f64::from(k) * 1e-3)
            .map(|t| [t, height(t)])
            .collect();
        let flight = Flight::of(&rows).unwrap();
        assert!((flight.after(0.01) - height(0.024)).abs() < 1e-12);
        assert_eq!(spread([1.0, 2.0, 3.0].into_iter()), [2.0, 1.0]);
    }
}
