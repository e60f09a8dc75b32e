//! One chart on the page.

use plotters::chart::{ChartBuilder, ChartContext, LabelAreaPosition};
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::drawing::DrawingArea;
use plotters::style::{IntoFont, IntoTextStyle, ShapeStyle};

use super::board::{Board, ink, units, width_units};
use super::chart::{Chart, Legend, Note, Place, Shape};
use super::elements::{Area, Curve, Mark};
use super::heat::Bar;
use super::legend;
use super::look::{Look, looks};
use super::needs::{Lost, Needs};
use super::outline::Outline;
use super::palette::Marker;
use super::ruler::{Ruler, Span};
use crate::PictureError;
use crate::canvas::{Anchor, Canvas, Lettering, Spot, Stroke};
use crate::colour::Colour;
use crate::font;

/// Heights of letters (points): heading, titles of axes, numbers and legend, small print.
const HEADING: f64 = 13.5;
const TITLES: f64 = 12.5;
pub(super) const NUMBERS: f64 = 11.5;
const SMALL: f64 = 10.0;
/// No print is smaller.
const SMALLEST_PRINT: f64 = 7.0;
/// Length of a tick.
const TICK: f64 = 4.0;
/// Part of the lines below that shows through a band and a bar (1: nothing).
pub(super) const BAND: f64 = 0.2;
pub(super) const BARS: f64 = 0.35;
/// No chart is smaller than this between its axes (points).
const SMALLEST: f64 = 40.0;

/// The space around the part of a chart between its axes (points).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Margins {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

/// A chart whose axes have known ends.
pub(super) struct Panel<'a> {
    outline: Outline<'a>,
    looks: Vec<Look>,
    bar: Option<Bar>,
    /// Points that have a place, and points that have none.
    drawn: usize,
    lost: Lost,
}

impl<'a> Panel<'a> {
    pub(super) fn new(chart: &'a Chart) -> Self {
        let needs = Needs::of(chart);
        Self {
            outline: Outline {
                chart,
                x: Span::new(&chart.x, needs.x),
                y: Span::new(&chart.y, needs.y),
            },
            looks: looks(&chart.series),
            bar: chart.series.iter().find_map(|series| match &series.shape {
                Shape::Heat(heat) => Bar::new(heat),
                _ => None,
            }),
            drawn: needs.drawn,
            lost: needs.lost,
        }
    }

    /// Room that the panel needs around it, if it and its surroundings are `height` points high.
    pub(super) fn margins(&self, height: f64, legend: Legend) -> Margins {
        let heading = if self.outline.chart.title.is_empty() && self.lost.all() == 0 {
            8.0
        } else {
            1.9 * HEADING
        };
        let title = |text: &str| if text.is_empty() { 0.0 } else { 1.5 * TITLES };
        let bottom = 2.0 * TICK + 1.2 * NUMBERS + title(&self.outline.x.title());
        let between = (height - heading - bottom).max(SMALLEST);
        let numbers = self
            .outline
            .y
            .ruler(between, false, NUMBERS)
            .widest(NUMBERS);
        let left = 2.0 * TICK + numbers + title(&self.outline.y.title());
        let bar = self
            .bar
            .as_ref()
            .map_or(0.0, |bar| bar.room(between, NUMBERS));
        let beside = match legend {
            Legend::Right => {
                legend::size(self.outline.chart, NUMBERS).map_or(0.0, |(width, _)| width + 4.0)
            }
            _ => 0.0,
        };
        Margins {
            left,
            // The last number of the x axis may stick out.
            right: (bar + beside).max(1.6 * NUMBERS),
            top: heading,
            bottom,
        }
    }

    /// The space left free to the right and below, if the part between the axes has this size and the chart is to scale. No side
    /// becomes shorter than a chart may be.
    pub(super) fn free(&self, (width, height): Spot) -> Spot {
        let extents = (self.outline.x.extent(), self.outline.y.extent());
        let (true, (Some(x), Some(y))) = (self.outline.chart.to_scale, extents) else {
            return (0.0, 0.0);
        };
        let scale = (width / x).min(height / y);
        let side = |room: f64, extent: f64| (room - (scale * extent).max(SMALLEST)).max(0.0);
        (side(width, x), side(height, y))
    }

    /// Where the legend of the chart goes in a chart of this size between its axes.
    pub(super) fn legend(&self, (width, height): Spot) -> Legend {
        let Some((w, h)) = legend::size(self.outline.chart, NUMBERS) else {
            return Legend::None;
        };
        if self.outline.chart.legend != Legend::Auto {
            return self.outline.chart.legend;
        }
        let reach = (
            (w + 2.0 * legend::APART) / width,
            (h + 2.0 * legend::APART) / height,
        );
        if reach.0 > 0.75 || reach.1 > 0.9 {
            return Legend::Right;
        }
        let ink = self.outline.ink();
        let corners = [
            (
                Legend::UpperRight,
                Place::UpperRight,
                (1.0 - reach.0, 1.0 - reach.1),
            ),
            (Legend::UpperLeft, Place::UpperLeft, (0.0, 1.0 - reach.1)),
            (Legend::LowerRight, Place::LowerRight, (1.0 - reach.0, 0.0)),
            (Legend::LowerLeft, Place::LowerLeft, (0.0, 0.0)),
        ];
        let free = corners.into_iter().find(|(_, place, (x, y))| {
            self.outline
                .chart
                .notes
                .iter()
                .all(|note| note.place != *place)
                && !ink
                    .iter()
                    .any(|(a, b)| (*x..=x + reach.0).contains(a) && (*y..=y + reach.1).contains(b))
        });
        free.map_or(Legend::Right, |(legend, ..)| legend)
    }

    /// Draws everything but texts that are not numbers. `outside` is where it and its surroundings are.
    pub(super) fn draw(
        &self,
        root: &DrawingArea<Board<'_>, Shift>,
        (left, top): Spot,
        (width, height): Spot,
        margins: Margins,
    ) -> Result<(), PictureError> {
        let between = (
            width - margins.left - margins.right,
            height - margins.top - margins.bottom,
        );
        if between.0 < SMALLEST || between.1 < SMALLEST {
            return Err(PictureError::option(
                "page",
                format!(
                    "leaves {:.0} x {:.0} points for the chart \"{}\": make it larger",
                    between.0, between.1, self.outline.chart.title
                ),
            ));
        }
        let area = (root.clone()).shrink((units(left), units(top)), (units(width), units(height)));
        let (x, y) = (
            self.outline.x.ruler(between.0, true, NUMBERS),
            self.outline.y.ruler(between.1, false, NUMBERS),
        );
        let mut context = ChartBuilder::on(&area)
            .margin_top(units(margins.top))
            .margin_right(units(margins.right))
            .set_label_area_size(LabelAreaPosition::Left, units(margins.left))
            .set_label_area_size(LabelAreaPosition::Bottom, units(margins.bottom))
            .build_cartesian_2d(x, y)
            .map_err(failed)?;
        self.mesh(&mut context)?;
        self.fill(&context)
    }

    /// Grid, numbers, titles of axes.
    fn mesh(
        &self,
        context: &mut ChartContext<'_, Board<'_>, Cartesian2d<Ruler, Ruler>>,
    ) -> Result<(), PictureError> {
        let line = |colour, width| ShapeStyle {
            color: ink(colour, 1.0),
            filled: false,
            stroke_width: width_units(width),
        };
        let letters = |size: f64| {
            let colour = ink(Colour::INK, 1.0);
            ("sans-serif", f64::from(units(size)))
                .into_font()
                .color(&colour)
                .into_text_style(&(1, 1))
        };
        let mut mesh = context.configure_mesh();
        if self.bar.is_some() {
            // Lines would show through the empty cells of a map.
            mesh.disable_mesh();
        }
        mesh.bold_line_style(line(Colour::GRID, 0.8))
            .light_line_style(line(Colour(241, 243, 245), 0.6))
            .axis_style(line(Colour::SOFT_INK, 0.8))
            .label_style(letters(NUMBERS))
            .axis_desc_style(letters(TITLES))
            .set_all_tick_mark_size(units(TICK))
            .x_desc(self.outline.x.title())
            .y_desc(self.outline.y.title())
            .draw()
            .map_err(failed)
    }

    /// The series: areas first, then lines and points, then the frame.
    fn fill(
        &self,
        context: &ChartContext<'_, Board<'_>, Cartesian2d<Ruler, Ruler>>,
    ) -> Result<(), PictureError> {
        let area = context.plotting_area();
        let all = || self.outline.chart.series.iter().zip(&self.looks);
        for (series, look) in all() {
            if let (Shape::Heat(heat), Some(bar)) = (&series.shape, &self.bar) {
                area.draw(&bar.cells(heat, &self.outline.x, &self.outline.y))
                    .map_err(failed)?;
            }
            let bars = matches!(series.shape, Shape::Bars { .. });
            for points in self.outline.areas(series) {
                let outline = points.iter().chain(points.first()).copied().collect();
                let colour = look.stroke.colour;
                let opacity = if bars { BARS } else { BAND };
                area.draw(&Area {
                    points,
                    colour,
                    opacity,
                })
                .map_err(failed)?;
                if bars {
                    let stroke = Stroke::solid(colour, 0.8);
                    area.draw(&Curve {
                        points: outline,
                        stroke,
                    })
                    .map_err(failed)?;
                }
            }
        }
        for (series, look) in all() {
            for points in self.outline.lines(series) {
                let stroke = look.stroke;
                if let [at, only] = points[..]
                    && at == only
                {
                    // All that there is of a line with one point.
                    let (marker, colour) = (Marker::Disc, stroke.colour);
                    area.draw(&Mark { at, marker, colour }).map_err(failed)?;
                }
                area.draw(&Curve { points, stroke }).map_err(failed)?;
            }
            if let Shape::Points { at, errors } = &series.shape {
                for (point, reach) in at.iter().zip(errors) {
                    for points in self.outline.error_bars(*point, *reach, area.dim_in_pixel()) {
                        let stroke = Stroke::solid(look.stroke.colour, 1.0);
                        area.draw(&Curve { points, stroke }).map_err(failed)?;
                    }
                }
            }
            if let Shape::Points { at, .. } | Shape::MarkedLine(at) = &series.shape {
                for at in at.iter().filter_map(|point| self.outline.inside(*point)) {
                    let (marker, colour) = (look.marker, look.stroke.colour);
                    area.draw(&Mark { at, marker, colour }).map_err(failed)?;
                }
            }
        }
        let corners = vec![(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)];
        let stroke = Stroke::solid(Colour::SOFT_INK, 0.8);
        area.draw(&Curve {
            points: corners,
            stroke,
        })
        .map_err(failed)
    }

    /// Heading, legend, colour bar and notes; `between` are the corners of the part between the axes.
    pub(super) fn annotate(
        &self,
        canvas: &mut dyn Canvas,
        between: (Spot, Spot),
        right: f64,
        legend: Legend,
    ) {
        let ((x0, y0), (x1, y1)) = between;
        let heading = Lettering::new(HEADING, Colour::INK, Anchor::Start);
        let small = Lettering::new(SMALL, Colour::SOFT_INK, Anchor::End);
        let lost = self.lost.all();
        let lost = (lost > 0).then(|| {
            let text = format!(
                "{} of {} points not drawn: {}",
                crate::scale::count(lost),
                crate::scale::count(lost + self.drawn),
                self.lost.reasons()
            );
            font::fit(&text, SMALL, SMALLEST_PRINT, x1 - x0)
        });
        let room = right
            - x0
            - lost
                .as_ref()
                .map_or(0.0, |(text, size)| font::width(text, *size) + 12.0);
        let (title, size) = font::fit(&self.outline.chart.title, HEADING, 9.0, room);
        if !title.is_empty() {
            canvas.text(
                &title,
                (x0, y0 - 0.62 * HEADING),
                Lettering { size, ..heading },
            );
        }
        if let Some((text, size)) = lost {
            let small = Lettering { size, ..small };
            canvas.text(&text, (x1, y0 - 0.5 * SMALL), small);
        }
        let mut beside = x1;
        if let Some(bar) = &self.bar {
            bar.draw(canvas, x1, (y0, y1), NUMBERS);
            beside += bar.room(y1 - y0, NUMBERS);
        }
        if self.drawn == 0 {
            let at = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
            let style = Lettering::new(TITLES, Colour::SOFT_INK, Anchor::Middle);
            canvas.text(&self.outline.chart.when_empty, at, style);
        }
        for note in &self.outline.chart.notes {
            self.note(canvas, note, between);
        }
        let Some((width, height)) = legend::size(self.outline.chart, NUMBERS) else {
            return;
        };
        let (near, far) = (legend::APART, legend::APART);
        let corner = match legend {
            Legend::None | Legend::Auto => return,
            Legend::Right => (beside + 4.0, y0 - 0.5 * near),
            Legend::UpperLeft => (x0 + near, y0 + near),
            Legend::UpperRight => (x1 - far - width, y0 + near),
            Legend::LowerLeft => (x0 + near, y1 - far - height),
            Legend::LowerRight => (x1 - far - width, y1 - far - height),
        };
        legend::draw(
            canvas,
            self.outline.chart,
            &self.looks,
            corner,
            NUMBERS,
            legend != Legend::Right,
        );
    }

    /// The legend as rows, for all charts of a page.
    pub(super) fn legend_row(&self, canvas: &mut dyn Canvas, corner: Spot, width: f64) {
        legend::draw_row(
            canvas,
            self.outline.chart,
            &self.looks,
            corner,
            width,
            NUMBERS,
        );
    }

    fn note(&self, canvas: &mut dyn Canvas, note: &Note, ((x0, y0), (x1, y1)): (Spot, Spot)) {
        const LINE: f64 = 1.35 * NUMBERS;
        let lines: Vec<&str> = note.text.lines().collect();
        let tall = LINE * (lines.len() as f64 - 1.0);
        let (upper, lower) = (y0 + 8.0 + 0.8 * NUMBERS, y1 - 10.0 - tall);
        let (x, y, anchor) = match note.place {
            Place::UpperLeft => (x0 + 10.0, upper, Anchor::Start),
            Place::UpperRight => (x1 - 10.0, upper, Anchor::End),
            Place::LowerLeft => (x0 + 10.0, lower, Anchor::Start),
            Place::LowerRight => (x1 - 10.0, lower, Anchor::End),
            Place::At(x, y) => match self.outline.inside((x, y)) {
                Some((x, y)) => (
                    x0 + x * (x1 - x0) + 5.0,
                    y1 - y * (y1 - y0) - 5.0 - tall,
                    Anchor::Start,
                ),
                None => return,
            },
        };
        for (row, line) in lines.iter().enumerate() {
            let style = Lettering::new(NUMBERS, Colour::INK, anchor);
            canvas.text(line, (x, y + LINE * row as f64), style);
        }
    }
}

fn failed<E: std::error::Error + Send + Sync>(
    error: plotters::drawing::DrawingAreaErrorKind<E>,
) -> PictureError {
    PictureError::Chart(error.to_string())
}
