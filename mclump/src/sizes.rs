//! Lengths that can be computed with.
//!
//! Moments of inertia are fifth powers of lengths, and their squares are needed for the principal axes: a length of 1e30 m gives 1e300, near the
//! end of double precision (1.8e308). Larger values would end as infinities, zeros and searches without end.

use std::path::Path;

use mercury_common::formats::clump::Pebble;
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::formats::pebble_list::parse_pebble_list;

/// No radius and no extent of a surface may be smaller than this (m).
pub const SMALLEST_LENGTH: f64 = 1e-30;
/// No radius and no coordinate may be larger than this in size (m).
pub const LARGEST_LENGTH: f64 = 1e30;
/// A radius must be at least this share of the pebble's coordinates: of sixteen digits four remain for the surface of the pebble.
pub const SMALLEST_TO_COORDINATE: f64 = 1e-12;
/// The largest radius must be at least this share of the extent of the pebbles. The smallest moment of a row of balls is to the largest as
/// the square, 1e-12, and must stand out of the round-off (1e-16).
pub const SMALLEST_TO_EXTENT: f64 = 1e-6;

/// A length that cannot be computed with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SizeProblem {
    /// The pebble, counted from 0; `None` where it is no single one.
    pub pebble: Option<usize>,
    /// Value that was found.
    pub found: String,
    /// Value that was expected.
    pub expected: String,
    /// Why, and what to do.
    pub help: &'static str,
}

const RANGE_HELP: &str = "moments of inertia are fifth powers of lengths and would leave the range of numbers: correct the value or --scale";
const DIGITS_HELP: &str = "numbers have 16 digits, so the pebble would vanish: correct the value, or move the origin into the body";
const EXTENT_HELP: &str =
    "the pebbles would vanish against their distances: correct the one that is far away";

/// The first length of pebbles (in m, finite) that cannot be computed with, if there is one.
#[must_use]
pub fn pebble_problem(pebbles: &[Pebble]) -> Option<SizeProblem> {
    let single = pebbles.iter().enumerate().find_map(|(index, pebble)| {
        let problem = |found, expected, help| {
            Some(SizeProblem {
                pebble: Some(index),
                found,
                expected,
                help,
            })
        };
        let (name, value) = largest_coordinate(pebble);
        let radius = pebble.radius;
        if value.abs() > LARGEST_LENGTH {
            let found = format!("{name} = {} m", number(value));
            return problem(found, coordinate_range(), RANGE_HELP);
        }
        if !(SMALLEST_LENGTH..=LARGEST_LENGTH).contains(&radius) {
            let expected = format!(
                "a radius from {} m to {} m",
                number(SMALLEST_LENGTH),
                number(LARGEST_LENGTH)
            );
            return problem(
                format!("the radius {} m", number(radius)),
                expected,
                RANGE_HELP,
            );
        }
        if radius < SMALLEST_TO_COORDINATE * value.abs() {
            let found = format!(
                "the radius {} m beside {name} = {} m",
                number(radius),
                number(value)
            );
            let expected = format!("at least {SMALLEST_TO_COORDINATE:e} of the coordinate");
            return problem(found, expected, DIGITS_HELP);
        }
        None
    });
    single.or_else(|| extent_problem(pebbles))
}

/// Pebbles far smaller than their distances.
fn extent_problem(pebbles: &[Pebble]) -> Option<SizeProblem> {
    let (low, high) = crate::inertia::pebbles::bounds(pebbles)?;
    let extent = (high - low).max_element();
    let largest = pebbles.iter().map(|p| p.radius).fold(0.0, f64::max);
    if largest >= SMALLEST_TO_EXTENT * extent {
        return None;
    }
    let size = |pebble: &Pebble| largest_coordinate(pebble).1.abs();
    let pebble =
        (0..pebbles.len()).max_by(|&a, &b| size(&pebbles[a]).total_cmp(&size(&pebbles[b])));
    let (name, value) = largest_coordinate(&pebbles[pebble?]);
    Some(SizeProblem {
        pebble,
        found: format!(
            "{name} = {} m, which spreads the pebbles over {} m, while the largest radius is {} m",
            number(value),
            number(extent),
            number(largest)
        ),
        expected: format!("at least {SMALLEST_TO_EXTENT:e} of the spread"),
        help: EXTENT_HELP,
    })
}

/// Property of a surface (in m, finite) that rules out computing with it, if there is one.
#[must_use]
pub fn surface_problem(mesh: &TriangleMesh) -> Option<SizeProblem> {
    let (low, high) = mesh.bounds()?;
    let problem = |found, expected, help| {
        Some(SizeProblem {
            pebble: None,
            found,
            expected,
            help,
        })
    };
    let largest = low.abs().max(high.abs()).max_element();
    if largest > LARGEST_LENGTH {
        let found = format!("a vertex with the coordinate {} m in size", number(largest));
        return problem(found, coordinate_range(), RANGE_HELP);
    }
    let extent = (high - low).max_element();
    if extent < SMALLEST_LENGTH {
        let found = format!("a surface of {} m", number(extent));
        let expected = format!("at least {} m", number(SMALLEST_LENGTH));
        return problem(found, expected, RANGE_HELP);
    }
    None
}

fn coordinate_range() -> String {
    format!("at most {} m in size", number(LARGEST_LENGTH))
}

/// Seven digits at most, and no more than needed.
fn number(x: f64) -> String {
    let rounded: f64 = format!("{x:.6e}").parse().unwrap_or(x);
    if x != 0.0 && !(1e-3..1e6).contains(&x.abs()) {
        format!("{rounded:e}")
    } else {
        format!("{rounded}")
    }
}

/// The coordinate of a centre that is largest in size, with its name.
fn largest_coordinate(pebble: &Pebble) -> (&'static str, f64) {
    let [x, y, z] = pebble.position.to_array();
    [("y", y), ("z", z)].into_iter().fold(
        ("x", x),
        |most, c| {
            if c.1.abs() > most.1.abs() { c } else { most }
        },
    )
}

/// The line, counted from 1, of the pebble `index` (from 0) in the text of a [pebble list](mercury_common::formats::pebble_list); `None` if it has
/// fewer pebbles.
#[must_use]
pub fn line_of_pebble(path: &Path, text: &str, index: usize) -> Option<usize> {
    // A line that holds nothing, or a header, is no fault of its line but leaves the list empty.
    let is_pebble = |line: &str| match parse_pebble_list(path, line) {
        Ok(_) => true,
        Err(error) => error.line.is_some(),
    };
    let mut pebbles = (text.lines().enumerate()).filter(|(_, line)| is_pebble(line));
    pebbles.nth(index).map(|(line, _)| line + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn problem(pebbles: &[[f64; 4]]) -> Option<SizeProblem> {
        let pebbles: Vec<Pebble> = pebbles
            .iter()
            .map(|&[x, y, z, radius]| Pebble {
                position: DVec3::new(x, y, z),
                radius,
            })
            .collect();
        pebble_problem(&pebbles)
    }

    #[test]
    fn the_limits_themselves_are_allowed() {
        for good in [
            [0.0, 0.0, 0.0, 1e30],
            [0.0, -1e30, 0.0, 1e30],
            [0.0, 0.0, 0.0, 1e-30],
            [1e12, 0.0, 0.0, 1.0],
        ] {
            assert_eq!(problem(&[good]), None, "{good:?}");
        }
        // A row a million radii long.
        assert_eq!(problem(&[[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 9e5, 1.0]]), None);
        let far = problem(&[[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1e6, 1.0]]);
        assert_eq!(far.map(|problem| problem.pebble), Some(Some(1)));
    }

    #[test]
    fn lines_are_counted_through_header_blanks_and_comments() {
        let text = "# a pear\n\nr;z;y;x\n1;0;0;-5\n\n% no\n2;0;0;0 # yes\n";
        let line = |index| line_of_pebble(Path::new("p.csv"), text, index);
        assert_eq!([line(0), line(1), line(2)], [Some(4), Some(7), None]);
    }
}
