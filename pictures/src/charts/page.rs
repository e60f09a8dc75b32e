//! Charts on a page, and the page as files.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use plotters::drawing::IntoDrawingArea;

use super::board::Board;
use super::chart::{Chart, Legend};
use super::legend;
use super::panel::{Margins, NUMBERS, Panel};
use crate::canvas::{Anchor, Canvas, Lettering, Spot};
use crate::colour::Colour;
use crate::image::Image;
use crate::svg::Svg;
use crate::{PictureError, font};
use mercury_common::whole_file::write_whole;

/// Pixels of the PNG in a point of the page: 144 to an inch.
const PIXELS: f64 = 2.0;
/// Space around everything and between charts (points).
const MARGIN: f64 = 12.0;
const GAP: f64 = 14.0;
/// Heights of letters: title, the line below it.
const TITLE: f64 = 17.0;
const SUBTITLE: f64 = 12.5;
/// Sides of a page (points).
const SIDES: std::ops::RangeInclusive<f64> = 100.0..=10_000.0;

/// One chart or several, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartPage {
    /// Heading; empty: none.
    pub title: String,
    /// The line below it; empty: none.
    pub subtitle: String,
    /// Row by row.
    pub charts: Vec<Chart>,
    /// Charts in a row.
    pub columns: usize,
    /// Width and height in points; the PNG has twice as many pixels.
    pub size: (f64, f64),
    /// How the height is shared among rows; empty: evenly.
    pub row_shares: Vec<f64>,
    /// One legend below the headings, that of the first chart, instead of one in each.
    pub shared_legend: bool,
}

/// A chart and where it is.
struct Placed<'a> {
    panel: Panel<'a>,
    corner: Spot,
    size: Spot,
    margins: Margins,
    legend: Legend,
}

impl ChartPage {
    /// One chart alone.
    #[must_use]
    pub fn of(chart: Chart) -> Self {
        Self {
            title: String::new(),
            subtitle: String::new(),
            charts: vec![chart],
            columns: 1,
            size: (620.0, 400.0),
            row_shares: Vec::new(),
            shared_legend: false,
        }
    }

    /// Charts in rows of `columns`, each about as large as one that stands alone on half a page.
    #[must_use]
    pub fn new(title: &str, columns: usize, charts: Vec<Chart>) -> Self {
        let columns = columns.max(1);
        let rows = charts.len().div_ceil(columns) as f64;
        let wide = if columns == 1 {
            620.0
        } else {
            400.0 * columns as f64
        };
        Self {
            title: title.into(),
            subtitle: String::new(),
            charts,
            columns,
            size: (wide, 40.0 + 300.0 * rows),
            row_shares: Vec::new(),
            shared_legend: false,
        }
    }

    /// This page in another size (points).
    #[must_use]
    pub fn size(mut self, width: f64, height: f64) -> Self {
        self.size = (width, height);
        self
    }

    /// Writes `<stem>.svg` and `<stem>.png`, each as a whole or not at all.
    ///
    /// # Errors
    /// For a page that cannot be drawn, as one with a chart whose lists do not match, and if a file cannot be written.
    pub fn write(&self, stem: &Path) -> Result<(), PictureError> {
        let (svg, png) = (self.svg()?, self.image()?.png()?);
        write_whole(&with_ending(stem, ".svg"), svg.as_bytes())?;
        Ok(write_whole(&with_ending(stem, ".png"), &png)?)
    }

    /// Writes the page as SVG.
    ///
    /// # Errors
    /// As [`ChartPage::write`].
    pub fn write_svg(&self, path: &Path) -> Result<(), PictureError> {
        Ok(write_whole(path, self.svg()?.as_bytes())?)
    }

    /// Writes the page as PNG.
    ///
    /// # Errors
    /// As [`ChartPage::write`].
    pub fn write_png(&self, path: &Path) -> Result<(), PictureError> {
        Ok(write_whole(path, &self.image()?.png()?)?)
    }

    /// The page as an SVG document.
    ///
    /// # Errors
    /// For a page that cannot be drawn.
    pub fn svg(&self) -> Result<String, PictureError> {
        let placed = self.layout()?;
        let titles = [&self.title, &self.subtitle];
        let headings = titles
            .into_iter()
            .chain(self.charts.iter().map(|chart| &chart.title));
        let mut headings = headings.filter(|text| !text.is_empty());
        let title = headings.next().map_or("Chart", String::as_str);
        let rest: Vec<&str> = headings.map(String::as_str).collect();
        let mut svg = Svg::sized(self.size, Some(Colour::WHITE), title, &rest.join("; "));
        self.draw(&placed, &mut svg)?;
        Ok(svg.finish())
    }

    /// The page as pixels.
    ///
    /// # Errors
    /// For a page that cannot be drawn.
    pub fn image(&self) -> Result<Image, PictureError> {
        let placed = self.layout()?;
        let pixels = |points: f64| (PIXELS * points).ceil() as u32;
        let (width, height) = (pixels(self.size.0), pixels(self.size.1));
        let mut image = Image::new(width, height, Some(Colour::WHITE));
        self.draw(&placed, &mut image.enlarged(PIXELS))?;
        Ok(image)
    }

    fn check(&self) -> Result<(), PictureError> {
        let fault = |problem: String| Err(PictureError::option("page", problem));
        if self.charts.is_empty() || self.columns == 0 {
            return fault("has no charts".into());
        }
        if !SIDES.contains(&self.size.0) || !SIDES.contains(&self.size.1) {
            let (width, height) = self.size;
            return fault(format!(
                "is {width} x {height} points large, expected {} to {} each",
                SIDES.start(),
                SIDES.end()
            ));
        }
        let rows = self.charts.len().div_ceil(self.columns);
        let shares = &self.row_shares;
        if !shares.is_empty()
            && (shares.len() != rows || !shares.iter().all(|s| *s > 0.0 && s.is_finite()))
        {
            return fault(format!("needs {rows} positive row_shares, one a row"));
        }
        match self.charts.iter().find_map(Chart::fault) {
            Some(problem) => Err(PictureError::Chart(problem)),
            None => Ok(()),
        }
    }

    /// Height of title, the line below it and the shared legend.
    fn heading(&self) -> f64 {
        let lines = [(&self.title, TITLE), (&self.subtitle, SUBTITLE)];
        let lines = lines.iter().filter(|(text, _)| !text.is_empty());
        lines.map(|(_, size)| 1.5 * size).sum::<f64>() + self.legend_height()
    }

    fn legend_height(&self) -> f64 {
        match self.charts.first() {
            Some(chart) if self.shared_legend => {
                legend::row_height(chart, self.size.0 - 2.0 * MARGIN, NUMBERS) + 4.0
            }
            _ => 0.0,
        }
    }

    fn layout(&self) -> Result<Vec<Placed<'_>>, PictureError> {
        self.check()?;
        let columns = self.columns.min(self.charts.len());
        let rows = self.charts.len().div_ceil(columns);
        let top = MARGIN + self.heading();
        let width = (self.size.0 - 2.0 * MARGIN - GAP * (columns as f64 - 1.0)) / columns as f64;
        let heights = self.size.1 - top - MARGIN - GAP * (rows as f64 - 1.0);
        let shares = match self.row_shares.as_slice() {
            [] => vec![1.0; rows],
            shares => shares.to_vec(),
        };
        let sum: f64 = shares.iter().sum();
        let tall: Vec<f64> = shares.iter().map(|share| heights * share / sum).collect();
        let mut placed: Vec<Placed> = (self.charts.iter().enumerate())
            .map(|(number, chart)| {
                let (row, column) = (number / columns, number % columns);
                let above: f64 = tall[..row].iter().sum();
                let size = (width, tall[row]);
                let panel = Panel::new(chart);
                let between = |margins: Margins| {
                    let (across, up) = (margins.left + margins.right, margins.top + margins.bottom);
                    ((size.0 - across).max(1.0), (size.1 - up).max(1.0))
                };
                let legend = if self.shared_legend {
                    Legend::None
                } else {
                    panel.legend(between(panel.margins(size.1, Legend::None)))
                };
                Placed {
                    margins: panel.margins(size.1, legend),
                    panel,
                    corner: (
                        MARGIN + (width + GAP) * column as f64,
                        top + above + GAP * row as f64,
                    ),
                    size,
                    legend,
                }
            })
            .collect();
        // Charts above each other begin and end on one line.
        for column in 0..columns {
            let of = || (column..placed.len()).step_by(columns);
            let left = of().map(|k| placed[k].margins.left).fold(0.0, f64::max);
            let right = of().map(|k| placed[k].margins.right).fold(0.0, f64::max);
            for k in of().collect::<Vec<_>>() {
                (placed[k].margins.left, placed[k].margins.right) = (left, right);
            }
        }
        for one in &mut placed {
            let margins = one.margins;
            let (right, below) = one.panel.free((
                one.size.0 - margins.left - margins.right,
                one.size.1 - margins.top - margins.bottom,
            ));
            // The title of the x axis stands at the lower end of its margin, so that the chart ends above what is free.
            one.margins.right += right;
            one.size.1 -= below;
        }
        Ok(placed)
    }

    fn draw(&self, placed: &[Placed], canvas: &mut dyn Canvas) -> Result<(), PictureError> {
        let room = self.size.0 - 2.0 * MARGIN;
        let start = |colour, size| Lettering::new(size, colour, Anchor::Start);
        let mut y = MARGIN;
        for (text, size, colour) in [
            (&self.title, TITLE, Colour::INK),
            (&self.subtitle, SUBTITLE, Colour::SOFT_INK),
        ] {
            if !text.is_empty() {
                let (text, fitting) = font::fit(text, size, 0.6 * size, room);
                canvas.text(&text, (MARGIN, y + 0.95 * size), start(colour, fitting));
                y += 1.5 * size;
            }
        }
        if let (true, Some(first)) = (self.shared_legend, placed.first()) {
            first.panel.legend_row(canvas, (MARGIN, y), room);
        }
        for one in placed {
            {
                let root = Board::new(&mut *canvas, self.size).into_drawing_area();
                one.panel.draw(&root, one.corner, one.size, one.margins)?;
            }
            let (margins, (x, y)) = (one.margins, one.corner);
            let right = x + one.size.0;
            let between = (
                (x + margins.left, y + margins.top),
                (right - margins.right, y + one.size.1 - margins.bottom),
            );
            one.panel.annotate(canvas, between, right, one.legend);
        }
        Ok(())
    }
}

/// `<stem><ending>`, where `Path::with_extension` would eat a part of a stem with dots.
fn with_ending(stem: &Path, ending: &str) -> PathBuf {
    let mut name: OsString = stem.as_os_str().to_os_string();
    name.push(ending);
    name.into()
}
