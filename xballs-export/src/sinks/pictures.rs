//! Pictures and films of a run: PNG, SVG, film strips, GIF and APNG.
//!
//! The input is read twice: once to find one camera and one range of colours for all frames, once to draw. `quantity` decides
//! the meaning of colours, `scene` makes a frame of `mercury_pictures` from a snapshot and what the run has beside it.

mod quantity;
mod scene;

use std::path::{Path, PathBuf};

use mercury_pictures::{
    Apng, ColourBy, ColourMap, Frame, Gif, Image, Options, Overview, Painter, delays,
};

use crate::bodies;
use crate::output::{Output, ending_of_file};
use crate::{ClumpsAs, ExportError, Job, Outcome, Sink, Snapshot};
use quantity::Quantity;
use scene::Scenery;

/// Content and look of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureChoice {
    /// Size, camera, background, surroundings of the scene. Its `colour` is replaced by that of `quantity`.
    pub options: Options,
    /// Quantity that the colours of the particles show: `auto` (speed; height where nothing moves), `none`, `speed`, `height`,
    /// `diameter`, `material`, `body`, `clump`, `depth` (of worn walls), `film` (`film_volume`), `liquid` (`liquid_volume`), or
    /// the name of a column or of a vector, whose length is shown.
    pub quantity: String,
    /// Values at the ends of the colour bar; `None`: from the frames.
    pub range: Option<(f64, f64)>,
    /// The colours.
    pub map: ColourMap,
    /// Equal steps of colour stand for equal ratios.
    pub logarithmic: bool,
    /// With particles.
    pub particles: bool,
    /// With contacts as lines whose width shows the force, where the run has them.
    pub contacts: bool,
    /// With contacts that have a liquid bridge alone, as lines whose width shows the force of the bridge.
    pub bridges: bool,
    /// With bonds as lines whose width and colour show a stress, instead of contacts.
    pub bonds: Option<BondStress>,
    /// With droplets in flight.
    pub droplets: bool,
    /// With walls, where the run has them.
    pub walls: bool,
    /// How clumps are shown.
    pub clumps: ClumpsAs,
    /// The heading instead of the run's title.
    pub title: Option<String>,
}

/// Stress that the lines of bonds show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BondStress {
    /// The larger of both.
    #[default]
    Larger,
    /// Tensile stress; 0 for bonds in compression.
    Tension,
    /// Shear stress.
    Shear,
}

/// Form of the output.
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

impl PictureKind {
    /// Endings of its files.
    fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Png | Self::Strip(_) => &["png"],
            Self::Svg => &["svg"],
            Self::Gif(_) => &["gif"],
            Self::Apng(_) => &["apng", "png"],
        }
    }

    /// Whether a path that is no folder yet is meant as the one file of this kind.
    ///
    /// # Errors
    /// When it is meant as a picture of another kind.
    pub fn is_file(self, path: &Path) -> Result<bool, ExportError> {
        let Some(ending) = ending_of_file(path) else {
            return Ok(false);
        };
        if self.endings().contains(&ending.as_str()) {
            return Ok(true);
        }
        match ["png", "svg", "gif", "apng"].contains(&ending.as_str()) {
            true => Err(ExportError::Input(format!(
                "{}: this command writes .{}\nhelp: mercury-export {ending} writes .{ending}",
                path.display(),
                self.endings()[0]
            ))),
            false => Err(ExportError::Input(format!(
                "{}: no picture or film is written as .{ending}\nhelp: mercury-export png, svg, gif and apng write .png, .svg, .gif and .apng; a folder takes a name without such an ending",
                path.display()
            ))),
        }
    }
}

/// The most frames of a film strip.
pub const LONGEST_STRIP: usize = 64;
/// Frames per second of a film.
const RATE: f64 = 20.0;

/// The pictures of an input.
pub struct Pictures<'a> {
    job: &'a Job,
    choice: PictureChoice,
    kind: PictureKind,
    scenery: Scenery<'a>,
    /// Quantities that may be shown: the choice may depend on whether anything moves in any frame, so all candidates are looked
    /// at.
    candidates: Vec<(Quantity, Options, Overview)>,
    is_moving: bool,
    /// Times of the frames, s.
    times: Vec<f64>,
    drawing: Option<Drawing>,
}

/// Facts that are known once all frames were looked at.
struct Drawing {
    quantity: Quantity,
    painter: Painter,
    reel: Reel,
    /// Time for which each frame is shown, s.
    delays: Vec<f64>,
    count: usize,
}

impl<'a> Pictures<'a> {
    /// Checks what can be checked before anything is read.
    ///
    /// # Errors
    /// When the numbers of `kind` make no sense, or the input has not what the pictures are to show.
    pub fn new(
        job: &'a Job,
        choice: PictureChoice,
        kind: PictureKind,
    ) -> Result<Self, ExportError> {
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
        Ok(Self {
            scenery: Scenery::new(&job.source, &job.selection, &choice)?,
            job,
            choice,
            kind,
            candidates: Vec::new(),
            is_moving: false,
            times: Vec::new(),
            drawing: None,
        })
    }

    fn options(&self, quantity: &Quantity, snapshot: &Snapshot) -> Options {
        let mut options = self.choice.options.clone();
        options.colour = quantity.colour(snapshot);
        if let ColourBy::Scalar {
            range,
            map,
            logarithmic,
            ..
        } = &mut options.colour
        {
            *range = self.choice.range;
            *map = self.choice.map;
            *logarithmic = self.choice.logarithmic;
        }
        options
    }

    /// Settles what is shown, and how, from what was seen of all frames.
    fn begin(&mut self) -> Result<Drawing, ExportError> {
        let last = self.candidates.len().saturating_sub(1);
        let wanted = if self.is_moving { 0 } else { last };
        let (quantity, options, overview) = self.candidates.swap_remove(wanted);
        let number = self.times.len();
        if let (Some(file), PictureKind::Png | PictureKind::Svg, 2..) =
            (self.job.output.file(), self.kind, number)
        {
            return Err(ExportError::Input(format!(
                "{}: {number} frames make {number} pictures\nhelp: take one (--frames last), or name a folder",
                file.display()
            )));
        }
        let duration = match self.kind {
            PictureKind::Gif(seconds) | PictureKind::Apng(seconds) => seconds,
            _ => None,
        };
        Ok(Drawing {
            quantity,
            painter: Painter::new(&options, overview)?,
            reel: Reel::new(self.kind, &self.job.output, number)?,
            delays: delays(&self.times, duration.unwrap_or(number as f64 / RATE)),
            count: 0,
        })
    }
}

impl Sink for Pictures<'_> {
    fn files(&self) -> Vec<PathBuf> {
        // Whole files only: what is in the way must be known before an hour of drawing.
        let whole = match self.kind {
            PictureKind::Strip(_) => Some("strip.png"),
            PictureKind::Gif(_) => Some("gif"),
            PictureKind::Apng(_) => Some("apng"),
            PictureKind::Png | PictureKind::Svg => self.job.output.file().map(|_| ""),
        };
        let path = |ending| self.job.output.one(ending);
        whole.into_iter().map(path).collect()
    }

    /// One camera and one range of colours for all frames.
    fn looks_first(&self) -> bool {
        true
    }

    fn look(&mut self, snapshot: &Snapshot) -> Result<(), ExportError> {
        let snapshot = &*self.scenery.with_clumps(snapshot)?;
        if self.candidates.is_empty() {
            let clumps = self.scenery.clumps();
            let of_run = self.scenery.of_run();
            for quantity in Quantity::candidates(&self.choice.quantity, snapshot, &clumps, of_run)?
            {
                let options = self.options(&quantity, snapshot);
                self.candidates
                    .push((quantity, options, Overview::default()));
            }
        }
        self.times.push(snapshot.frame.time);
        self.is_moving |= quantity::moves(snapshot);
        for (quantity, options, overview) in &mut self.candidates {
            overview.add(&self.scenery.frame(snapshot, quantity)?, options);
        }
        Ok(())
    }

    fn write(&mut self, snapshot: Snapshot) -> Result<(), ExportError> {
        let drawing = match &mut self.drawing {
            Some(drawing) => drawing,
            None => {
                let drawing = self.begin()?;
                self.scenery.begin_again();
                self.drawing.insert(drawing)
            }
        };
        // A run may have grown since the first reading; its new frames wait for the next picture.
        let Some(delay) = drawing.delays.get(drawing.count) else {
            return Ok(());
        };
        if drawing.reel.wants(drawing.count, drawing.delays.len()) {
            let snapshot = self.scenery.with_clumps(&snapshot)?;
            let frame = self.scenery.frame(&snapshot, &drawing.quantity)?;
            let (reel, output) = (&mut drawing.reel, &self.job.output);
            reel.take(&drawing.painter, frame, snapshot.number, *delay, output)?;
        }
        drawing.count += 1;
        Ok(())
    }

    fn finish(self: Box<Self>, outcome: &mut Outcome) -> Result<Vec<PathBuf>, ExportError> {
        let Some(Drawing { painter, reel, .. }) = self.drawing else {
            return Ok(Vec::new());
        };
        if let Reel::Strip { frames, .. } = &reel {
            outcome.written = frames.len();
        }
        let files = reel.finish(&painter, &self.job.output)?;
        let last = self.times.last().copied();
        outcome.warnings.extend(self.scenery.cut(last));
        outcome.notes.extend(self.scenery.note());
        let surfaces = bodies::reader_for(&self.job.source, self.choice.clumps)?;
        outcome.notes.extend(bodies::notes(surfaces));
        Ok(files)
    }
}

/// Destination of drawn frames.
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
            PictureKind::Gif(_) => Self::Gif(Gif::create(&output.one("gif"))?),
            PictureKind::Apng(_) => Self::Apng(Apng::create(&output.one("apng"), number)?),
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
                let path = output.one(&format!("{number:04}.png"));
                output.write(&path, &image(&frame).png()?)?;
                files.push(path);
            }
            Self::Svg(files) => {
                let path = output.one(&format!("{number:04}.svg"));
                output.write(&path, painter.svg(&frame)?.as_bytes())?;
                files.push(path);
            }
            Self::Strip { frames, .. } => frames.push(frame),
            Self::Gif(film) => film.add(&image(&frame), delay)?,
            Self::Apng(film) => film.add(&image(&frame), delay)?,
        }
        Ok(())
    }

    fn finish(self, painter: &Painter, output: &Output) -> Result<Vec<PathBuf>, ExportError> {
        let one = |ending: &str| vec![output.one(ending)];
        Ok(match self {
            Self::Png(files) | Self::Svg(files) => files,
            Self::Strip { frames, .. } => {
                let bytes = painter.strip(&frames)?.png()?;
                output.write(&output.one("strip.png"), &bytes)?;
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
