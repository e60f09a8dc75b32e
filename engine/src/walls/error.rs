//! Errors in the description of a wall or of its motion.

use glam::DVec3;

use super::mesh::Precision;

/// Why a wall shape or a motion cannot be built. `key` is the scene key that is to blame.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WallError {
    /// A direction without a direction.
    #[error("{key}: must be a finite vector of non-zero length, got {value}")]
    NoDirection {
        /// The scene key.
        key: &'static str,
        /// Value that was given.
        value: DVec3,
    },
    /// A number or a vector that is infinite or not a number.
    #[error("{key}: must be finite, got {value}")]
    NotFinite {
        /// The scene key.
        key: &'static str,
        /// Value that was given.
        value: String,
    },
    /// A length that must be positive.
    #[error("{key}: must be > 0, got {value}")]
    NotPositive {
        /// The scene key.
        key: &'static str,
        /// Value that was given.
        value: f64,
    },
    /// A quantity that must not be negative.
    #[error("{key}: must be >= 0, got {value}")]
    Negative {
        /// The scene key.
        key: &'static str,
        /// Value that was given.
        value: f64,
    },
    /// An interval whose end does not lie after its beginning.
    #[error("{key}: must increase, got {from} .. {to}")]
    NotIncreasing {
        /// The scene key.
        key: &'static str,
        /// Beginning of the interval.
        from: f64,
        /// End of the interval.
        to: f64,
    },
    /// Two motions that follow a force at the same time.
    #[error(
        "motion: of the servos of a wall one acts at a time, yet the one from {} s ends at {} s, after another has begun at {} s; end it there with `until`, drive the wall by the sum of the forces, or split it",
        .first[0], .first[1], .begins
    )]
    ServosAtOnce {
        /// When the one that begins first begins and ends, s.
        first: [f64; 2],
        /// When the other one begins, s.
        begins: f64,
    },
    /// A wall with a motion of its own was to be driven.
    #[error("its motion is that of the scene: motion = \"external\" leaves it to another program")]
    NotExternal,
    /// A turn that is no quaternion.
    #[error("the quaternion of its turn has the length {length}, and needs a finite one above 0")]
    NoTurn {
        /// Length.
        length: f64,
    },
    /// A saved wall with another number of servos.
    #[error("motion: the saved state is of another number of servos")]
    OtherServos,
    /// A profile that is no line.
    #[error("profile: must have at least 2 points, got {count}")]
    TooFewPoints {
        /// Number of points.
        count: usize,
    },
    /// A piece of a profile without length.
    #[error("profile: points {index} and {} are the same", index + 1)]
    RepeatedPoint {
        /// Index of the first of the two, from 0.
        index: usize,
    },
    /// A piece of a profile that turns into a line, not a surface.
    #[error("profile: the piece from point {index} to {} lies on the axis", index + 1)]
    PieceOnAxis {
        /// Index of the first point of the piece, from 0.
        index: usize,
    },
    /// A profile that crosses or touches itself, so that it has no two sides.
    #[error(
        "profile: the pieces that begin at points {first} and {second} cross or touch each other"
    )]
    Crossing {
        /// Index of the first point of one piece, from 0.
        first: usize,
        /// Index of the first point of the other piece.
        second: usize,
    },
    /// Places for another number of corners than the mesh has.
    #[error("corners: the mesh has {corners}, {given} places were given")]
    Corners {
        /// Number of corners of the mesh.
        corners: usize,
        /// Number of places that were given.
        given: usize,
    },
    /// A triangle that has become a line or a point.
    #[error("corners: triangle {triangle} (counted from 0) has no area left")]
    LostArea {
        /// Its place in the file, where those without area are not counted.
        triangle: u32,
    },
    /// A triangle that may have been pushed through its neighbours.
    #[error(
        "corners: triangle {triangle} (counted from 0) turns by more than a right angle at once, as one does that is pushed inside out; turn a wall by its motion, or in smaller steps"
    )]
    TurnedOver {
        /// Its place in the file, where those without area are not counted.
        triangle: u32,
    },
    /// A mesh that goes on for ever along an axis and is no longer the same at the two faces of its period.
    #[error(
        "corners: corner {corner} (counted from 0) leaves its place along the periodic axis {}, or that of its partner a period farther: a mesh that goes on for ever moves its corners across the axis, and alike at both faces", ["x", "y", "z"][*.axis]
    )]
    OffPeriod {
        /// Its number.
        corner: usize,
        /// 0, 1, 2: x, y, z.
        axis: usize,
    },
    /// A surface of another kind in the place of one.
    #[error(
        "shape: a wall's surface can become one of the same kind with the same sides, faces and edges only: contacts remember those"
    )]
    OtherShape,
    /// A mesh whose triangles are all lines or points.
    #[error("file: none of the {count} triangles has an area: they are thinner than {precision}")]
    NoTriangle {
        /// Number of triangles.
        count: usize,
        /// Precision below which thinner triangles have no area.
        precision: Precision,
    },
}

/// The unit vector along `value`.
pub(super) fn direction(key: &'static str, value: DVec3) -> Result<DVec3, WallError> {
    // Scaled first, so that the length neither overflows nor underflows.
    let largest = value.abs().max_element();
    if !value.is_finite() || largest == 0.0 {
        return Err(WallError::NoDirection { key, value });
    }
    Ok((value / largest).normalize())
}

/// `value`, if all its components are finite.
pub(super) fn finite_vector(key: &'static str, value: DVec3) -> Result<DVec3, WallError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(WallError::NotFinite {
            key,
            value: value.to_string(),
        })
    }
}

/// `value`, if it is finite.
pub(super) fn finite(key: &'static str, value: f64) -> Result<f64, WallError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(WallError::NotFinite {
            key,
            value: value.to_string(),
        })
    }
}

/// `value`, if it is finite and positive.
pub(super) fn positive(key: &'static str, value: f64) -> Result<f64, WallError> {
    if finite(key, value)? > 0.0 {
        Ok(value)
    } else {
        Err(WallError::NotPositive { key, value })
    }
}

/// `value`, if it is finite and not negative.
pub(super) fn not_negative(key: &'static str, value: f64) -> Result<f64, WallError> {
    if finite(key, value)? >= 0.0 {
        Ok(value)
    } else {
        Err(WallError::Negative { key, value })
    }
}

/// `[from, to]`, if both are finite and `from < to`.
pub(super) fn interval(key: &'static str, [from, to]: [f64; 2]) -> Result<[f64; 2], WallError> {
    if finite(key, from)? < finite(key, to)? {
        Ok([from, to])
    } else {
        Err(WallError::NotIncreasing { key, from, to })
    }
}
