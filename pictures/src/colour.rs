//! Colours: plain RGB.

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

    /// `#rrggbb`, as in SVG.
    pub(crate) fn hex(self) -> String {
        format!("#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
    }
}
