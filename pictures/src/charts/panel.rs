//! One chart on the page.

use plotters::chart::{ChartBuilder, ChartContext, LabelAreaPosition};
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::drawing::DrawingArea;
use plotters::style::{IntoFont, IntoTextStyle, ShapeStyle};

use super::axis::Axis;
use super::board::{Board, ink, units, width_units};
use super::chart::{Chart, Legend, Note, Place, Series, Shape};
use super::clip::{self, Shares};
use super::elements::{Area, Curve, Mark};
use super::heat::Bar;
use super::legend;
use super::palette::{Dash, Hue, Marker};
use super::ruler::{Need, Ruler, Span};
use crate::PictureError;
use crate::canvas::{Anchor, Canvas, Lettering, Spot, Stroke};
use crate::colour::Colour;
use crate::font;

/// Heights of letters (points): heading, titles of axes, numbers and legend, small print.
const HEADING: f64 = 13.5;
const TITLES: f64 = 12.5;
pub(super) const NUMBERS: f64 = 11.5;
const SMALL: f64 = 10.0;
/// Length of a tick.
const TICK: f64 = 4.0;
/// How much of what lies below shows through a band and a bar (1: nothing).
pub(super) const BAND: f64 = 0.2;
pub(super) const BARS: f64 = 0.35;
/// Half the width of the end of an error bar (points).
const CAP: f64 = 2.2;
/// No chart is smaller than this between its axes (points).
const SMALLEST: f64 = 40.0;

/// How a series looks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    pub(super) stroke: Stroke,
    pub(super) marker: Marker,
}

/// The look of each series: what it says itself, else the next of each cycle.
fn looks(series: &[Series]) -> Vec<Look> {
    let (mut hues, mut dashes, mut markers) = (
        Hue::CYCLE.iter().cycle(),
        Dash::CYCLE.iter().cycle(),
        Marker::CYCLE.iter().cycle(),
    );
    let mut last = Hue::Blue;
    let one = |one: &Series| {
        let follows = matches!(one.shape, Shape::Band { .. } | Shape::Heat(_));
        let hue = one.hue.unwrap_or_else(|| {
            if follows {
                last
            } else {
                *hues.next().unwrap_or(&Hue::Ink)
            }
        });
        last = hue;
        let lines = matches!(one.shape, Shape::Line(_) | Shape::Steps(_));
        let dash = match one.dash {
            Some(dash) => dash,
            None if lines => *dashes.next().unwrap_or(&Dash::Solid),
            None => Dash::Solid,
        };
        let points = matches!(one.shape, Shape::Points { .. } | Shape::MarkedLine(_));
        let marker = match one.marker {
            Some(marker) => marker,
            None if points => *markers.next().unwrap_or(&Marker::Disc),
            None => Marker::Disc,
        };
        Look {
            stroke: Stroke {
                colour: hue.colour(),
                width: one.width,
                dashes: dash.lengths(),
            },
            marker,
        }
    };
    series.iter().map(one).collect()
}

/// The space around the part of a chart between its axes (points).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Margins {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

/// A chart whose axes know their ends.
pub(super) struct Panel<'a> {
    chart: &'a Chart,
    x: Span,
    y: Span,
    looks: Vec<Look>,
    bar: Option<Bar>,
    /// Points that have a place, and points that have none.
    drawn: usize,
    lost: usize,
}

impl<'a> Panel<'a> {
    pub(super) fn new(chart: &'a Chart) -> Self {
        let needs = Needs::of(chart);
        Self {
            x: Span::new(&chart.x, needs.x),
            y: Span::new(&chart.y, needs.y),
            looks: looks(&chart.series),
            bar: chart.series.iter().find_map(|series| match &series.shape {
                Shape::Heat(heat) => Bar::new(heat),
                _ => None,
            }),
            drawn: needs.drawn,
            lost: needs.lost,
            chart,
        }
    }

    /// What it needs around it, if it and its surroundings are `height` points high.
    pub(super) fn margins(&self, height: f64, legend: Legend) -> Margins {
        let heading = if self.chart.title.is_empty() && self.lost == 0 {
            8.0
        } else {
            1.9 * HEADING
        };
        let title = |text: &str| if text.is_empty() { 0.0 } else { 1.5 * TITLES };
        let bottom = 2.0 * TICK + 1.2 * NUMBERS + title(&self.x.title());
        let between = (height - heading - bottom).max(SMALLEST);
        let numbers = self.y.ruler(between, false, NUMBERS).widest(NUMBERS);
        let left = 2.0 * TICK + numbers + title(&self.y.title());
        let bar = self
            .bar
            .as_ref()
            .map_or(0.0, |bar| bar.room(between, NUMBERS));
        let beside = match legend {
            Legend::Right => {
                legend::size(self.chart, NUMBERS).map_or(0.0, |(width, _)| width + 4.0)
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

    /// Where the legend of the chart goes in a chart of this size between its axes.
    pub(super) fn legend(&self, (width, height): Spot) -> Legend {
        let Some((w, h)) = legend::size(self.chart, NUMBERS) else {
            return Legend::None;
        };
        if self.chart.legend != Legend::Auto {
            return self.chart.legend;
        }
        let reach = (
            (w + 2.0 * legend::APART) / width,
            (h + 2.0 * legend::APART) / height,
        );
        if reach.0 > 0.75 || reach.1 > 0.9 {
            return Legend::Right;
        }
        let ink = self.ink();
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
            self.chart.notes.iter().all(|note| note.place != *place)
                && !ink
                    .iter()
                    .any(|(a, b)| (*x..=x + reach.0).contains(a) && (*y..=y + reach.1).contains(b))
        });
        free.map_or(Legend::Right, |(legend, ..)| legend)
    }

    /// Places (shares) that a legend should leave free.
    fn ink(&self) -> Vec<(f64, f64)> {
        const APART: f64 = 0.015;
        let mut ink = Vec::new();
        let mut along = |from: (f64, f64), to: (f64, f64)| {
            let length = (to.0 - from.0).abs().max((to.1 - from.1).abs());
            let steps = (length / APART).ceil().max(1.0);
            for step in 0..=steps as usize {
                let t = step as f64 / steps;
                ink.push((from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1)));
            }
        };
        for series in &self.chart.series {
            for line in self.lines(series) {
                line.windows(2).for_each(|pair| along(pair[0], pair[1]));
            }
            for area in self.areas(series) {
                // From each corner through the area to its opposite: dense enough for bands and bars.
                let number = area.len();
                (0..number / 2).for_each(|k| along(area[k], area[number - 1 - k]));
            }
            if let Shape::Points { at, .. } | Shape::MarkedLine(at) = &series.shape {
                let spots = at.iter().filter_map(|point| self.inside(*point));
                spots.for_each(|spot| along(spot, spot));
            }
            if matches!(series.shape, Shape::Heat(_)) {
                (0..64).for_each(|k| along((0.0, f64::from(k) / 63.0), (1.0, f64::from(k) / 63.0)));
            }
        }
        ink
    }

    fn share(&self, (x, y): (f64, f64)) -> Shares {
        Some((self.x.share(x)?, self.y.share(y)?))
    }

    /// The place of a point, beyond the ends if it is infinitely far.
    fn reach(&self, (x, y): (f64, f64)) -> Shares {
        Some((self.x.reach(x)?, self.y.reach(y)?))
    }

    /// The place of a point of a line. On axes of shares it leaves the chart towards 0 and 1; where a value has no logarithm it ends.
    fn on_line(&self, (x, y): (f64, f64)) -> Shares {
        let place = |axis: &Axis, span: &Span, value| {
            if axis.scale.is_share() {
                span.reach(value)
            } else {
                span.share(value)
            }
        };
        Some((
            place(&self.chart.x, &self.x, x)?,
            place(&self.chart.y, &self.y, y)?,
        ))
    }

    fn inside(&self, point: (f64, f64)) -> Shares {
        let at = self.share(point)?;
        let within = |share: f64| (-1e-9..=1.0 + 1e-9).contains(&share);
        (within(at.0) && within(at.1)).then_some(at)
    }

    /// The lines of a series inside the chart.
    fn lines(&self, series: &Series) -> Vec<Vec<(f64, f64)>> {
        match &series.shape {
            Shape::Line(points) | Shape::MarkedLine(points) => {
                let line = clip::line(points.iter().map(|point| self.on_line(*point)));
                // A line of one point is a dot.
                match points.as_slice() {
                    [only] => self
                        .inside(*only)
                        .map(|at| vec![at, at])
                        .into_iter()
                        .collect(),
                    _ => line,
                }
            }
            Shape::Steps(points) => {
                let mut corners: Vec<Shares> = Vec::with_capacity(2 * points.len());
                for point in points {
                    let at = self.on_line(*point);
                    if let (Some(Some((_, before))), Some((x, _))) = (corners.last(), at) {
                        corners.push(Some((x, *before)));
                    }
                    corners.push(at);
                }
                clip::line(corners.into_iter())
            }
            Shape::Level(y) => {
                let share = self.y.share(*y);
                clip::line([0.0, 1.0].map(|x| share.map(|y| (x, y))).into_iter())
            }
            Shape::Upright(x) => {
                let share = self.x.share(*x);
                clip::line([0.0, 1.0].map(|y| share.map(|x| (x, y))).into_iter())
            }
            Shape::Points { .. } | Shape::Band { .. } | Shape::Bars { .. } | Shape::Heat(_) => {
                Vec::new()
            }
        }
    }

    /// The areas of a series inside the chart.
    fn areas(&self, series: &Series) -> Vec<Vec<(f64, f64)>> {
        match &series.shape {
            Shape::Band { lower, upper } => {
                let pairs: Vec<(Shares, Shares)> = (lower.iter().zip(upper))
                    .map(|(low, high)| (self.reach(*low), self.reach(*high)))
                    .collect();
                let whole = |pair: &(Shares, Shares)| pair.0.is_some() && pair.1.is_some();
                pairs
                    .chunk_by(|a, b| whole(a) && whole(b))
                    .filter(|run| run.len() > 1)
                    .map(|run| {
                        let there = run.iter().filter_map(|pair| pair.0);
                        let back = run.iter().rev().filter_map(|pair| pair.1);
                        clip::area(there.chain(back).collect())
                    })
                    .collect()
            }
            Shape::Bars { edges, heights } => (edges.windows(2).zip(heights))
                .filter_map(|(edge, height)| {
                    let (left, top) = self.share((edge[0], *height))?;
                    let right = self.x.share(edge[1])?;
                    let foot = self.y.reach(0.0)?;
                    let bar = [(left, foot), (left, top), (right, top), (right, foot)];
                    Some(clip::area(bar.to_vec()))
                })
                .collect(),
            _ => Vec::new(),
        }
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
                    between.0, between.1, self.chart.title
                ),
            ));
        }
        let area = (root.clone()).shrink((units(left), units(top)), (units(width), units(height)));
        let (x, y) = (
            self.x.ruler(between.0, true, NUMBERS),
            self.y.ruler(between.1, false, NUMBERS),
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
            .x_desc(self.x.title())
            .y_desc(self.y.title())
            .draw()
            .map_err(failed)
    }

    /// The series: areas first, then lines and points, then the frame.
    fn fill(
        &self,
        context: &ChartContext<'_, Board<'_>, Cartesian2d<Ruler, Ruler>>,
    ) -> Result<(), PictureError> {
        let area = context.plotting_area();
        let all = || self.chart.series.iter().zip(&self.looks);
        for (series, look) in all() {
            if let (Shape::Heat(heat), Some(bar)) = (&series.shape, &self.bar) {
                area.draw(&bar.cells(heat, &self.x, &self.y))
                    .map_err(failed)?;
            }
            let bars = matches!(series.shape, Shape::Bars { .. });
            for points in self.areas(series) {
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
            for points in self.lines(series) {
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
                    for points in self.error_bars(*point, *reach, area.dim_in_pixel()) {
                        let stroke = Stroke::solid(look.stroke.colour, 1.0);
                        area.draw(&Curve { points, stroke }).map_err(failed)?;
                    }
                }
            }
            if let Shape::Points { at, .. } | Shape::MarkedLine(at) = &series.shape {
                for at in at.iter().filter_map(|point| self.inside(*point)) {
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

    /// The lines of a point's error bars with their ends.
    fn error_bars(
        &self,
        (x, y): (f64, f64),
        (dx, dy): (f64, f64),
        (width, height): (u32, u32),
    ) -> Vec<Vec<(f64, f64)>> {
        let cap = (
            f64::from(units(CAP)) / f64::from(width),
            f64::from(units(CAP)) / f64::from(height),
        );
        let mut lines: Vec<Vec<Shares>> = Vec::new();
        let mut bar = |ends: [Shares; 2], (cx, cy): (f64, f64)| {
            lines.push(ends.to_vec());
            for (a, b) in ends.into_iter().flatten() {
                lines.push(vec![Some((a - cx, b - cy)), Some((a + cx, b + cy))]);
            }
        };
        if dx > 0.0
            && let Some(y) = self.y.share(y)
        {
            bar(
                [x - dx, x + dx].map(|x| Some((self.x.reach(x)?, y))),
                (0.0, cap.1),
            );
        }
        if dy > 0.0
            && let Some(x) = self.x.share(x)
        {
            bar(
                [y - dy, y + dy].map(|y| Some((x, self.y.reach(y)?))),
                (cap.0, 0.0),
            );
        }
        lines
            .into_iter()
            .flat_map(|line| clip::line(line.into_iter()))
            .collect()
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
        let lost = (self.lost > 0).then(|| {
            format!(
                "{} of {} points not drawn",
                crate::scale::count(self.lost),
                crate::scale::count(self.lost + self.drawn)
            )
        });
        let room = right
            - x0
            - lost
                .as_ref()
                .map_or(0.0, |text| font::width(text, SMALL) + 12.0);
        let (title, size) = font::fit(&self.chart.title, HEADING, 9.0, room);
        if !title.is_empty() {
            canvas.text(
                &title,
                (x0, y0 - 0.62 * HEADING),
                Lettering { size, ..heading },
            );
        }
        if let Some(text) = lost {
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
            canvas.text(&self.chart.when_empty, at, style);
        }
        for note in &self.chart.notes {
            self.note(canvas, note, between);
        }
        let Some((width, height)) = legend::size(self.chart, NUMBERS) else {
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
            self.chart,
            &self.looks,
            corner,
            NUMBERS,
            legend != Legend::Right,
        );
    }

    /// The legend as rows, for all charts of a page.
    pub(super) fn legend_row(&self, canvas: &mut dyn Canvas, corner: Spot, width: f64) {
        legend::draw_row(canvas, self.chart, &self.looks, corner, width, NUMBERS);
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
            Place::At(x, y) => match self.inside((x, y)) {
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

/// What all series need of both axes.
struct Needs {
    x: Need,
    y: Need,
    drawn: usize,
    lost: usize,
}

impl Needs {
    fn of(chart: &Chart) -> Self {
        let mut needs = Self {
            x: Need {
                values: None,
                tight: true,
            },
            y: Need {
                values: None,
                tight: false,
            },
            drawn: 0,
            lost: 0,
        };
        let (mut rightwards, mut upwards, mut lines) = (true, true, false);
        for series in &chart.series {
            match &series.shape {
                Shape::Line(points) | Shape::Steps(points) => {
                    needs.points(chart, points);
                    rightwards &= points.is_sorted_by(|a, b| a.0 <= b.0);
                    upwards &= points.is_sorted_by(|a, b| a.1 <= b.1);
                    lines = true;
                }
                Shape::Band { lower, upper } => {
                    needs.points(chart, lower);
                    needs.points(chart, upper);
                    rightwards &= lower.is_sorted_by(|a, b| a.0 <= b.0);
                    upwards &= lower.is_sorted_by(|a, b| a.1 <= b.1);
                    lines = true;
                }
                Shape::MarkedLine(points) => {
                    needs.points(chart, points);
                    (rightwards, upwards) = (false, false);
                }
                Shape::Points { at, errors } => {
                    needs.points(chart, at);
                    for ((x, y), (dx, dy)) in at.iter().zip(errors) {
                        [x - dx, x + dx]
                            .iter()
                            .for_each(|x| needs.x.add(&chart.x, *x));
                        [y - dy, y + dy]
                            .iter()
                            .for_each(|y| needs.y.add(&chart.y, *y));
                    }
                    (rightwards, upwards) = (false, false);
                }
                Shape::Bars { edges, heights } => {
                    edges.iter().for_each(|x| needs.x.add(&chart.x, *x));
                    heights
                        .iter()
                        .chain([&0.0])
                        .for_each(|y| needs.y.add(&chart.y, *y));
                    let drawn = heights.iter().filter(|height| height.is_finite()).count();
                    needs.drawn += drawn;
                    needs.lost += heights.len() - drawn;
                    (rightwards, upwards) = (false, false);
                }
                Shape::Level(y) => needs.y.add(&chart.y, *y),
                Shape::Upright(x) => needs.x.add(&chart.x, *x),
                Shape::Heat(heat) => {
                    heat.x_edges.iter().for_each(|x| needs.x.add(&chart.x, *x));
                    heat.y_edges.iter().for_each(|y| needs.y.add(&chart.y, *y));
                    needs.drawn += heat.values.iter().filter(|v| v.is_finite()).count();
                    needs.y.tight = true;
                }
            }
        }
        needs.x.tight = rightwards;
        needs.y.tight |= lines && upwards && !rightwards;
        needs
    }

    fn points(&mut self, chart: &Chart, points: &[(f64, f64)]) {
        for (x, y) in points {
            let infinite =
                |axis: &Axis, value: f64| axis.scale.is_share() && (value == 0.0 || value == 1.0);
            let there = |axis: &Axis, value: f64| {
                axis.scale.place(value).is_some() || infinite(axis, value)
            };
            if there(&chart.x, *x) && there(&chart.y, *y) {
                self.x.add(&chart.x, *x);
                self.y.add(&chart.y, *y);
                self.drawn += 1;
            } else {
                self.lost += 1;
            }
        }
    }
}

fn failed<E: std::error::Error + Send + Sync>(
    error: plotters::drawing::DrawingAreaErrorKind<E>,
) -> PictureError {
    PictureError::Chart(error.to_string())
}
