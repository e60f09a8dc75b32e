//! Colours: plain RGB, and the map from a value to a colour.

/// An opaque colour, sRGB, 8 bits a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Colour(
    /// Red.
    pub u8,
    /// Green.
    pub u8,
    /// Blue.
    pub u8,
);

impl Colour {
    pub(crate) const WHITE: Self = Self(255, 255, 255);
    /// Text and axes.
    pub(crate) const INK: Self = Self(38, 42, 48);
    /// Secondary text.
    pub(crate) const SOFT_INK: Self = Self(96, 102, 110);
    /// Grid lines.
    pub(crate) const GRID: Self = Self(228, 231, 235);
    /// Outlines of the domain.
    pub(crate) const DOMAIN: Self = Self(150, 158, 168);
    /// Outlines of walls.
    pub(crate) const WALL: Self = Self(84, 92, 104);
    /// Fixed particles.
    pub(crate) const FIXED: Self = Self(168, 170, 173);

    /// The colour `share` of the way from `self` to `other`; `share` is held to `0..=1`.
    pub(crate) fn mix(self, other: Self, share: f64) -> Self {
        let share = share.clamp(0.0, 1.0);
        // Adding a half and cutting rounds what is not negative; `round` would be a call per channel and pixel.
        let channel =
            |a: u8, b: u8| (f64::from(a) + share * (f64::from(b) - f64::from(a)) + 0.5) as u8;
        Self(
            channel(self.0, other.0),
            channel(self.1, other.1),
            channel(self.2, other.2),
        )
    }

    /// The colour under light of the given strength (1 = as it is).
    pub(crate) fn lit(self, strength: f64) -> Self {
        // The cast holds the result to 0..=255.
        let channel = |a: u8| (f64::from(a) * strength + 0.5) as u8;
        Self(channel(self.0), channel(self.1), channel(self.2))
    }

    /// `#rrggbb`, as SVG wants it.
    pub(crate) fn hex(self) -> String {
        format!("#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
    }
}

/// Seventeen equidistant samples of viridis, perceptually uniform and readable with colour-blind eyes
/// (S. van der Walt and N. Smith, 2015, for matplotlib; released as CC0).
const VIRIDIS: [Colour; 17] = [
    Colour(68, 1, 84),
    Colour(72, 24, 106),
    Colour(71, 45, 123),
    Colour(66, 64, 134),
    Colour(59, 82, 139),
    Colour(51, 99, 141),
    Colour(44, 114, 142),
    Colour(38, 130, 142),
    Colour(33, 145, 140),
    Colour(31, 160, 136),
    Colour(40, 174, 128),
    Colour(63, 188, 115),
    Colour(94, 201, 98),
    Colour(132, 212, 75),
    Colour(173, 220, 48),
    Colour(216, 226, 25),
    Colour(253, 231, 37),
];

/// The darkest part of viridis is left out: a shaded sphere needs light to show its shape.
const DARKEST: f64 = 0.16;

/// The colour of a value, 0 (low) to 1 (high); values outside take the colours of the ends.
pub(crate) fn value_colour(value: f64) -> Colour {
    let value = if value.is_nan() {
        0.0
    } else {
        value.clamp(0.0, 1.0)
    };
    let last = VIRIDIS.len() - 1;
    let place = (DARKEST + (1.0 - DARKEST) * value) * last as f64;
    let below = (place.floor() as usize).min(last - 1);
    VIRIDIS[below].mix(VIRIDIS[below + 1], place - below as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance with the weights of ITU-R BT.709, without the transfer curve: order is all we ask.
    fn luma(colour: Colour) -> f64 {
        0.2126 * f64::from(colour.0) + 0.7152 * f64::from(colour.1) + 0.0722 * f64::from(colour.2)
    }

    #[test]
    fn the_map_grows_lighter_from_end_to_end() {
        let lumas: Vec<f64> = (0..=100)
            .map(|i| luma(value_colour(f64::from(i) / 100.0)))
            .collect();
        assert!(
            lumas.windows(2).all(|pair| pair[1] >= pair[0] - 0.5),
            "{lumas:?}"
        );
    }

    #[test]
    fn values_outside_take_the_ends() {
        assert_eq!(value_colour(-3.0), value_colour(0.0));
        assert_eq!(value_colour(7.0), Colour(253, 231, 37));
        assert_eq!(value_colour(f64::NAN), value_colour(0.0));
    }
}
