//! Content of a chart, as data.

use super::axis::Axis;
use super::palette::{Dash, Hue, Marker};
use crate::colour_map::ColourMap;

/// Two axes and what is drawn between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Heading; empty: none.
    pub title: String,
    /// To the right.
    pub x: Axis,
    /// Upwards.
    pub y: Axis,
    /// The later lie above the earlier, lines and points above bands, bars and heat maps.
    pub series: Vec<Series>,
    /// Text inside.
    pub notes: Vec<Note>,
    /// Where series are named.
    pub legend: Legend,
    /// Text of a chart without any value to draw.
    pub when_empty: String,
    /// Whether one unit is as long to the right as upwards, as on a map. It needs two linear axes and leaves some space free.
    pub to_scale: bool,
}

impl Chart {
    /// A chart without series.
    #[must_use]
    pub fn new(title: &str, x: Axis, y: Axis) -> Self {
        Self {
            title: title.into(),
            x,
            y,
            series: Vec::new(),
            notes: Vec::new(),
            legend: Legend::Auto,
            when_empty: "no data".into(),
            to_scale: false,
        }
    }

    /// This chart with one unit as long to the right as upwards.
    #[must_use]
    pub fn to_scale(mut self) -> Self {
        self.to_scale = true;
        self
    }

    /// This chart with one series more.
    #[must_use]
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// This chart with a note.
    #[must_use]
    pub fn note(mut self, text: &str, place: Place) -> Self {
        self.notes.push(Note {
            text: text.into(),
            place,
        });
        self
    }

    /// This chart with its legend elsewhere.
    #[must_use]
    pub fn legend(mut self, legend: Legend) -> Self {
        self.legend = legend;
        self
    }

    /// Fault of the chart, if there is one.
    pub(super) fn fault(&self) -> Option<String> {
        let axes = [&self.x, &self.y].into_iter().find_map(Axis::fault);
        axes.or_else(|| self.series.iter().find_map(Series::fault))
    }
}

/// Data drawn in a chart. The look, where it is not set, follows from its place in the list.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// In the legend; empty: not there.
    pub name: String,
    /// More about it, on a line of its own in the legend; empty: nothing.
    pub about: String,
    /// Its values, SI units.
    pub shape: Shape,
    /// Colour; none: the next one, for a [`Shape::Band`] that of the series before it.
    pub hue: Option<Hue>,
    /// How lines are broken; none: the next way.
    pub dash: Option<Dash>,
    /// How points look; none: the next way.
    pub marker: Option<Marker>,
    /// Width of lines (points).
    pub width: f64,
}

/// The values of a series. Where a value is not a number, a line is broken and a point left out; the chart gives their number.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A line through points.
    Line(Vec<(f64, f64)>),
    /// A line through points, each of them marked.
    MarkedLine(Vec<(f64, f64)>),
    /// A value that holds until the next: empirical distributions.
    Steps(Vec<(f64, f64)>),
    /// Points.
    Points {
        /// Where.
        at: Vec<(f64, f64)>,
        /// Half lengths of their error bars along x and y, 0 for none; empty: no point has any.
        errors: Vec<(f64, f64)>,
    },
    /// The area between two lines, point by point: confidence.
    Band {
        /// One line.
        lower: Vec<(f64, f64)>,
        /// The other, as many points.
        upper: Vec<(f64, f64)>,
    },
    /// Bars that stand on zero (on the lower end of a logarithmic axis): histograms.
    Bars {
        /// Limits of classes along x, one more than there are heights.
        edges: Vec<f64>,
        /// Heights.
        heights: Vec<f64>,
    },
    /// A line across the chart at this y.
    Level(f64),
    /// A line up the chart at this x.
    Upright(f64),
    /// Colours over the plane.
    Heat(HeatMap),
}

/// Values in the cells of a grid, shown as colours.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    /// Limits of cells along x, one more than there are columns.
    pub x_edges: Vec<f64>,
    /// Limits of cells along y, one more than there are rows.
    pub y_edges: Vec<f64>,
    /// Row by row from the first of `y_edges`; not a number: an empty cell.
    pub values: Vec<f64>,
    /// Name on the colour bar.
    pub name: String,
    /// SI unit of the values.
    pub unit: String,
    /// Colours.
    pub map: ColourMap,
    /// Ends of the colour bar; none: what the values need.
    pub range: Option<(f64, f64)>,
    /// Whether ends that follow from the values are as far below 0 as above it: for maps with a middle and values of either sign.
    pub centred: bool,
}

impl Series {
    /// A series of this shape and name.
    #[must_use]
    pub fn new(name: &str, shape: Shape) -> Self {
        Self {
            name: name.into(),
            about: String::new(),
            shape,
            hue: None,
            dash: None,
            marker: None,
            width: 1.6,
        }
    }

    /// A line.
    #[must_use]
    pub fn line(name: &str, points: Vec<(f64, f64)>) -> Self {
        Self::new(name, Shape::Line(points))
    }

    /// A line with its points marked.
    #[must_use]
    pub fn marked_line(name: &str, points: Vec<(f64, f64)>) -> Self {
        Self::new(name, Shape::MarkedLine(points))
    }

    /// A value that holds until the next.
    #[must_use]
    pub fn steps(name: &str, points: Vec<(f64, f64)>) -> Self {
        Self::new(name, Shape::Steps(points))
    }

    /// Points.
    #[must_use]
    pub fn points(name: &str, at: Vec<(f64, f64)>) -> Self {
        let errors = Vec::new();
        Self::new(name, Shape::Points { at, errors })
    }

    /// Points with the half lengths of their error bars along x and y.
    #[must_use]
    pub fn points_with_errors(name: &str, at: Vec<(f64, f64)>, errors: Vec<(f64, f64)>) -> Self {
        Self::new(name, Shape::Points { at, errors })
    }

    /// The area between two lines.
    #[must_use]
    pub fn band(name: &str, lower: Vec<(f64, f64)>, upper: Vec<(f64, f64)>) -> Self {
        Self::new(name, Shape::Band { lower, upper })
    }

    /// A histogram.
    #[must_use]
    pub fn bars(name: &str, edges: Vec<f64>, heights: Vec<f64>) -> Self {
        Self::new(name, Shape::Bars { edges, heights })
    }

    /// A grey dashed line at this y.
    #[must_use]
    pub fn level(name: &str, y: f64) -> Self {
        Self::new(name, Shape::Level(y)).reference()
    }

    /// A grey dashed line at this x.
    #[must_use]
    pub fn upright(name: &str, x: f64) -> Self {
        Self::new(name, Shape::Upright(x)).reference()
    }

    /// Colours over the plane.
    #[must_use]
    pub fn heat(map: HeatMap) -> Self {
        Self::new("", Shape::Heat(map))
    }

    fn reference(self) -> Self {
        let thin = Self { width: 1.2, ..self };
        thin.hue(Hue::Grey).dash(Dash::Dashed)
    }

    /// This series in this colour.
    #[must_use]
    pub fn hue(mut self, hue: Hue) -> Self {
        self.hue = Some(hue);
        self
    }

    /// This series with lines broken in this way.
    #[must_use]
    pub fn dash(mut self, dash: Dash) -> Self {
        self.dash = Some(dash);
        self
    }

    /// This series with these markers.
    #[must_use]
    pub fn marker(mut self, marker: Marker) -> Self {
        self.marker = Some(marker);
        self
    }

    /// This series with lines of this width (points).
    #[must_use]
    pub fn width(mut self, width: f64) -> Self {
        self.width = width;
        self
    }

    /// This series with a second line in the legend.
    #[must_use]
    pub fn about(mut self, text: &str) -> Self {
        self.about = text.into();
        self
    }

    fn fault(&self) -> Option<String> {
        let rising = |edges: &[f64]| {
            edges.len() > 1
                && edges.windows(2).all(|w| w[0] < w[1] && w[0].is_finite())
                && edges.last().is_some_and(|last| last.is_finite())
        };
        let fault = match &self.shape {
            Shape::Points { at, errors } if !errors.is_empty() && errors.len() != at.len() => {
                format!("{} points and {} errors", at.len(), errors.len())
            }
            Shape::Band { lower, upper } if lower.len() != upper.len() => format!(
                "{} points on one side of the band and {} on the other",
                lower.len(),
                upper.len()
            ),
            Shape::Bars { edges, heights } if edges.len() != heights.len() + 1 => {
                format!(
                    "{} edges for {} bars, expected one more",
                    edges.len(),
                    heights.len()
                )
            }
            Shape::Bars { edges, .. } if !rising(edges) => "edges of bars that do not rise".into(),
            Shape::Heat(map) if !rising(&map.x_edges) || !rising(&map.y_edges) => {
                "edges of cells that do not rise".into()
            }
            Shape::Heat(map)
                if map.values.len() != (map.x_edges.len() - 1) * (map.y_edges.len() - 1) =>
            {
                format!(
                    "{} values for {} x {} cells",
                    map.values.len(),
                    map.x_edges.len() - 1,
                    map.y_edges.len() - 1
                )
            }
            _ if !(self.width > 0.0 && self.width <= 100.0) => {
                format!(
                    "lines {} points wide, expected above 0 and at most 100",
                    self.width
                )
            }
            _ => return None,
        };
        Some(format!("series \"{}\" has {fault}", self.name))
    }
}

/// Text inside a chart; a line feed starts a new line.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// The text.
    pub text: String,
    /// Where.
    pub place: Place,
}

/// A place inside a chart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// A corner.
    UpperLeft,
    /// A corner.
    UpperRight,
    /// A corner.
    LowerLeft,
    /// A corner.
    LowerRight,
    /// To the right of this x, above this y (SI).
    At(f64, f64),
}

/// Where a legend stands. It is drawn only if a series has a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Legend {
    /// In the corner that hides nothing; to the right of the chart if each hides something.
    Auto,
    /// To the right of the chart.
    Right,
    /// In a corner.
    UpperLeft,
    /// In a corner.
    UpperRight,
    /// In a corner.
    LowerLeft,
    /// In a corner.
    LowerRight,
    /// Nowhere.
    None,
}
