//! Charts: what numbers over other numbers look like in every tool of Mercury.
//!
//! A caller gives the *content*, in SI units: a [`Chart`] has two [`Axis`], [`Series`] and a legend; a [`ChartPage`] holds one
//! or several charts and becomes SVG and PNG. How it looks is decided here, once: the embedded font, colours that colour-blind
//! readers tell apart and that come with dashes and markers for grey printing, round ticks, units with prefixes. The same data
//! give the same bytes.
//!
//! ```
//! use mercury_pictures::charts::{Axis, Chart, ChartPage, Series};
//!
//! let sizes: Vec<(f64, f64)> = (1..100).map(|k| (1e-5 * f64::from(k), 0.01 * f64::from(k))).collect();
//! let chart = Chart::new("Uniform by number", Axis::log("diameter", "m"), Axis::probability("share below"))
//!     .with(Series::line("target", sizes));
//! let page = ChartPage::of(chart);
//! assert!(page.svg()?.starts_with("<?xml"));
//! // page.write(Path::new("out/uniform")) writes out/uniform.svg and out/uniform.png.
//! # Ok::<(), mercury_pictures::PictureError>(())
//! ```
//!
//! The modules: `chart` and `axis` are what callers fill in, `palette` is the look of series. `ruler` puts values on an axis and
//! finds its `ticks`; `panel` draws one chart with plotters, its `elements` (lines and areas, cut by `clip`), its `legend` and
//! `heat` maps; `page` lays panels out. `board` is the plotters backend that draws on this crate's own canvas, so that charts and
//! pictures share font, SVG and pixels.

mod axis;
mod board;
mod chart;
mod clip;
mod elements;
mod heat;
mod legend;
mod look;
mod needs;
mod outline;
mod page;
mod palette;
mod panel;
mod ruler;
#[cfg(test)]
mod tests;
mod ticks;

pub use axis::{Axis, Scale};
pub use chart::{Chart, HeatMap, Legend, Note, Place, Series, Shape};
pub use page::ChartPage;
pub use palette::{Dash, Hue, Marker};
