//! Sheet of a picture: its content, and its drawing.

use super::layout::{Layout, Wishes, unit};
use super::legend::Legend;
use super::notes;
use crate::PictureError;
use crate::camera::{Lens, Overview};
use crate::canvas::Canvas;
use crate::frame::Frame;
use crate::image::Image;
use crate::options::Options;
use crate::render::{self, Look};
use crate::svg::Svg;
use crate::theme::Theme;

/// One scene of a sheet.
pub(crate) struct Cell<'a> {
    pub(crate) frame: &'a Frame,
    pub(crate) look: Look<'a>,
    /// Camera and framing.
    pub(crate) overview: Overview,
    pub(crate) options: Options,
    pub(crate) caption: Option<String>,
}

/// A picture before it is laid out.
pub(crate) struct Sheet<'a> {
    pub(crate) title: String,
    /// The line below the title.
    pub(crate) numbers: String,
    pub(crate) theme: Theme,
    pub(crate) legend: Legend,
    pub(crate) cells: Vec<Cell<'a>>,
    pub(crate) axes: bool,
    pub(crate) scale_bar: bool,
}

impl Sheet<'_> {
    /// Whether cells look in different directions and need axes of their own.
    pub(super) fn cell_axes(&self) -> bool {
        let first = self.cells.first().map(|cell| cell.options.view);
        self.axes
            && self
                .cells
                .iter()
                .any(|cell| Some(cell.options.view) != first)
    }

    fn laid_out(&self, options: &Options) -> (Layout, Vec<Lens>) {
        let aspect = (self.cells.iter())
            .map(|cell| cell.overview.aspect(&cell.options))
            .fold(0.0, f64::max);
        let wishes = Wishes {
            title: !self.title.is_empty(),
            numbers: !self.numbers.is_empty(),
            legend: self.legend.width(unit(options)),
            footer: (self.axes && !self.cell_axes()) || self.scale_bar,
            cells: self.cells.len(),
            captions: self.cells.iter().any(|cell| cell.caption.is_some()),
            cell_axes: self.cell_axes(),
            aspect: if aspect > 0.0 { aspect } else { 1.0 },
        };
        let layout = Layout::new(options, &wishes);
        let lenses: Vec<Lens> = (self.cells.iter().zip(&layout.windows))
            .map(|(cell, (window, _))| cell.overview.lens(&cell.options, *window))
            .collect();
        // One scale for all, so that sizes can be compared.
        let scale = (lenses.iter().map(Lens::target_scale)).fold(f64::INFINITY, f64::min);
        let lenses = lenses
            .into_iter()
            .map(|lens| lens.with_scale(scale))
            .collect();
        (layout, lenses)
    }

    /// Picture of the sheet as pixels.
    pub(crate) fn image(&self, options: &Options) -> Image {
        let (layout, lenses) = self.laid_out(options);
        let mut image = self.scenes(options, &lenses);
        self.annotate(&layout, &lenses, &mut image);
        image
    }

    /// The scenes in their windows, without a word.
    fn scenes(&self, options: &Options, lenses: &[Lens]) -> Image {
        let mut image = Image::new(options.width, options.height, self.theme.paper);
        for (cell, lens) in self.cells.iter().zip(lenses) {
            render::paint(&mut image, lens, &cell.look);
        }
        image
    }

    /// Picture of the sheet as pixels and as SVG, the scenes painted once. In SVG these are pixels, texts and drawings about them are text
    /// and shapes.
    pub(crate) fn image_and_svg(&self, options: &Options) -> Result<(Image, String), PictureError> {
        let (layout, lenses) = self.laid_out(options);
        let mut image = self.scenes(options, &lenses);
        let size = (f64::from(options.width), f64::from(options.height));
        let mut svg = Svg::sized(size, self.theme.paper, &self.title, &self.numbers);
        svg.picture(size, &image.png()?);
        self.annotate(&layout, &lenses, &mut svg);
        self.annotate(&layout, &lenses, &mut image);
        Ok((image, svg.finish()))
    }

    fn annotate(&self, layout: &Layout, lenses: &[Lens], canvas: &mut dyn Canvas) {
        notes::headings(self, layout, canvas);
        if let Some(area) = &layout.legend {
            self.legend.draw(canvas, area, layout.unit, &self.theme);
        }
        if let Some(area) = &layout.footer {
            notes::footer(self, area, lenses, layout.unit, canvas);
        }
        let cells = self.cells.iter().zip(lenses).zip(&layout.windows);
        for ((cell, lens), (_, line)) in cells {
            if let Some(caption) = &cell.caption {
                notes::caption(caption, lens, *line, layout.unit, &self.theme, canvas);
            }
            if self.cell_axes() {
                notes::cell_axes(cell, lens, layout.unit, &self.theme, canvas);
            }
        }
    }
}
