//! Pictures and films of a run: PNG, SVG, film strips, GIF and APNG.
//!
//! The input is read twice: once to find one camera and one range of colours for all frames, once to draw. `quantity` says
//! what colours show, `scene` makes a frame of `mercury-pictures` from a snapshot and what the run has beside it.

mod quantity;
mod scene;

use std::path::PathBuf;

use mercury_pictures::{
    Apng, ColourBy, ColourMap, Frame, Gif, Image, Options, Overview, Painter, delays,
};

use crate::bodies;
use crate::output::Output;
use crate::{ClumpsAs, ExportError, Selection, Snapshot, Source, Told, for_each_snapshot};
use quantity::Quantity;
use scene::Scenery;

/// What a picture shows, and how it looks.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureChoice {
    /// Size, camera, background, what stands around the scene. Its `colour` is replaced by what `quantity` says.
    pub options: Options,
    /// What the colours of the particles show: `auto` (speed; height where nothing moves), `none`, `speed`, `height`,
    /// `material`, `body`, or the name of a column or of a vector, whose length is shown.
    pub quantity: String,
    /// Values at the ends of the colour bar; `None`: from the frames.
    pub range: Option<(f64, f64)>,
    /// The colours.
    pub map: ColourMap,
    /// With contacts as lines whose width shows the force, where the run has them.
    pub contacts: bool,
    /// With walls, where the run has them.
    pub walls: bool,
    /// How clumps are shown.
    pub clumps: ClumpsAs,
    /// The heading instead of the run's title.
    pub title: Option<String>,
}

/// What comes out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PictureKind {
    /// One PNG per frame.
    Png,
    /// One SVG per frame.
    Svg,
    /// One PNG with so many frames, at equal distances in the list of frames.
    Strip(usize),
    /// An animated GIF that takes so many seconds; `None`: twenty frames a second.
    Gif(Option<f64>),
    /// An animated PNG that takes so many seconds; `None`: twenty frames a second.
    Apng(Option<f64>),
}

/// The most frames of a film strip.
pub const LONGEST_STRIP: usize = 64;
/// Frames per second of a film.
const RATE: f64 = 20.0;

/// Writes pictures; `progress` hears of every frame drawn. Returns what was read and the files.
///
/// # Errors
/// When the input cannot be read or has not what the picture is to show, options make no sense, a file of an earlier export
/// is in the way, or a file cannot be written.
pub fn export(
    source: &Source,
    selection: &Selection,
    output: &Output,
    choice: &PictureChoice,
    kind: PictureKind,
    progress: impl FnMut(&Snapshot),
) -> Result<(Told, Vec<PathBuf>), ExportError> {
    if let PictureKind::Strip(number) = kind
        && !(1..=LONGEST_STRIP).contains(&number)
    {
        let message = format!("--strip {number}: expected 1 to {LONGEST_STRIP} frames");
        return Err(ExportError::Input(message));
    }
    if let PictureKind::Gif(Some(seconds)) | PictureKind::Apng(Some(seconds)) = kind
        && !(seconds.is_finite() && seconds > 0.0)
    {
        let message = format!("--duration {seconds}: expected seconds above 0");
        return Err(ExportError::Input(message));
    }
    // Whole files only: what is in the way must be known before an hour of drawing.
    let whole = match kind {
        PictureKind::Strip(_) => Some("strip.png"),
        PictureKind::Gif(_) => Some("gif"),
        PictureKind::Apng(_) => Some("apng"),
        PictureKind::Png | PictureKind::Svg => None,
    };
    if let Some(ending) = whole {
        output.claim(&output.path(ending))?;
    }
    let job = Job {
        source,
        selection,
        output,
        choice,
    };
    let seen = job.look()?;
    job.draw(&seen, kind, progress)
}

struct Job<'a> {
    source: &'a Source,
    selection: &'a Selection,
    output: &'a Output,
    choice: &'a PictureChoice,
}

/// What the first reading found.
struct Seen {
    overview: Overview,
    options: Options,
    quantity: Quantity,
    times: Vec<f64>,
}

impl Job<'_> {
    /// The first reading.
    fn look(&self) -> Result<Seen, ExportError> {
        let mut times = Vec::new();
        // What to show may depend on whether anything moves in any frame: both are looked at.
        let mut candidates: Vec<(Quantity, Options, Overview)> = Vec::new();
        let mut is_moving = false;
        let mut scenery = Scenery::new(self.source, self.selection, self.choice)?;
        for_each_snapshot(self.source, self.selection, |snapshot| {
            if candidates.is_empty() {
                for quantity in Quantity::candidates(&self.choice.quantity, &snapshot)? {
                    let options = self.options(&quantity, &snapshot);
                    candidates.push((quantity, options, Overview::default()));
                }
            }
            times.push(snapshot.frame.time);
            is_moving |= quantity::moves(&snapshot);
            for (quantity, options, overview) in &mut candidates {
                overview.add(&scenery.frame(&snapshot, quantity)?, options);
            }
            Ok(())
        })?;
        let last = candidates.len().saturating_sub(1);
        let wanted = if is_moving { 0 } else { last };
        let (quantity, options, overview) = candidates.swap_remove(wanted);
        Ok(Seen {
            overview,
            options,
            quantity,
            times,
        })
    }

    fn options(&self, quantity: &Quantity, snapshot: &Snapshot) -> Options {
        let mut options = self.choice.options.clone();
        options.colour = quantity.colour(snapshot);
        if let ColourBy::Scalar { range, map, .. } = &mut options.colour {
            *range = self.choice.range;
            *map = self.choice.map;
        }
        options
    }

    /// The second reading.
    fn draw(
        &self,
        seen: &Seen,
        kind: PictureKind,
        mut progress: impl FnMut(&Snapshot),
    ) -> Result<(Told, Vec<PathBuf>), ExportError> {
        let painter = Painter::new(&seen.options, seen.overview.clone())?;
        let number = seen.times.len();
        let mut reel = Reel::new(kind, self.output, number)?;
        let duration = match kind {
            PictureKind::Gif(seconds) | PictureKind::Apng(seconds) => seconds,
            _ => None,
        };
        let delays = delays(&seen.times, duration.unwrap_or(number as f64 / RATE));
        let mut scenery = Scenery::new(self.source, self.selection, self.choice)?;
        let mut count = 0;
        let mut told = for_each_snapshot(self.source, self.selection, |snapshot| {
            // A run may have grown since the first reading; its new frames wait for the next picture.
            let Some(delay) = delays.get(count) else {
                return Ok(());
            };
            progress(&snapshot);
            if reel.wants(count, number) {
                let frame = scenery.frame(&snapshot, &seen.quantity)?;
                reel.take(&painter, frame, snapshot.number, *delay, self.output)?;
            }
            count += 1;
            Ok(())
        })?;
        if let Reel::Strip { frames, .. } = &reel {
            told.written = frames.len();
        }
        let files = reel.finish(&painter, self.output)?;
        told.warnings
            .extend(scenery.cut(seen.times.last().copied()));
        told.notes.extend(scenery.note());
        told.notes.extend(bodies::notes(bodies::reader_for(
            self.source,
            self.choice.clumps,
        )?));
        Ok((told, files))
    }
}

/// What becomes of drawn frames.
enum Reel {
    Png(Vec<PathBuf>),
    Svg(Vec<PathBuf>),
    Strip { length: usize, frames: Vec<Frame> },
    Gif(Gif),
    Apng(Apng),
}

impl Reel {
    fn new(kind: PictureKind, output: &Output, number: usize) -> Result<Self, ExportError> {
        Ok(match kind {
            PictureKind::Png => Self::Png(Vec::new()),
            PictureKind::Svg => Self::Svg(Vec::new()),
            PictureKind::Strip(length) => Self::Strip {
                length,
                frames: Vec::new(),
            },
            PictureKind::Gif(_) => Self::Gif(Gif::create(&output.path("gif"))?),
            PictureKind::Apng(_) => Self::Apng(Apng::create(&output.path("apng"), number)?),
        })
    }

    /// Whether frame `count` of `number` is drawn.
    fn wants(&self, count: usize, number: usize) -> bool {
        let Self::Strip { length, .. } = self else {
            return true;
        };
        let gaps = length.saturating_sub(1);
        if gaps == 0 {
            return count + 1 == number;
        }
        // The nearest frame to k / gaps of the way, for each k.
        (0..=gaps).any(|k| (2 * k * (number - 1) + gaps) / (2 * gaps) == count)
    }

    fn take(
        &mut self,
        painter: &Painter,
        frame: Frame,
        number: usize,
        delay: f64,
        output: &Output,
    ) -> Result<(), ExportError> {
        let image = |frame: &Frame| -> Image { painter.image(frame) };
        match self {
            Self::Png(files) => {
                let path = output.path(&format!("{number:04}.png"));
                output.write(&path, &image(&frame).png()?)?;
                files.push(path);
            }
            Self::Svg(files) => {
                let path = output.path(&format!("{number:04}.svg"));
                output.write(&path, painter.svg(&frame).as_bytes())?;
                files.push(path);
            }
            Self::Strip { frames, .. } => frames.push(frame),
            Self::Gif(film) => film.add(&image(&frame), delay)?,
            Self::Apng(film) => film.add(&image(&frame), delay)?,
        }
        Ok(())
    }

    fn finish(self, painter: &Painter, output: &Output) -> Result<Vec<PathBuf>, ExportError> {
        let one = |ending: &str| vec![output.path(ending)];
        Ok(match self {
            Self::Png(files) | Self::Svg(files) => files,
            Self::Strip { frames, .. } => {
                let bytes = painter.strip(&frames)?.png()?;
                output.write(&output.path("strip.png"), &bytes)?;
                one("strip.png")
            }
            Self::Gif(film) => {
                film.finish()?;
                one("gif")
            }
            Self::Apng(film) => {
                film.finish()?;
                one("apng")
            }
        })
    }
}
