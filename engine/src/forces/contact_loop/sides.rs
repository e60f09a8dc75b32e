//! On which side of a one-sided wall a contact acts.
//!
//! A centre may be behind the surface that it touches for two reasons. It came from the front and went through: then it is pushed back
//! to the front, from as deep as its radius. Or it was behind when it came near, round the rim of a bounded wall, as an insertion left it, or
//! because the wall was put there: pushed to the front it would be shot there, with all the energy of an overlap of nearly a diameter. So a contact that
//! begins behind acts from behind, for as long as it lasts.

use super::slots::{BEHIND, THROUGH};
use crate::walls::{Touch, Turning};

/// Either of the two bits.
pub(super) const THROUGH_OR_BEHIND: u32 = THROUGH | BEHIND;

/// The side of a contact, as bits of its slot: 0 in front, [`BEHIND`] or [`THROUGH`]. `before`: the bits of the slot; `distance`: of the centre from the surface,
/// m, now and, by its velocity, a step before.
#[inline]
pub(super) fn side(before: u32, [distance, last]: [f64; 2]) -> u32 {
    if before & BEHIND != 0 {
        BEHIND
    } else if distance >= 0.0 {
        0
    } else if before & THROUGH != 0 || last >= 0.0 {
        THROUGH
    } else {
        BEHIND
    }
}

/// The touch of a surface, seen from behind.
pub(super) fn from_behind(touch: &Touch) -> Touch {
    Touch {
        distance: -touch.distance,
        normal: -touch.normal,
        curvature: touch.curvature.map(|curvature| -curvature),
        turning: Turning {
            rates: touch.turning.rates.map(|rate| -rate),
            ..touch.turning
        },
        ..*touch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contact_keeps_the_side_on_which_it_began() {
        // In front, or on the way through: pushed back to the front all the way.
        assert_eq!(side(0, [0.9, 1.0]), 0);
        assert_eq!(side(0, [-0.1, 0.1]), THROUGH);
        assert_eq!(side(THROUGH, [-0.3, -0.1]), THROUGH);
        assert_eq!(side(THROUGH, [0.1, -0.1]), 0);
        // Behind, or on the way to the front: pushed back behind.
        assert_eq!(side(0, [-0.9, -1.0]), BEHIND);
        assert_eq!(side(BEHIND, [-0.1, -0.2]), BEHIND);
        assert_eq!(side(BEHIND, [0.1, -0.1]), BEHIND);
    }
}
