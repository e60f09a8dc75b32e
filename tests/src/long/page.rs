//! The page as Markdown, and its charts.

use std::fmt::Write;
use std::path::Path;

use anyhow::Result;
use mercury_pictures::charts::{Axis, Chart, ChartPage, Series};

use super::Results;
use super::drum::QUARTERS;
use super::penetration::{END, Flight, SHIFTS, SHOT, at, spread};
use crate::validation::page::outcomes;

const HEAD: &str = "# Validation: long scenes

This page is written from runs of the open-source DEM benchmark (Dosta et al. 2024, *Comput. Phys. Commun.* 296, 109066); do not edit it. Scenes and particles are not part of the
project, so the command needs the reference data beside it:

```sh
cargo run --release -p mercury-tests --bin validation-long -- /tmp/long
```

It runs each scene as it stands (the penetration to 0.045 s only, and nine times more from just above the bed) into folders below the one named, which takes half an hour in all; a finished run of the same plan that is there already is taken as it is.
A check that is on the frozen list and no longer runs makes the command fail. Run times: [performance](performance.md#long-scenes). The other checks: [validation](validation.md).
";

impl Results {
    /// The whole page.
    #[must_use]
    pub fn page(&self) -> String {
        let mut page = String::from(HEAD);
        let failed = self.failed();
        let count = self.outcomes().count();
        let _ = writeln!(
            page,
            "\n**{} of {count} checks pass.**",
            count - failed.len()
        );
        for name in failed {
            let _ = writeln!(page, "\nFailed: {name}");
        }
        outcomes(
            &mut page,
            self.outcomes().map(|row| (row.name.as_str(), row)),
        );
        self.penetration_section(&mut page);
        self.drum_section(&mut page);
        page
    }

    fn penetration_section(&self, page: &mut String) {
        let found = &self.penetration;
        let (particles, steps) = found.size;
        let [low_time, low] = found.lowest();
        let [end, last] = found.last();
        let _ = write!(
            page,
            "\n## A sphere is shot into a bed\n\n`penetration-25k` to 0.045 s of its 0.1 s (then the intruder flies): {particles} particles, {steps} steps. A steel sphere of 10 mm radius hits a bed \
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
        self.shots_section(page);
    }

    /// What the scatter leaves to compare: means.
    fn shots_section(&self, page: &mut String) {
        let shots = &self.penetration.shots;
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

    fn drum_section(&self, page: &mut String) {
        let found = &self.drum;
        let (particles, steps) = found.size;
        let _ = write!(
            page,
            "\n## Two sizes in a drum\n\n`drum-soft`: {particles} particles, {steps} steps. 30,000 small (1 mm, m1) and 8,000 large spheres (2 mm, m2) in a drum of 0.1 m radius that turns at 2 rad/s about y, \
             its +x side upwards: 1.6 turns. The soft variant of the benchmark. Numbers of small + large spheres in each quarter, by the signs of x and z; the benchmark asks for two opposite ones, \
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
    }

    /// Draws the charts into a folder.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn draw(&self, folder: &Path) -> Result<()> {
        std::fs::create_dir_all(folder)?;
        let heights = |rows: &[[f64; 2]]| rows.iter().map(|row| (row[0], row[1])).collect();
        let penetration = Chart::new(
            "Height of the centre of the intruder",
            Axis::linear("time", "s"),
            Axis::linear("height", "m"),
        )
        .with(Series::line("Mercury", heights(&self.penetration.ours)))
        .with(Series::points(
            "LIGGGHTS",
            heights(&self.penetration.theirs),
        ));
        ChartPage::of(penetration).write_svg(&folder.join("penetration.svg"))?;
        let mut drum = Chart::new(
            "Large spheres over all spheres of a quarter (from 200 spheres on)",
            Axis::linear("time", "s"),
            Axis::linear("share", ""),
        );
        for (k, name) in QUARTERS.iter().enumerate() {
            let shares = (self.drum.counts.iter())
                // A few spheres that fly through make no share.
                .filter(|row| row.number[k][0] + row.number[k][1] >= 200)
                .filter_map(|row| Some((row.time, row.share(k)?)));
            drum = drum.with(Series::line(name, shares.collect()));
        }
        Ok(ChartPage::of(drum).write_svg(&folder.join("drum-quarters.svg"))?)
    }
}
