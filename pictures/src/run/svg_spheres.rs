//! The spheres of the final state as SVG circles, few enough for a small file.

use super::final_state::{FinalState, WINDOW};
use crate::colour::{Colour, value_colour};
use crate::svg::short;
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// Above this number the SVG leaves out the spheres that are hidden, ...
const ALL_IN_SVG: usize = 5_000;
/// ... and of those in sight it keeps at most this many, the ones that cover most.
const MOST_IN_SVG: usize = 20_000;
/// Colours that an SVG tells apart: along the map, and in depth.
const SHADES: usize = 48;
const DEPTHS: usize = 5;

impl FinalState<'_> {
    /// The places of the spheres that an SVG draws, the farthest first, and a sentence about them.
    pub(super) fn drawn_in_svg(&self) -> (Vec<usize>, String) {
        let number = self.spheres.len();
        let mut drawn: Vec<usize> = (0..number).collect();
        if number > ALL_IN_SVG {
            let owned = self.buffer.owned(number);
            drawn.retain(|place| owned[*place] > 0);
            if drawn.len() > MOST_IN_SVG {
                drawn.sort_by_key(|place| (std::cmp::Reverse(owned[*place]), *place));
                drawn.truncate(MOST_IN_SVG);
            }
        }
        // Painted by centres: what the eye sees of touching spheres of any sizes.
        drawn.sort_by(|a, b| {
            f64::total_cmp(&self.spheres[*b].at.depth, &self.spheres[*a].at.depth).then(a.cmp(b))
        });
        let text = format!(
            "{} of {} spheres are drawn; the others are hidden.",
            drawn.len(),
            self.scene.spheres.len()
        );
        (drawn, text)
    }

    /// The circles of the spheres at these places of the list, with the gradients that shade them.
    pub(super) fn svg_spheres(&self, drawn: &[usize]) -> String {
        let depths = || drawn.iter().map(|place| self.spheres[*place].at.depth);
        let (near, far) = (
            depths().fold(f64::MAX, f64::min),
            depths().fold(f64::MIN, f64::max),
        );
        let mut circles = String::new();
        let mut used: BTreeSet<(usize, usize)> = BTreeSet::new();
        for place in drawn {
            let seen = &self.spheres[*place];
            let value = self.colouring.place(&self.scene.spheres[seen.index]);
            // The last shade is the grey of what is fixed.
            let shade = value.map_or(SHADES, |v| (v * (SHADES - 1) as f64).round() as usize);
            let share = if far > near {
                (seen.at.depth - near) / (far - near)
            } else {
                0.0
            };
            let depth = (share * (DEPTHS - 1) as f64).round() as usize;
            used.insert((shade, depth));
            let _ = writeln!(
                circles,
                "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"url(#s{shade}-{depth})\"/>",
                short(seen.at.x),
                short(seen.at.y),
                short(seen.radius.max(0.3))
            );
        }
        let mut markup = String::from("<defs>\n");
        let ((x0, y0), (x1, y1)) = (WINDOW.upper_left, WINDOW.lower_right);
        let _ = writeln!(
            markup,
            "<clipPath id=\"window\"><rect x=\"{x0}\" y=\"{y0}\" width=\"{}\" height=\"{}\"/></clipPath>",
            x1 - x0,
            y1 - y0
        );
        for (shade, depth) in used {
            let colour = if shade == SHADES {
                Colour::FIXED
            } else {
                value_colour(shade as f64 / (SHADES - 1) as f64)
            };
            let haze = 0.2 * depth as f64 / (DEPTHS - 1) as f64;
            let stop = |at: &str, colour: Colour| {
                format!(
                    "<stop offset=\"{at}\" stop-color=\"{}\"/>",
                    colour.mix(Colour(236, 239, 243), haze).hex()
                )
            };
            let _ = writeln!(
                markup,
                "<radialGradient id=\"s{shade}-{depth}\" cx=\"0.5\" cy=\"0.5\" r=\"0.5\" fx=\"0.32\" fy=\"0.26\">{}{}{}{}</radialGradient>",
                stop("0", colour.mix(Colour::WHITE, 0.2)),
                stop("0.3", colour),
                stop("0.85", colour.lit(0.66)),
                stop("1", colour.lit(0.38))
            );
        }
        let _ = write!(
            markup,
            "</defs>\n<g clip-path=\"url(#window)\">\n{circles}</g>\n"
        );
        markup
    }
}
