//! From values to colours: perceptual maps for numbers, distinct colours for categories.

use std::str::FromStr;

use crate::colour::Colour;

/// A map from 0..=1 to colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColourMap {
    /// Dark blue over green to yellow.
    #[default]
    Viridis,
    /// Dark violet over red to pale yellow.
    Magma,
    /// Dark violet over orange to yellow.
    Inferno,
    /// Blue over magenta to yellow.
    Plasma,
    /// Blue over grey to yellow; the same for colour-blind eyes.
    Cividis,
    /// All colours of the rainbow, smoothly.
    Turbo,
    /// Blue over grey to red: for numbers around a middle.
    CoolWarm,
    /// Grey to white.
    Grey,
    /// Pale amber over red to dark: lines on a light background.
    Embers,
}

impl ColourMap {
    /// The names that [`ColourMap::from_str`] takes.
    pub const NAMES: [(&'static str, Self); 9] = [
        ("viridis", Self::Viridis),
        ("magma", Self::Magma),
        ("inferno", Self::Inferno),
        ("plasma", Self::Plasma),
        ("cividis", Self::Cividis),
        ("turbo", Self::Turbo),
        ("coolwarm", Self::CoolWarm),
        ("grey", Self::Grey),
        ("embers", Self::Embers),
    ];

    /// The colour of a value from 0 (low) to 1 (high); values outside take the colours of the ends, NaN that of 0.
    #[must_use]
    pub fn colour(self, value: f64) -> Colour {
        let value = if value.is_nan() {
            0.0
        } else {
            value.clamp(0.0, 1.0)
        };
        let (table, darkest) = self.table();
        let last = table.len() - 1;
        let place = (darkest + (1.0 - darkest) * value) * last as f64;
        let below = (place.floor() as usize).min(last - 1);
        table[below].mix(table[below + 1], place - below as f64)
    }

    /// Samples at equal distances, and the share of the map at its dark end that is left out: a shaded sphere needs
    /// light to show its shape.
    fn table(self) -> (&'static [Colour], f64) {
        match self {
            Self::Viridis => (&VIRIDIS, 0.16),
            Self::Magma => (&MAGMA, 0.24),
            Self::Inferno => (&INFERNO, 0.22),
            Self::Plasma => (&PLASMA, 0.04),
            Self::Cividis => (&CIVIDIS, 0.1),
            Self::Turbo => (&TURBO, 0.04),
            Self::CoolWarm => (&COOLWARM, 0.0),
            Self::Grey => (&GREY, 0.0),
            Self::Embers => (&EMBERS, 0.0),
        }
    }
}

impl FromStr for ColourMap {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = Self::NAMES.iter().find(|(name, _)| *name == text);
        known.map(|(_, map)| *map).ok_or_else(|| {
            let names: Vec<&str> = Self::NAMES.iter().map(|(name, _)| *name).collect();
            format!("expected one of {}", names.join(", "))
        })
    }
}

/// The colour of a category. The first eight tell each other apart for colour-blind readers (M. Okabe and K. Ito, 2008,
/// without black, which hides shading, and with a grey-blue); further ones walk round the hue circle by the golden angle.
#[must_use]
pub fn category_colour(number: usize) -> Colour {
    if let Some(colour) = CATEGORIES.get(number) {
        return *colour;
    }
    let turn = (number as f64 * 0.618_033_988_749_894_9).fract() * 6.0;
    // Hue to red, green, blue at saturation 0.55 and value 0.85 (A. R. Smith, 1978).
    let channel = |shift: f64| {
        let ramp = ((turn + shift) % 6.0 - 3.0).abs() - 1.0;
        (255.0 * 0.85 * (1.0 - 0.55 + 0.55 * ramp.clamp(0.0, 1.0)) + 0.5) as u8
    };
    Colour(channel(0.0), channel(4.0), channel(2.0))
}

const CATEGORIES: [Colour; 8] = [
    Colour(0, 114, 178),
    Colour(230, 159, 0),
    Colour(0, 158, 115),
    Colour(204, 121, 167),
    Colour(86, 180, 233),
    Colour(213, 94, 0),
    Colour(240, 228, 66),
    Colour(120, 130, 150),
];

/// Luma falls evenly from 200 to 30.
const EMBERS: [Colour; 5] = [
    Colour(240, 200, 130),
    Colour(240, 150, 60),
    Colour(216, 88, 40),
    Colour(150, 36, 44),
    Colour(66, 16, 44),
];

const GREY: [Colour; 2] = [Colour(70, 70, 70), Colour(245, 245, 245)];

// Seventeen samples at equal distances of each map, within 11 of 255 of the finer originals.
// Viridis, magma, inferno, plasma: S. van der Walt and N. Smith, 2015, CC0. Cividis: J. Nunez, C. Anderton and
// R. Renslow, 2018. Turbo: A. Mikhailov, 2019. Cool-warm: K. Moreland, 2009.

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

const MAGMA: [Colour; 17] = [
    Colour(0, 0, 4),
    Colour(10, 8, 34),
    Colour(29, 17, 71),
    Colour(54, 16, 107),
    Colour(81, 18, 124),
    Colour(106, 28, 129),
    Colour(131, 38, 129),
    Colour(156, 46, 127),
    Colour(183, 55, 121),
    Colour(208, 65, 111),
    Colour(231, 82, 99),
    Colour(245, 107, 92),
    Colour(252, 137, 97),
    Colour(254, 167, 114),
    Colour(254, 196, 136),
    Colour(253, 226, 163),
    Colour(252, 253, 191),
];

const INFERNO: [Colour; 17] = [
    Colour(0, 0, 4),
    Colour(11, 7, 36),
    Colour(33, 12, 74),
    Colour(61, 9, 101),
    Colour(87, 16, 110),
    Colour(113, 25, 110),
    Colour(138, 34, 106),
    Colour(163, 44, 97),
    Colour(188, 55, 84),
    Colour(210, 70, 68),
    Colour(228, 90, 49),
    Colour(241, 115, 29),
    Colour(249, 142, 9),
    Colour(252, 172, 17),
    Colour(249, 203, 53),
    Colour(242, 234, 105),
    Colour(252, 255, 164),
];

const PLASMA: [Colour; 17] = [
    Colour(13, 8, 135),
    Colour(49, 5, 151),
    Colour(76, 2, 161),
    Colour(102, 0, 167),
    Colour(126, 3, 168),
    Colour(149, 17, 161),
    Colour(170, 35, 149),
    Colour(188, 53, 135),
    Colour(204, 71, 120),
    Colour(218, 90, 106),
    Colour(230, 108, 92),
    Colour(240, 128, 78),
    Colour(248, 149, 64),
    Colour(253, 172, 51),
    Colour(253, 197, 39),
    Colour(248, 223, 37),
    Colour(240, 249, 33),
];

const CIVIDIS: [Colour; 17] = [
    Colour(0, 34, 78),
    Colour(0, 46, 106),
    Colour(26, 56, 111),
    Colour(50, 67, 109),
    Colour(67, 78, 108),
    Colour(83, 90, 109),
    Colour(97, 101, 111),
    Colour(111, 112, 115),
    Colour(125, 124, 120),
    Colour(140, 136, 120),
    Colour(155, 148, 118),
    Colour(171, 160, 114),
    Colour(188, 174, 108),
    Colour(205, 187, 99),
    Colour(222, 201, 88),
    Colour(240, 216, 70),
    Colour(254, 232, 56),
];

const TURBO: [Colour; 17] = [
    Colour(48, 18, 59),
    Colour(64, 64, 162),
    Colour(70, 107, 227),
    Colour(66, 148, 255),
    Colour(40, 188, 235),
    Colour(24, 221, 194),
    Colour(50, 242, 152),
    Colour(109, 254, 98),
    Colour(164, 252, 60),
    Colour(205, 236, 52),
    Colour(238, 207, 58),
    Colour(253, 172, 52),
    Colour(251, 126, 33),
    Colour(235, 80, 14),
    Colour(208, 47, 5),
    Colour(169, 22, 1),
    Colour(122, 4, 3),
];

const COOLWARM: [Colour; 17] = [
    Colour(59, 76, 192),
    Colour(78, 104, 216),
    Colour(98, 130, 234),
    Colour(119, 154, 247),
    Colour(141, 176, 254),
    Colour(163, 194, 254),
    Colour(185, 208, 249),
    Colour(204, 217, 237),
    Colour(221, 220, 220),
    Colour(236, 211, 197),
    Colour(245, 196, 172),
    Colour(247, 176, 147),
    Colour(244, 152, 122),
    Colour(235, 125, 98),
    Colour(221, 95, 75),
    Colour(202, 59, 55),
    Colour(180, 4, 38),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Luma with the weights of ITU-R BT.709: only the order matters.
    fn luma(colour: Colour) -> f64 {
        0.2126 * f64::from(colour.0) + 0.7152 * f64::from(colour.1) + 0.0722 * f64::from(colour.2)
    }

    #[test]
    fn sequential_maps_grow_lighter_from_end_to_end() {
        for map in [
            ColourMap::Viridis,
            ColourMap::Magma,
            ColourMap::Inferno,
            ColourMap::Plasma,
            ColourMap::Cividis,
            ColourMap::Grey,
        ] {
            let lumas: Vec<f64> = (0..=100)
                .map(|i| luma(map.colour(f64::from(i) / 100.0)))
                .collect();
            // Rounding to 8 bits may step back by half a level.
            assert!(
                lumas.windows(2).all(|pair| pair[1] >= pair[0] - 0.6),
                "{map:?} {lumas:?}"
            );
        }
    }

    #[test]
    fn values_outside_take_the_ends() {
        for (_, map) in ColourMap::NAMES {
            assert_eq!(map.colour(-3.0), map.colour(0.0));
            assert_eq!(map.colour(7.0), map.colour(1.0));
            assert_eq!(map.colour(f64::NAN), map.colour(0.0));
        }
        assert_eq!(ColourMap::Viridis.colour(1.0), Colour(253, 231, 37));
    }

    #[test]
    fn every_map_has_its_name() {
        for (name, map) in ColourMap::NAMES {
            assert_eq!(name.parse(), Ok(map));
        }
        assert_eq!(
            "jet".parse::<ColourMap>(),
            Err(
                "expected one of viridis, magma, inferno, plasma, cividis, turbo, coolwarm, grey, embers"
                    .into()
            )
        );
    }

    #[test]
    fn thirty_categories_differ() {
        let colours: Vec<Colour> = (0..30).map(category_colour).collect();
        for (i, a) in colours.iter().enumerate() {
            for b in &colours[..i] {
                let apart =
                    a.0.abs_diff(b.0)
                        .max(a.1.abs_diff(b.1))
                        .max(a.2.abs_diff(b.2));
                assert!(apart >= 8, "{a:?} {b:?}");
            }
        }
    }
}
