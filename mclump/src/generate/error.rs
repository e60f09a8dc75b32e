//! Why there are no pebbles.

use crate::table::number;

const TARGET_ADVICE: &str = "allow smaller pebbles (--smallest-radius) or some protrusion (--protrusion), ask for a number of pebbles (--pebbles) \
     instead, or use another method (--generate)";

/// Reason why a generator cannot make pebbles, with advice.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GenerateError {
    /// No triangles, or only triangles without area.
    #[error("the surface has no triangle with an area")]
    Empty,
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} of the surface is not finite")]
    NotFinite {
        /// Index of the vertex, from 0.
        vertex: usize,
    },
    /// The surface has a border, or neighbours of opposite orientation.
    #[error(
        "the surface is not closed: {edges} edges do not have as many triangles on one side as on the other, so it has no inside; close the holes, merge equal vertices, or turn triangles so that all corners run counter-clockwise seen from outside"
    )]
    Open {
        /// Number of bad edges.
        edges: usize,
    },
    /// The volume is zero or negative.
    #[error(
        "the surface encloses the volume {volume:e} m3, which must be above 0: are its triangles turned inside out?"
    )]
    NotOutward {
        /// Signed volume in m3.
        volume: f64,
    },
    /// A parameter outside its range.
    #[error("{name} is {value}, expected {expected}")]
    Parameter {
        /// The parameter, in words.
        name: &'static str,
        /// Value that was given.
        value: f64,
        /// The allowed range.
        expected: &'static str,
    },
    /// Neither a number of pebbles nor a fidelity.
    #[error(
        "a generator needs an end: give a number of pebbles (--pebbles), a volume error (--fidelity), or both"
    )]
    NoStop,
    /// The corners are too close to a plane or a line.
    #[error("the convex hull of the surface cannot be found: {reason}")]
    ConvexHull {
        /// Message of the hull algorithm.
        reason: String,
    },
    /// Nothing to compare.
    #[error("there are no pebbles to compare with the surface")]
    NoPebbles,
    /// The body is too thin for the smallest radius.
    #[error(
        "no pebble fits: there is no inscribed ball with a radius of {} m or more; allow smaller pebbles (--smallest-radius)", number(*smallest)
    )]
    NothingFits {
        /// Smallest radius in m.
        smallest: f64,
    },
    /// The volume error stays too large.
    #[error(
        "{pebbles} pebbles, all that fit, reach a volume error of {reached:.4}, not {target}; {TARGET_ADVICE}"
    )]
    TargetNotReached {
        /// The requested value.
        target: f64,
        /// Value that the pebbles reach.
        reached: f64,
        /// Number of pebbles.
        pebbles: usize,
    },
    /// The axis of Favier's method leaves the body.
    #[error(
        "the longest principal axis leaves the body at {position:.4} of its length, so it is no body of revolution without a hole; use another method"
    )]
    AxisOutside {
        /// Where, as a share of the length.
        position: f64,
    },
}
