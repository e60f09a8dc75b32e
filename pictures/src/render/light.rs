//! How bright a surface is: Lambert's cosine law with ambient light, a soft lamp behind the reader's left shoulder,
//! dark rims and crevices so that grains in a pack stand apart.

use glam::DVec3;

use crate::colour::Colour;

/// Light without direction, and light of the lamp.
const AMBIENT: f64 = 0.44;
const LAMP: f64 = 0.56;
/// Ambient light on sheets, which are large: none of them should be a dark hole in the picture.
const SHEET_AMBIENT: f64 = 0.6;
/// How far the lamp reaches round the terminator, as a cosine: a soft lamp leaves no hard edge of shadow.
const WRAP: f64 = 0.35;
/// Direction to the lamp: right, up, towards the eye; of unit length.
const TO_LAMP: [f64; 3] = [-0.424, 0.566, 0.707];
/// Strength of the highlight.
const GLOSS: f64 = 0.22;
/// Share of the haze mixed into the farthest sphere.
pub(super) const HAZE: f64 = 0.22;
/// Strength of the shade that nearer things cast on what lies close behind them in the picture (T. Luft, C. Colditz
/// and O. Deussen, 2006).
pub(super) const CREVICE: f64 = 0.5;
/// Spheres smaller than this (samples) cannot bear an outline.
const SMALLEST_OUTLINED: f64 = 3.0;

/// Cosine between a normal (x right, y down, z away) and the direction to the lamp.
fn cosine(normal: DVec3) -> f64 {
    normal.x * TO_LAMP[0] - normal.y * TO_LAMP[1] - normal.z * TO_LAMP[2]
}

/// Share of the lamp's light that a surface gets.
fn lamp(normal: DVec3) -> f64 {
    ((cosine(normal) + WRAP) / (1.0 + WRAP)).max(0.0)
}

/// The colour of a sphere of `radius` samples where its normal is this; `shade` is 1 outside crevices.
pub(super) fn sphere(colour: Colour, normal: DVec3, radius: f64, shade: f64) -> Colour {
    let light = lamp(normal);
    // The outline: the last samples before the rim.
    let outline = if radius > SMALLEST_OUTLINED {
        0.6 + 0.4 * (-normal.z * radius.sqrt() * 0.45).clamp(0.0, 1.0)
    } else {
        1.0
    };
    colour
        .lit((AMBIENT + LAMP * light) * shade * outline)
        .mix(Colour::WHITE, GLOSS * light.powi(24))
}

/// The colour of a facet of a grain: lit like a sphere, without an outline, which is where the grain ends and not each facet.
pub(super) fn grain(colour: Colour, normal: DVec3, shade: f64) -> Colour {
    sphere(colour, normal, 0.0, shade)
}

/// The colour of a grain's facet where nothing else casts a shade; `normal` may be of any length and of either side.
#[cfg(test)]
pub(crate) fn shaded(colour: Colour, normal: DVec3) -> Colour {
    let normal = normal.normalize_or(DVec3::NEG_Z);
    grain(colour, if normal.z > 0.0 { -normal } else { normal }, 1.0)
}

/// The colour of a disc, `away` from its centre in radii: flat, with a dark rim.
pub(super) fn disc(colour: Colour, normal: DVec3, radius: f64) -> Colour {
    let away = normal.x.hypot(normal.y);
    let width = (1.6 / radius).clamp(0.02, 0.12);
    let rim = if radius > SMALLEST_OUTLINED {
        ((away - (1.0 - 2.0 * width)) / width).clamp(0.0, 1.0)
    } else {
        0.0
    };
    colour.lit(1.0 - 0.55 * rim)
}

/// The colour of a flat surface. It is thin: a good part of the light that falls on its back comes through.
pub(super) fn facet(colour: Colour, normal: DVec3, shade: f64) -> Colour {
    let light = lamp(normal).max(0.6 * lamp(-normal));
    colour.lit((SHEET_AMBIENT + (1.0 - SHEET_AMBIENT) * light) * shade)
}

/// Opacity of an oblique sheet that has `opacity` seen straight: light crosses 1/cos of its thickness (Beer and Lambert).
pub(super) fn slanted(opacity: f64, normal: DVec3) -> f64 {
    // Not beyond a fourfold thickness: an edge seen from the side is not black.
    1.0 - (1.0 - opacity).powf(1.0 / normal.z.abs().max(0.25))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_comes_from_the_upper_left() {
        let grey = Colour(128, 128, 128);
        let at = |x: f64, y: f64| {
            sphere(
                grey,
                DVec3::new(x, y, -(1.0 - x * x - y * y).sqrt()),
                100.0,
                1.0,
            )
            .0
        };
        assert!(at(-0.4, -0.5) > at(0.0, 0.0) && at(0.0, 0.0) > at(0.5, 0.6));
        // At the centre: 0.44 + 0.56 (0.707 + 0.35) / 1.35 = 0.8785, and a highlight of 0.22 * 0.783^24 = 0.0006.
        assert_eq!(at(0.0, 0.0), 112);
    }

    #[test]
    fn a_sheet_hides_more_at_a_slant() {
        let at = |z: f64| slanted(0.2, DVec3::new(0.0, (1.0 - z * z).sqrt(), -z));
        assert!((at(1.0) - 0.2).abs() < 1e-12);
        // Twice the thickness: 1 - 0.8².
        assert!((at(0.5) - 0.36).abs() < 1e-12);
        assert!((at(0.0) - (1.0 - 0.8_f64.powi(4))).abs() < 1e-12);
    }
}
