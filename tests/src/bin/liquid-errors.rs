//! Writes `docs/theory/liquid-errors.md` and its pictures: how far each law of liquid bridges is from the exact force, over volume, contact angle, ratio of
//! radii and gap, by the solver's own code.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Result, anyhow};
use mercury_engine::contact::adhesion::liquid::{Bridge, Fit, Liquid, Rupture, Tables};
use mercury_engine::contact::adhesion::young_laplace::Branch;
use mercury_pictures::charts::{Axis, Chart, ChartPage, Series};

const LAWS: [Fit; 4] = [
    Fit::Bagheri,
    Fit::WillettClassical,
    Fit::LianSeville,
    Fit::Willett,
];
const ANGLES: [f64; 4] = [0.0, 20.0, 40.0, 60.0];
const VOLUMES: [f64; 4] = [1e-4, 1e-3, 1e-2, 1e-1];
/// Smaller over larger radius; 0: a plane.
const RATIOS: [f64; 4] = [1.0, 0.5, 0.2, 0.0];
/// Shares of the exact end.
const SHARES: [f64; 6] = [0.0, 0.1, 0.25, 0.5, 0.75, 0.9];

fn main() -> Result<()> {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    std::fs::write(docs.join("theory/liquid-errors.md"), page()?)?;
    for fit in LAWS {
        draw(
            fit,
            &docs.join(format!("pictures/liquid-errors-{}.svg", fit.name())),
        )?;
    }
    Ok(())
}

/// A law in units of gamma R_D and R_D, and its bridge.
struct OfLaw {
    liquid: Liquid,
    bridge: Bridge,
}

impl OfLaw {
    fn new(fit: Fit, degrees: f64, volume: f64, ratio: f64) -> Self {
        let liquid = Liquid {
            fit,
            surface_tension: 1.0,
            contact_angle: degrees.to_radians(),
            max_volume: 1.0,
            rupture: if fit == Fit::Willett {
                Rupture::Lian
            } else {
                Rupture::Radii
            },
            ..Liquid::NONE
        };
        // R_D = 2/(1/R_1 + 1/R_2) = 1.
        let small = 0.5 * (1.0 + ratio);
        let radii = if ratio == 0.0 {
            [0.5, f64::INFINITY]
        } else {
            [small, small / ratio]
        };
        let bridge = liquid.fill(&Bridge::default(), volume, radii, &Tables::default());
        Self { liquid, bridge }
    }

    /// Relative error of the force at a gap; -1 beyond its end.
    fn error(&self, gap: f64, exact: f64) -> f64 {
        if gap >= self.bridge.end {
            return -1.0;
        }
        self.liquid.force_at(&self.bridge, gap) / exact - 1.0
    }

    /// The work to the end from the touch.
    fn work(&self) -> f64 {
        -self.liquid.energy_of(&self.bridge)
    }
}

/// The exact bridge.
fn branch(degrees: f64, volume: f64, ratio: f64) -> Result<Branch> {
    Ok(Branch::new(degrees.to_radians(), volume, ratio)?)
}

fn force(branch: &Branch, gap: f64) -> Result<f64> {
    let bridge = branch
        .at(gap)
        .ok_or_else(|| anyhow!("no bridge at {gap}"))?;
    Ok(bridge.force)
}

fn radii(ratio: f64) -> String {
    if ratio == 0.0 {
        "plane".to_owned()
    } else {
        format!("1:{}", 1.0 / ratio)
    }
}

/// Least and largest of some errors, in per cent.
fn span(errors: &[f64]) -> String {
    let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
    let most = errors.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    format!("{:+.1} .. {:+.1}", 100.0 * least, 100.0 * most)
}

fn page() -> Result<String> {
    let mut text = String::from(
        "# Errors of the laws of liquid bridges\n\n\
         This page is written by `cargo run --release -p tests --bin liquid-errors`; do not edit it. It compares the solver's laws with its own solution of the\n\
         [Young-Laplace equation](liquid-young-laplace.md). Errors of the force in per cent, least and largest over V/R_D^3 = 1e-4, 1e-3, 1e-2 and 0.1, at shares of the\n\
         exact end; the end itself, and the work from the touch to it. -100: the law has no bridge there any more. What to choose: [liquid bridges](liquid.md#capillary-force).\n",
    );
    for fit in LAWS {
        write!(
            text,
            "\n## `{}`\n\n![Error of the force over the gap](../pictures/liquid-errors-{}.svg)\n\n| angle | radii |",
            fit.name(),
            fit.name()
        )?;
        for share in SHARES {
            write!(text, " {share} |")?;
        }
        text.push_str(" end | work |\n|---|---|---|---|---|---|---|---|---|---|\n");
        for degrees in ANGLES {
            for ratio in RATIOS {
                let mut errors = vec![Vec::new(); SHARES.len() + 2];
                for volume in VOLUMES {
                    let exact = branch(degrees, volume, ratio)?;
                    let law = OfLaw::new(fit, degrees, volume, ratio);
                    for (errors, share) in errors.iter_mut().zip(SHARES) {
                        let gap = share * exact.end();
                        errors.push(law.error(gap, force(&exact, gap)?));
                    }
                    errors[SHARES.len()].push(law.bridge.end / exact.end() - 1.0);
                    let touch = exact
                        .at(0.0)
                        .ok_or_else(|| anyhow!("no bridge at the touch"))?;
                    let work = exact.last().surface_energy - touch.surface_energy;
                    errors[SHARES.len() + 1].push(law.work() / work - 1.0);
                }
                write!(text, "| {degrees}° | {} |", radii(ratio))?;
                for errors in &errors {
                    write!(text, " {} |", span(errors))?;
                }
                text.push('\n');
            }
        }
    }
    Ok(text)
}

/// A chart for each angle and ratio, with a line for each volume.
fn draw(fit: Fit, path: &Path) -> Result<()> {
    let mut charts = Vec::new();
    for degrees in ANGLES {
        for ratio in RATIOS {
            let mut chart = Chart::new(
                &format!("{degrees}°, {}", radii(ratio)),
                Axis::linear("gap over the exact end", ""),
                Axis::linear("error of the force, %", "").within(-50.0, 50.0),
            );
            for volume in VOLUMES {
                let exact = branch(degrees, volume, ratio)?;
                let law = OfLaw::new(fit, degrees, volume, ratio);
                let mut points = Vec::new();
                for k in 0..=48 {
                    let share = 0.02 * f64::from(k);
                    let gap = share * exact.end();
                    if gap < law.bridge.end {
                        points.push((share, 100.0 * law.error(gap, force(&exact, gap)?)));
                    }
                }
                chart = chart.with(Series::line(&format!("V* = {volume:e}"), points));
            }
            charts.push(chart);
        }
    }
    let title = format!("Error of the force of `{}`", fit.name());
    let page = ChartPage::new(&title, RATIOS.len(), charts).size(1400.0, 1300.0);
    Ok(page.write_svg(path)?)
}
