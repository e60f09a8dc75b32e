//! Target of a servo: a force or a pressure over time.

use mercury_common::curve::Curve;

/// Over which area a pressure acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Area {
    /// This one, m^2.
    Given(f64),
    /// Area of the wall, of planes the part within the domain that no other plane cuts off (`walls/section.rs`).
    OfWall,
}

/// Target of a servo.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// Force of the wall on the particles along the axis, N.
    Force(Curve),
    /// Force of the wall over an area, Pa: positive where the wall presses along the axis.
    Pressure(Curve, Area),
}

impl Target {
    /// Force or pressure over time.
    #[must_use]
    pub fn curve(&self) -> &Curve {
        match self {
            Self::Force(curve) | Self::Pressure(curve, _) => curve,
        }
    }

    /// The unit of the curve.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Force(_) => "N",
            Self::Pressure(..) => "Pa",
        }
    }
}
