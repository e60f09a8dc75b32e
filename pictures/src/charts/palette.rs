//! The look of series: colours that colour-blind readers tell apart, each with a dash and a marker of its own, so that a chart can
//! still be read when it is printed in grey.

use crate::colour::Colour;

/// A colour of M. Okabe and K. Ito, *Color universal design* (2008); its yellow is left out, because lines in it vanish on paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hue {
    /// Blue, the first of a chart.
    Blue,
    /// Vermillion.
    Vermillion,
    /// Bluish green.
    Green,
    /// Reddish purple.
    Purple,
    /// Orange.
    Orange,
    /// Sky blue.
    Sky,
    /// Nearly black: the colour of the text.
    Ink,
    /// Wine red, of P. Tol, *Colour schemes* (2021), muted.
    Wine,
    /// Olive, likewise.
    Olive,
    /// Grey, for what is there to compare with.
    Grey,
}

impl Hue {
    /// In the order in which series without a colour of their own take them: as many as a tensor has components.
    pub(super) const CYCLE: [Self; 9] = [
        Self::Blue,
        Self::Vermillion,
        Self::Green,
        Self::Purple,
        Self::Orange,
        Self::Sky,
        Self::Ink,
        Self::Wine,
        Self::Olive,
    ];

    /// Colour as red, green and blue.
    #[must_use]
    pub fn colour(self) -> Colour {
        match self {
            Self::Blue => Colour(0, 114, 178),
            Self::Vermillion => Colour(213, 94, 0),
            Self::Green => Colour(0, 158, 115),
            Self::Purple => Colour(204, 121, 167),
            Self::Orange => Colour(230, 159, 0),
            Self::Sky => Colour(86, 180, 233),
            Self::Ink => Colour::INK,
            Self::Wine => Colour(136, 34, 85),
            Self::Olive => Colour(153, 153, 51),
            Self::Grey => Colour(128, 132, 138),
        }
    }
}

/// How a line is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dash {
    /// No dashes.
    Solid,
    /// Dashes.
    Dashed,
    /// Dashes and dots in turn.
    DashDot,
    /// Dots.
    Dotted,
    /// Long dashes.
    Long,
}

impl Dash {
    pub(super) const CYCLE: [Self; 5] = [
        Self::Solid,
        Self::Dashed,
        Self::DashDot,
        Self::Dotted,
        Self::Long,
    ];

    /// Lengths of dash, gap, dash, gap, ... in points, for a line with round ends.
    pub(super) fn lengths(self) -> &'static [f64] {
        match self {
            Self::Solid => &[],
            Self::Dashed => &[6.0, 4.0],
            Self::DashDot => &[8.0, 3.6, 0.4, 3.6],
            Self::Dotted => &[0.4, 3.4],
            Self::Long => &[12.0, 4.0],
        }
    }
}

/// Shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// A filled disc.
    Disc,
    /// A filled square.
    Square,
    /// A filled triangle.
    Triangle,
    /// A filled diamond.
    Diamond,
    /// A ring.
    Ring,
    /// A slanted cross.
    Cross,
}

impl Marker {
    pub(super) const CYCLE: [Self; 6] = [
        Self::Disc,
        Self::Square,
        Self::Triangle,
        Self::Diamond,
        Self::Ring,
        Self::Cross,
    ];
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nine lines, as of a tensor, have nine colours, each far from the others in one of its channels.
    #[test]
    fn colours_of_a_cycle_are_distinct() {
        for (number, one) in Hue::CYCLE.iter().enumerate() {
            for other in &Hue::CYCLE[..number] {
                let (a, b) = (one.colour(), other.colour());
                let apart =
                    a.0.abs_diff(b.0)
                        .max(a.1.abs_diff(b.1))
                        .max(a.2.abs_diff(b.2));
                assert!(apart >= 50, "{one:?} {other:?}");
            }
        }
    }
}
