//! The embedded font: widths and outlines of text. See `pictures/assets/README.md` for its source and licence.

use ab_glyph::{Font, FontRef, Glyph, Point, PxScale, ScaleFont};
use std::sync::OnceLock;

const BYTES: &[u8] = include_bytes!("../assets/DejaVuSans-subset.ttf");

/// The font families that an SVG names: the viewer's own fonts, the ones most similar to the embedded one first.
pub(crate) const SVG_FAMILIES: &str = "DejaVu Sans, Verdana, sans-serif";

fn font() -> Option<&'static FontRef<'static>> {
    static FONT: OnceLock<Option<FontRef<'static>>> = OnceLock::new();
    FONT.get_or_init(|| FontRef::try_from_slice(BYTES).ok())
        .as_ref()
}

/// Glyphs side by side with kerning, the first at (0, 0) on the base line, and where the next would start.
fn lay_out(font: &FontRef<'static>, text: &str, size: f64) -> (Vec<Glyph>, f64) {
    // ab_glyph scales by the height of the line, typography by the em.
    let per_em = font.height_unscaled() / font.units_per_em().unwrap_or(2048.0);
    let scale = PxScale::from(size as f32 * per_em);
    let scaled = font.as_scaled(scale);
    let mut glyphs: Vec<Glyph> = Vec::new();
    let mut x = 0.0;
    for character in text.chars() {
        let id = font.glyph_id(character);
        if let Some(last) = glyphs.last() {
            x += scaled.kern(last.id, id);
        }
        glyphs.push(id.with_scale_and_position(scale, Point { x, y: 0.0 }));
        x += scaled.h_advance(id);
    }
    (glyphs, f64::from(x))
}

/// The width of `text` in the units of `size`, the height of the em.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    font().map_or(0.0, |font| lay_out(font, text, size).1)
}

/// Calls `draw(x, y, coverage)` for every pixel that `text` touches, x to the right and y down from the start
/// of its base line.
pub(crate) fn rasterise(text: &str, size: f64, mut draw: impl FnMut(i32, i32, f64)) {
    let Some(font) = font() else { return };
    for glyph in lay_out(font, text, size).0 {
        if let Some(outline) = font.outline_glyph(glyph) {
            let bounds = outline.px_bounds();
            let (left, top) = (bounds.min.x as i32, bounds.min.y as i32);
            outline.draw(|x, y, coverage| {
                draw(left + x as i32, top + y as i32, f64::from(coverage));
            });
        }
    }
}

/// `text` fitted into the width `room`: smaller down to `smallest`, then shortened with an ellipsis. Control characters, which no
/// picture can show and XML forbids, become spaces.
pub(crate) fn fit(text: &str, size: f64, smallest: f64, room: f64) -> (String, f64) {
    let text = printable(text);
    let full = width(&text, size);
    if full <= room {
        return (text, size);
    }
    let shrunk = (size * room / full).max(smallest);
    if width(&text, shrunk) <= room {
        return (text, shrunk);
    }
    let mut kept: Vec<char> = text.chars().take(1000).collect();
    loop {
        let candidate = format!("{}…", kept.iter().collect::<String>().trim_end());
        if kept.is_empty() || width(&candidate, smallest) <= room {
            return (candidate, smallest);
        }
        kept.pop();
    }
}

/// `text` with every character that XML 1.0 (section 2.2) or a line of text cannot hold made a space.
pub(crate) fn printable(text: &str) -> String {
    text.chars()
        .map(|c| {
            if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') {
                ' '
            } else {
                c
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_embedded_font_has_every_sign_the_pictures_use() {
        let font = font().expect("the embedded font is a font");
        for sign in "abc XYZ 0123456789 .,:;·µ×−–…≥≤⁰¹²³⁴⁵⁶⁷⁸⁹⁻\u{202f}αω()/%".chars()
        {
            assert_ne!(font.glyph_id(sign).0, 0, "{sign:?}");
        }
    }

    #[test]
    fn widths_grow_with_size_and_text() {
        assert_eq!(width("", 12.0), 0.0);
        let narrow = width("energy", 12.0);
        // DejaVu Sans: an average lower-case letter is about 0.6 em wide.
        assert!((30.0..55.0).contains(&narrow), "{narrow}");
        assert!((width("energy", 24.0) - 2.0 * narrow).abs() < 0.1);
    }

    #[test]
    fn long_titles_shrink_then_lose_their_end() {
        let (text, size) = fit("short", 24.0, 14.0, 300.0);
        assert_eq!((text.as_str(), size), ("short", 24.0));
        let (text, size) = fit("a title of some thirty letters", 24.0, 14.0, 300.0);
        assert!(size < 24.0 && text.ends_with("letters"));
        let (text, size) = fit(&"long ".repeat(500), 24.0, 14.0, 300.0);
        assert!(text.ends_with('…') && width(&text, size) <= 300.0);
        assert_eq!(fit("a\u{0}b\nc", 12.0, 12.0, 300.0).0, "a b c");
    }
}
