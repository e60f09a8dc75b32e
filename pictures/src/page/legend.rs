//! The key to the colours: bars for numbers, dots for categories.

use super::layout::Area;
use super::text_size;
use crate::canvas::{Anchor, Canvas, HALF_CAPITAL, Lettering, Stroke, frame};
use crate::colour::Colour;
use crate::colour_map::ColourMap;
use crate::font;
use crate::scale::{Ticks, Unit, short_number};
use crate::theme::Theme;

/// The key beside a picture.
#[derive(Debug, Clone, Default)]
pub(crate) struct Legend {
    pub(crate) bars: Vec<Bar>,
    pub(crate) heading: String,
    pub(crate) dots: Vec<(String, Colour)>,
    /// Categories beyond the dots: a legend of so many would be unreadable.
    pub(crate) more: usize,
}

/// A colour bar.
#[derive(Debug, Clone)]
pub(crate) struct Bar {
    pub(crate) label: String,
    pub(crate) unit: String,
    pub(crate) range: (f64, f64),
    pub(crate) map: ColourMap,
    /// Whether equal steps are equal ratios.
    pub(crate) logarithmic: bool,
    /// Whether there are values below and above the bar.
    pub(crate) beyond: (bool, bool),
}

/// Sizes on a page of 1200 x 900.
const BAR_WIDTH: f64 = 22.0;
const BAR_HEIGHT: f64 = 460.0;
const TICK: f64 = 5.0;
const LABEL: f64 = 15.0;
const NUMBER: f64 = 13.5;
const LINE: f64 = 25.0;
/// More dots than this may not fit; they are then counted in words, which need space.
const MANY: usize = 10;
/// The widest legend: longer texts are shortened.
const WIDEST: f64 = 230.0;

impl Legend {
    fn is_empty(&self) -> bool {
        self.bars.is_empty() && self.dots.is_empty()
    }

    /// The width it needs (pixels); 0 if there is nothing to show.
    pub(crate) fn width(&self, unit: f64) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let mut width = font::width(&self.heading, text_size(LABEL, unit));
        for bar in &self.bars {
            width = width.max(font::width(&bar.title().0, text_size(LABEL, unit)));
            for number in bar.numbers(6) {
                let text = font::width(&number.1, text_size(NUMBER, unit));
                width = width.max((BAR_WIDTH + 2.0 * TICK) * unit + text);
            }
        }
        for (name, _) in &self.dots {
            width = width.max(LINE * unit + font::width(name, text_size(NUMBER, unit)));
        }
        if self.more > 0 || self.dots.len() > MANY {
            let rest = format!("and {} more", self.dots.len() + self.more);
            width = width.max(font::width(&rest, text_size(NUMBER, unit)));
        }
        (width + 8.0 * unit).min(WIDEST * unit.max(0.6))
    }

    pub(super) fn draw(&self, canvas: &mut dyn Canvas, area: &Area, unit: f64, theme: &Theme) {
        if self.is_empty() {
            return;
        }
        let line = (LINE * unit).max(1.6 * text_size(NUMBER, unit));
        let heading = if self.heading.is_empty() { 0.0 } else { line };
        let full_list = heading + line * self.dots.len() as f64;
        // Bars first; those that would be too short to read are left out, the later ones first. Dots that do not fit are counted.
        let over = 2.6 * line;
        let for_bars = (area.height() - full_list).max(0.55 * area.height());
        let height = |bars: usize| (for_bars / bars as f64 - over - line).min(BAR_HEIGHT * unit);
        let shown = (1..=self.bars.len())
            .rev()
            .find(|bars| height(*bars) > 3.0 * line)
            .unwrap_or(0);
        let height = height(shown.max(1));
        let mut y = area.y0;
        if self.bars.len() == 1 && self.dots.len() < 4 {
            // One bar alone stands in the middle.
            y += (0.5 * (area.height() - height - over - full_list - line)).max(0.0);
        }
        for bar in &self.bars[..shown] {
            bar.draw(canvas, area, (y + over, y + over + height), unit, theme);
            y += over + height + line;
        }
        self.list(canvas, area, y, line, unit, theme);
    }

    fn list(
        &self,
        canvas: &mut dyn Canvas,
        area: &Area,
        y: f64,
        line: f64,
        unit: f64,
        theme: &Theme,
    ) {
        let mut y = y + 0.7 * line;
        if !self.heading.is_empty() {
            let size = text_size(LABEL, unit);
            let (text, size) = font::fit(&self.heading, size, size.min(9.0), area.width());
            let lettering = Lettering::new(size, theme.ink, Anchor::Start);
            canvas.text(&text, (area.x0, y), lettering);
            y += line;
        }
        let fits = ((area.y1 - y) / line + 1.0).max(0.0) as usize;
        let number = self.dots.len() + self.more;
        let shown = if number > fits {
            fits.saturating_sub(1).min(self.dots.len())
        } else {
            self.dots.len()
        };
        let size = text_size(NUMBER, unit);
        let radius = 0.55 * size;
        for (name, colour) in &self.dots[..shown] {
            let centre = (area.x0 + radius + 1.0, y - HALF_CAPITAL * size);
            canvas.disc(centre, radius, colour.lit(0.7));
            canvas.disc(centre, radius - 1.0, *colour);
            let x = area.x0 + 2.0 * radius + 0.6 * size;
            let (text, size) = font::fit(name, size, size.min(9.0), area.x1 - x);
            canvas.text(
                &text,
                (x, y),
                Lettering::new(size, theme.ink, Anchor::Start),
            );
            y += line;
        }
        if shown < number && fits > 0 {
            let text = format!("and {} more", number - shown);
            let (text, size) = font::fit(&text, size, size.min(9.0), area.width());
            let lettering = Lettering::new(size, theme.soft_ink, Anchor::Start);
            canvas.text(&text, (area.x0, y), lettering);
        }
    }
}

impl Bar {
    /// The unit that the numbers are in.
    fn scale(&self) -> Unit {
        let largest = self.range.0.abs().max(self.range.1.abs());
        if self.unit.is_empty() {
            return Unit {
                size: 1.0,
                name: String::new(),
            };
        }
        // Prefixes belong to single units: N is scaled to mN, kg/m³ and m² stay as they are.
        let plain = self.unit.chars().all(char::is_alphabetic) || self.unit == "m/s";
        if plain && self.unit != "kg" {
            Unit::not_above_plain(largest, &self.unit)
        } else {
            Unit {
                size: 1.0,
                name: self.unit.clone(),
            }
        }
    }

    /// The label with its unit, and the power of ten that all numbers have lost.
    fn title(&self) -> (String, f64) {
        let unit = self.scale();
        let largest = self.range.0.abs().max(self.range.1.abs()) / unit.size;
        let power = if (1e-3..1e6).contains(&largest) {
            None
        } else {
            crate::scale::decimal_exponent(largest).map(|e| e.div_euclid(3) * 3)
        };
        let factor = power.map_or(1.0, crate::scale::power_of_ten);
        let power = power.map(|e| format!("10{}", crate::scale::superscript(e)));
        let in_unit = match (power, unit.name.as_str()) {
            (None, "") => String::new(),
            (None, name) => format!(" ({name})"),
            (Some(power), "") => format!(" ({power})"),
            (Some(power), name) => format!(" ({power} {name})"),
        };
        (format!("{}{in_unit}", self.label), unit.size * factor)
    }

    /// Where along the bar (0 to 1) numbers stand.
    fn numbers(&self, count: usize) -> Vec<(f64, String)> {
        let (low, high) = self.range;
        let size = self.title().1;
        if self.logarithmic {
            let ticks = logarithmic_ticks(low / size, high / size, count);
            let place = |tick: f64| crate::value_range::logarithmic_share(tick * size, self.range);
            return (ticks.into_iter())
                .map(|tick| (place(tick), short_number(tick, 3)))
                .collect();
        }
        let ticks = Ticks::new(low / size, high / size, count);
        ticks
            .at
            .iter()
            .map(|tick| {
                (
                    crate::value_range::share(tick * size, self.range),
                    ticks.label(*tick),
                )
            })
            .collect()
    }

    /// Draws the bar between two heights.
    fn draw(
        &self,
        canvas: &mut dyn Canvas,
        area: &Area,
        (y0, y1): (f64, f64),
        unit: f64,
        theme: &Theme,
    ) {
        let (y0, y1) = (y0.round(), y1.round());
        let (x0, x1) = (area.x0, area.x0 + BAR_WIDTH * unit);
        let rows = (y1 - y0) as usize;
        for row in 0..rows {
            let y = y0 + row as f64;
            let value = 1.0 - (row as f64 + 0.5) / rows as f64;
            canvas.rectangle((x0, y), (x1, y + 1.0), self.map.colour(value));
        }
        let stroke = Stroke::solid(theme.soft_ink, unit.max(0.8));
        frame(canvas, (x0, y0), (x1, y1), stroke);
        let size = text_size(NUMBER, unit);
        // Numbers a line and a half apart at least.
        let count = ((y1 - y0) / (2.2 * size)).clamp(1.0, 6.0) as usize;
        for (place, label) in self.numbers(count) {
            let y = y1 - place * (y1 - y0);
            canvas.polyline(&[(x1, y), (x1 + TICK * unit, y)], stroke);
            let x = x1 + 2.0 * TICK * unit;
            let (label, size) = font::fit(&label, size, size.min(8.0), area.x1 - x);
            let at = (x, y + HALF_CAPITAL * size);
            canvas.text(&label, at, Lettering::new(size, theme.ink, Anchor::Start));
        }
        let (title, factor) = self.title();
        let size = text_size(LABEL, unit);
        let (title, size) = font::fit(&title, size, size.min(9.0), area.width());
        let lettering = Lettering::new(size, theme.ink, Anchor::Start);
        canvas.text(&title, (x0, y0 - 1.9 * size), lettering);
        let small = text_size(12.0, unit);
        let soft = Lettering::new(small, theme.soft_ink, Anchor::Start);
        let beyond = |sign: &str, value: f64| format!("{sign} {}", short_number(value / factor, 2));
        if self.beyond.1 {
            canvas.text(&beyond("≥", self.range.1), (x0, y0 - 0.6 * small), soft);
        }
        if self.beyond.0 {
            canvas.text(&beyond("≤", self.range.0), (x0, y1 + 1.3 * small), soft);
        }
    }
}

/// Powers of ten between two numbers above 0, at most so many, at equal distances; where there are fewer than two, their multiples by 2 and 5, too, and
/// where there are none of these, the ends.
fn logarithmic_ticks(low: f64, high: f64, count: usize) -> Vec<f64> {
    let exponent = |value: f64| crate::scale::decimal_exponent(value).unwrap_or(0);
    let exponents = exponent(low)..=exponent(high);
    let is_inside = |tick: &f64| *tick >= low * (1.0 - 1e-9) && *tick <= high * (1.0 + 1e-9);
    let powers = exponents.clone().map(crate::scale::power_of_ten);
    let powers: Vec<f64> = powers.filter(is_inside).collect();
    if powers.len() >= 2 {
        return powers
            .into_iter()
            .step_by(powers_apart(exponents.count(), count))
            .collect();
    }
    let multiples =
        exponents.flat_map(|e| [1.0, 2.0, 5.0].map(|m| m * crate::scale::power_of_ten(e)));
    let multiples: Vec<f64> = multiples.filter(is_inside).collect();
    if multiples.is_empty() {
        vec![low, high]
    } else {
        multiples
    }
}

/// Powers of ten from one number to the next.
fn powers_apart(powers: usize, most: usize) -> usize {
    powers.div_ceil(most.max(1)).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bar(unit: &str, low: f64, high: f64) -> Bar {
        Bar {
            label: "what".into(),
            unit: unit.into(),
            range: (low, high),
            map: ColourMap::Viridis,
            logarithmic: false,
            beyond: (false, false),
        }
    }

    #[test]
    fn a_logarithmic_bar_has_its_powers_of_ten_at_equal_distances() {
        let logarithmic = |low: f64, high: f64| Bar {
            logarithmic: true,
            ..bar("", low, high)
        };
        let close = |found: Vec<(f64, String)>, expected: &[(f64, &str)]| {
            assert_eq!(found.len(), expected.len(), "{found:?}");
            for ((place, label), (at, text)) in found.iter().zip(expected) {
                assert!((place - at).abs() < 1e-12 && label == text, "{found:?}");
            }
        };
        close(
            logarithmic(1e-3, 1.0).numbers(6),
            &[
                (0.0, "0.001"),
                (1.0 / 3.0, "0.01"),
                (2.0 / 3.0, "0.1"),
                (1.0, "1"),
            ],
        );
        // Less than a power of ten: 2 and 5 of it.
        let found = logarithmic(1.0, 8.0).numbers(6);
        let expected = |value: f64| value.ln() / 8f64.ln();
        close(
            found,
            &[(0.0, "1"), (expected(2.0), "2"), (expected(5.0), "5")],
        );
        // Twelve powers on a bar with space for six.
        assert_eq!(logarithmic(1e-6, 1e6).numbers(6).len(), 5);
    }

    #[test]
    fn labels_have_units_people_use() {
        for (unit, high, title) in [
            ("m/s", 0.2, "what (mm/s)"),
            ("m/s", 5.0, "what (m/s)"),
            ("N", 2e-6, "what (µN)"),
            ("", 12.0, "what"),
            ("", 3e9, "what (10⁹)"),
            ("kg", 2e-9, "what (10⁻⁹ kg)"),
            ("kg/m³", 2500.0, "what (kg/m³)"),
            ("J", 3e8, "what (10⁶ J)"),
        ] {
            assert_eq!(bar(unit, 0.0, high).title().0, title);
        }
    }

    #[test]
    fn ticks_cover_the_bar() {
        for (low, high) in [(0.0, 0.37), (-3.0, 3.0), (8.1e-7, 8.4e-7), (1e5, 3e9)] {
            let numbers = bar("N", low, high).numbers(6);
            let places: Vec<f64> = numbers.iter().map(|n| n.0).collect();
            // At most two steps are missing at the ends together.
            let step = places[1] - places[0];
            assert!(
                places[0] <= step && places[places.len() - 1] >= 1.0 - step,
                "{places:?}"
            );
            assert!(numbers.len() <= 7, "{numbers:?}");
        }
    }
}
