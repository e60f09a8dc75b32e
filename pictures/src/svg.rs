//! The page as SVG.

use super::canvas::{Anchor, Canvas, Lettering, Spot, Stroke};
use super::colour::Colour;
use super::font;
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD as STANDARD;
use std::fmt::Write as _;

/// An SVG document under construction.
pub(crate) struct Svg {
    text: String,
}

impl Svg {
    /// A page of this width and height and of this colour; none: transparent.
    pub(crate) fn sized(
        (width, height): Spot,
        paper: Option<Colour>,
        title: &str,
        description: &str,
    ) -> Self {
        let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        let _ = writeln!(
            text,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"{}\">",
            font::SVG_FAMILIES
        );
        let _ = writeln!(text, "<title>{}</title>", escaped(&font::printable(title)));
        let _ = writeln!(
            text,
            "<desc>{}</desc>",
            escaped(&font::printable(description))
        );
        let mut svg = Self { text };
        if let Some(paper) = paper {
            svg.rectangle((0.0, 0.0), (width, height), paper);
        }
        svg
    }

    /// Adds a PNG file that covers the page.
    pub(crate) fn picture(&mut self, (width, height): Spot, png: &[u8]) {
        let _ = write!(
            self.text,
            "<image width=\"{width}\" height=\"{height}\" href=\"data:image/png;base64,"
        );
        STANDARD.encode_string(png, &mut self.text);
        self.text.push_str("\"/>\n");
    }

    fn points(&mut self, points: &[Spot]) {
        for (place, (x, y)) in points.iter().enumerate() {
            let gap = if place == 0 { "" } else { " " };
            let _ = write!(self.text, "{gap}{},{}", short(*x), short(*y));
        }
    }

    /// The finished document.
    pub(crate) fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }
}

/// `text` with the characters that mean something in XML replaced.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            other => out.push(other),
        }
    }
    out
}

/// A coordinate to a hundredth of a point, without trailing zeros: finer than any screen, and half the bytes.
fn short(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".into()
    } else {
        text.into()
    }
}

impl Canvas for Svg {
    fn polyline(&mut self, points: &[Spot], stroke: Stroke) {
        if points.len() < 2 {
            return;
        }
        self.text
            .push_str("<polyline fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\"");
        let _ = write!(
            self.text,
            " stroke=\"{}\" stroke-width=\"{}\"",
            stroke.colour.hex(),
            short(stroke.width)
        );
        if !stroke.dashes.is_empty() {
            let dashes: Vec<String> = stroke.dashes.iter().map(|d| short(*d)).collect();
            let _ = write!(self.text, " stroke-dasharray=\"{}\"", dashes.join(" "));
        }
        self.text.push_str(" points=\"");
        self.points(points);
        self.text.push_str("\"/>\n");
    }

    fn rectangle(&mut self, (x0, y0): Spot, (x1, y1): Spot, fill: Colour) {
        let _ = writeln!(
            self.text,
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>",
            short(x0),
            short(y0),
            short(x1 - x0),
            short(y1 - y0),
            fill.hex()
        );
    }

    fn disc(&mut self, (x, y): Spot, radius: f64, fill: Colour) {
        let _ = writeln!(
            self.text,
            "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\"/>",
            short(x),
            short(y),
            short(radius),
            fill.hex()
        );
    }

    fn area(&mut self, corners: &[Spot], fill: Colour, opacity: f64) {
        let _ = write!(self.text, "<polygon fill=\"{}\"", fill.hex());
        if opacity < 1.0 {
            let _ = write!(self.text, " fill-opacity=\"{}\"", short(opacity));
        }
        self.text.push_str(" points=\"");
        self.points(corners);
        self.text.push_str("\"/>\n");
    }

    fn cells(&mut self, cells: &[(Spot, Spot, Colour)]) {
        self.text.push_str("<g shape-rendering=\"crispEdges\">\n");
        for (upper_left, lower_right, fill) in cells {
            self.rectangle(*upper_left, *lower_right, *fill);
        }
        self.text.push_str("</g>\n");
    }

    fn text(&mut self, text: &str, (x, y): Spot, lettering: Lettering) {
        let anchor = match lettering.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let turn = if lettering.upright {
            format!(" transform=\"rotate(-90 {} {})\"", short(x), short(y))
        } else {
            String::new()
        };
        let _ = writeln!(
            self.text,
            "<text x=\"{}\" y=\"{}\" font-size=\"{}\" text-anchor=\"{anchor}\" fill=\"{}\"{turn}>{}</text>",
            short(x),
            short(y),
            short(lettering.size),
            lettering.colour.hex(),
            escaped(&font::printable(text))
        );
    }
}
