//! `.stat` in the layout of MercuryCG, so that its readers and scripts work: see `docs/formats/stat.md`.

use std::fmt::Write as _;

use mercury_common::formats::number::{NumberStyle, push_number};

use crate::coordinates::{Coordinates, Place};
use crate::evaluate::Evaluator;
use crate::kernel::KernelShape;
use crate::state::Space;
use crate::sums::{Sum, Sums};

/// How times were put together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StatTime {
    /// A block for each frame.
    Frames,
    /// One block, the mean of all frames.
    Average,
    /// Weighted means around output times.
    Smooth {
        /// Width of the Gaussian in time, s.
        width: f64,
        /// Where it is cut, s.
        cutoff: f64,
    },
}

/// The 29 standard fields with their numbers of columns.
const COLUMNS: [(&str, usize, Sum); 7] = [
    ("VolumeFraction", 1, Sum::Volume),
    ("Density", 1, Sum::Mass),
    ("Momentum", 3, Sum::Momentum),
    ("MomentumFlux", 6, Sum::MomentumFlux),
    ("ContactStress", 9, Sum::Stress),
    ("InteractionForce", 3, Sum::BoundaryForce),
    ("ParticleSize", 6, Sum::Sizes),
];

/// Both header lines.
#[must_use]
pub fn header(evaluator: &Evaluator, space: &Space, time: StatTime, style: NumberStyle) -> String {
    let word = evaluator.coordinates.word();
    let kind = match time {
        StatTime::Frames => "CG",
        StatTime::Average => "TimeAveragedCG",
        StatTime::Smooth { .. } => "TimeSmoothedCG",
    };
    let (mut min, mut max, mut count) = (space.min, space.max, [1; 3]);
    if let (Coordinates::Cartesian(resolved), Place::Grid(grid)) =
        (evaluator.coordinates, &evaluator.place)
    {
        for (axis, of) in (0..3).filter(|&axis| resolved[axis]).zip(grid) {
            (min[axis], max[axis], count[axis]) = (of.min, of.max, of.count);
        }
    }
    let kernel = &evaluator.kernel;
    let number = |value: f64| text(value, style);
    let corner = |v: glam::DVec3| format!("{} {} {}", number(v.x), number(v.y), number(v.z));
    let mut out = format!(
        "{kind}<{word}> min {} max {} n {} {} {} width {}",
        corner(min),
        corner(max),
        count[0],
        count[1],
        count[2],
        number(kernel.width)
    );
    if let StatTime::Smooth { width, cutoff } = time {
        let _ = write!(
            out,
            " widthTime {} cutoffTime {} ",
            number(width),
            number(cutoff)
        );
    }
    let width = number(kernel.width);
    let _ = match kernel.shape {
        KernelShape::Gaussian => write!(
            out,
            " Gauss width {width} cutoff {}",
            number(kernel.cutoff * kernel.width)
        ),
        KernelShape::Lucy => write!(out, " Lucy cutoff {width}"),
        KernelShape::Linear => write!(out, " Linear cutoff {width}"),
        KernelShape::Heaviside => write!(out, " Heaviside cutoff {width}"),
    };
    out.push_str("\ntime ");
    let names = evaluator.coordinates.names();
    for name in &names {
        let _ = write!(out, "{name} ");
    }
    let mut column = 2 + names.len();
    for (name, count, _) in COLUMNS {
        let _ = if count == 1 {
            write!(out, "{column}:{name} ")
        } else {
            write!(out, "{column}-{}:{name} ", column + count - 1)
        };
        column += count;
    }
    out.push('\n');
    out
}

fn text(value: f64, style: NumberStyle) -> String {
    let mut out = Vec::new();
    push_number(&mut out, value, style);
    String::from_utf8(out).unwrap_or_default()
}

/// The 29 numbers of a point; what the sums do not have is 0.
#[must_use]
pub fn values(sums: &Sums, point: usize) -> Vec<f64> {
    COLUMNS
        .iter()
        .flat_map(|&(_, count, sum)| {
            let found = sums.at(sum, point);
            (0..count).map(move |k| found.get(k).copied().unwrap_or(0.0))
        })
        .collect()
}

/// The rows of a time.
pub fn push_rows(out: &mut Vec<u8>, time: f64, place: &Place, sums: &Sums, style: NumberStyle) {
    for point in 0..sums.points {
        push_number(out, time, style);
        for value in place
            .coordinates(point)
            .into_iter()
            .chain(values(sums, point))
        {
            out.push(b' ');
            push_number(out, value, style);
        }
        out.push(b'\n');
    }
}
