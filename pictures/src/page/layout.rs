//! Where things stand in a picture.

use crate::camera::Window;
use crate::options::Options;

use super::text_size;

/// A rectangle of the picture (pixels).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Area {
    pub(super) x0: f64,
    pub(super) y0: f64,
    pub(super) x1: f64,
    pub(super) y1: f64,
}

impl Area {
    pub(super) fn width(&self) -> f64 {
        self.x1 - self.x0
    }

    pub(super) fn height(&self) -> f64 {
        self.y1 - self.y0
    }
}

/// The places of everything, in pixels.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    /// Pixels per point of a page of 1200 x 900.
    pub(super) unit: f64,
    pub(super) width: f64,
    /// Margin on the left.
    pub(super) left: f64,
    /// Base lines of title and line of numbers, where there is space for them.
    pub(super) headings: Option<(f64, f64)>,
    pub(super) legend: Option<Area>,
    /// The band below the scene.
    pub(super) footer: Option<Area>,
    /// Windows on scenes, and base lines of captions above them.
    pub(super) windows: Vec<(Window, f64)>,
}

/// The parts of the page that need space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wishes {
    pub(super) title: bool,
    pub(super) numbers: bool,
    /// Width of the legend; 0: none.
    pub(super) legend: f64,
    pub(super) footer: bool,
    pub(super) cells: usize,
    /// Whether cells have captions and axes of their own.
    pub(super) captions: bool,
    pub(super) cell_axes: bool,
    /// Width over height of what a cell shows.
    pub(super) aspect: f64,
}

/// Scenes get at least this share of the picture along each axis; notes that would take more are left out.
const SMALLEST_SCENE: f64 = 0.45;

/// Pixels per point of a page of 1200 x 900.
pub(crate) fn unit(options: &Options) -> f64 {
    let area = f64::from(options.width) * f64::from(options.height);
    (area / (1200.0 * 900.0)).sqrt().max(0.25)
}

impl Layout {
    pub(super) fn new(options: &Options, wishes: &Wishes) -> Self {
        let (width, height) = (f64::from(options.width), f64::from(options.height));
        let unit = unit(options);
        let left = (40.0 * unit).min(0.05 * width);
        let room = |size: f64| 1.15 * text_size(size, unit);
        let mut top = 14.0 * unit;
        let title_line = top + room(24.0);
        let numbers_line = if wishes.title { title_line } else { top } + room(18.0) + 4.0 * unit;
        let mut bottom = height - 14.0 * unit;
        let mut right = width - left;
        let footer_height = 84.0 * unit.max(0.5);
        let mut has_footer = wishes.footer;
        if has_footer && bottom - footer_height - top < SMALLEST_SCENE * height {
            has_footer = false;
        }
        if has_footer {
            bottom -= footer_height;
        }
        let footer = has_footer.then_some(Area {
            x0: left,
            y0: bottom + 8.0 * unit,
            x1: right,
            y1: height - 14.0 * unit,
        });
        let headed = match (wishes.title, wishes.numbers) {
            (_, true) => numbers_line + 12.0 * unit,
            (true, false) => title_line + 14.0 * unit,
            (false, false) => top,
        };
        let mut headings = None;
        if headed > top && bottom - headed >= SMALLEST_SCENE * height {
            headings = Some((title_line, numbers_line));
            top = headed;
        }
        let mut legend = None;
        if wishes.legend > 0.0 && wishes.legend < (1.0 - SMALLEST_SCENE) * width {
            let from = width - wishes.legend - 12.0 * unit;
            legend = Some(Area {
                x0: from,
                y0: top,
                x1: width - 6.0 * unit,
                y1: bottom,
            });
            right = from - 20.0 * unit;
        }
        let scene = Area {
            x0: left,
            y0: top,
            x1: right,
            y1: bottom,
        };
        Self {
            unit,
            width,
            left,
            headings,
            legend,
            footer,
            windows: windows(&scene, wishes, unit),
        }
    }
}

/// The windows of `cells` scenes inside `area`, in as many columns as show them largest.
fn windows(area: &Area, wishes: &Wishes, unit: f64) -> Vec<(Window, f64)> {
    let gap = if wishes.cells > 1 { 14.0 * unit } else { 0.0 };
    let above = if wishes.captions {
        1.5 * text_size(15.0, unit)
    } else {
        0.0
    };
    let below = if wishes.cell_axes { 80.0 * unit } else { 0.0 };
    let cell = |columns: usize| {
        let rows = wishes.cells.div_ceil(columns);
        let each = |room: f64, number: usize| (room + gap) / number as f64 - gap;
        (
            each(area.width(), columns),
            each(area.height(), rows) - above - below,
        )
    };
    let scale = |columns: usize| {
        let (width, height) = cell(columns);
        (width / wishes.aspect).min(height)
    };
    let columns = (1..=wishes.cells.max(1))
        .max_by(|a, b| f64::total_cmp(&scale(*a), &scale(*b)).then(b.cmp(a)))
        .unwrap_or(1);
    let (width, height) = cell(columns);
    (0..wishes.cells)
        .map(|place| {
            let (column, row) = ((place % columns) as f64, (place / columns) as f64);
            let x = area.x0 + column * (width + gap);
            let y = area.y0 + row * (height + above + below + gap) + above;
            // Where there is no space for a scene, casts make a window without size out of it.
            let span = |from: f64, room: f64, end: f64| {
                let from = from.round().clamp(0.0, end.max(0.0).floor());
                (from as usize, room.min(end - from).floor() as usize)
            };
            let (x, width) = span(x, width, area.x1);
            let (top, height) = span(y, height, area.y1);
            let window = Window {
                x,
                y: top,
                width,
                height,
            };
            (window, y - 0.45 * text_size(15.0, unit))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn windows_lie_in_the_picture_and_apart(
            width in 16u32..3000, height in 16u32..3000, legend in 0.0..300.0f64, cells in 1usize..30,
            flags in any::<[bool; 5]>(), aspect in 0.1..10.0f64,
        ) {
            let options = Options { width, height, ..Options::default() };
            let [title, numbers, footer, captions, cell_axes] = flags;
            let wishes = Wishes { title, numbers, legend, footer, cells, captions, cell_axes, aspect };
            let layout = Layout::new(&options, &wishes);
            prop_assert_eq!(layout.windows.len(), cells);
            for (k, (a, _)) in layout.windows.iter().enumerate() {
                prop_assert!(a.x + a.width <= width as usize && a.y + a.height <= height as usize);
                for (b, _) in &layout.windows[..k] {
                    let apart = |p: usize, l: usize, q: usize, m: usize| p + l <= q || q + m <= p;
                    prop_assert!(apart(a.x, a.width, b.x, b.width) || apart(a.y, a.height, b.y, b.height));
                }
            }
            if let Some(area) = layout.legend {
                prop_assert!(layout.windows.iter().all(|(w, _)| (w.x + w.width) as f64 <= area.x0));
            }
        }
    }
}
