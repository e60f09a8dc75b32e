//! `[output]`: what is written, and when.

use super::cursor::Fields;
use super::particles::{ClumpPlace, ParticleSource, Particles};
use super::settings::flag;
use super::source::Located;

/// `[output]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Between frames and rows, s.
    pub interval: Located<f64>,
    /// `.data`; default true.
    pub data: bool,
    /// `.ene`; default true.
    pub ene: bool,
    /// `.fstat` (and `.contacts.arrow` with frames); default false.
    pub fstat: bool,
    /// Between frames of `.fstat`, s; default `interval`.
    pub fstat_interval: Located<f64>,
    /// VTK files; default false.
    pub vtk: Located<bool>,
    /// Between VTK files, s; default `interval`.
    pub vtk_interval: Located<f64>,
    /// `.particles.arrow`; default true.
    pub frames: bool,
    /// `.walls.csv`; default true.
    pub walls: bool,
    /// Loads on the triangles of mesh walls; default false.
    pub triangle_loads: bool,
    /// `.liquid.csv` where there is liquid; default true.
    pub liquid: bool,
    /// `.droplets.arrow` where there are sprays; default true.
    pub droplets: bool,
    /// Pictures at the end; default true.
    pub pictures: bool,
    /// Names of particles, clumps (each a single one) or insertions with rows in `.track.csv`; default none.
    pub track: Vec<Located<String>>,
    /// Between rows of `.track.csv`, s; default `interval`.
    pub track_interval: Located<f64>,
    /// Of the grains of an insertion every n-th is followed, from the first; default 1.
    pub track_every: Option<Located<u64>>,
    /// Rows of `.data` for clumps; default bodies.
    pub clumps_as: ClumpsAs,
    /// Whether energy is audited by mechanism; default false.
    pub energy_budget: bool,
    /// Between checkpoints, s of simulated time; none: by wall time.
    pub restart_interval: Option<Located<f64>>,
    /// Significant digits of text files, 1 to 17; none: the shortest that read back exactly.
    pub digits: Option<Located<u64>>,
}

/// What a row of `.data` is for clumps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ClumpsAs {
    /// A body.
    Bodies,
    /// A pebble.
    Pebbles,
}

/// What a name stands for that is to be tracked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Trackable {
    /// A single particle or clump.
    One,
    /// Several of an entry of `[[particles]]`.
    Several,
    /// The grains of an insertion.
    Insertion,
}

/// Reads `[output]`. `names` are those of `[[particles]]` and `[[insertions]]`.
pub(super) fn read(fields: &Fields<'_>, names: &[(String, Trackable)]) -> Option<Output> {
    let interval = fields.need("interval").and_then(|item| item.positive());
    let other_interval = |key| match fields.get(key) {
        Some(item) => item.positive(),
        None => interval.clone(),
    };
    let fstat_interval = other_interval("fstat_interval");
    let vtk_interval = other_interval("vtk_interval");
    let data = flag(fields, "data", true);
    let ene = flag(fields, "ene", true);
    let fstat = flag(fields, "fstat", false);
    let vtk = match fields.get("vtk") {
        Some(item) => item.boolean().map(|value| Located {
            value,
            place: item.place.clone(),
        }),
        None => Some(fields.default("vtk", false)),
    };
    let frames = flag(fields, "frames", true);
    let walls = flag(fields, "walls", true);
    let triangle_loads = flag(fields, "triangle_loads", false);
    let liquid = flag(fields, "liquid", true);
    let droplets = flag(fields, "droplets", true);
    let pictures = flag(fields, "pictures", true);
    let track = fields.get("track").map_or(Some(Vec::new()), |item| {
        let read: Vec<Option<Located<String>>> = item
            .list()?
            .iter()
            .map(|item| {
                let words: Vec<(&str, Trackable)> = names
                    .iter()
                    .map(|(name, what)| (name.as_str(), *what))
                    .collect();
                if words.is_empty() {
                    item.report("no entry of [[particles]] has a name");
                    return None;
                }
                if item.word("particle or insertion named", &words)? == Trackable::Several {
                    item.report("of [[particles]] only a single particle or clump can be tracked");
                    return None;
                }
                let name = item.text()?;
                if words.iter().filter(|(word, _)| *word == name.value).count() > 1 {
                    item.report(
                        "an entry of [[particles]] and one of [[insertions]] have this name",
                    );
                    return None;
                }
                Some(name)
            })
            .collect();
        read.into_iter().collect()
    });
    let track_interval = other_interval("track_interval");
    let track_every = fields.get("track_every").and_then(|item| item.whole(1));
    let clumps_as = fields
        .get("clumps_as")
        .and_then(|item| {
            item.word(
                "choice",
                &[("bodies", ClumpsAs::Bodies), ("pebbles", ClumpsAs::Pebbles)],
            )
        })
        .unwrap_or(ClumpsAs::Bodies);
    let energy_budget = flag(fields, "energy_budget", false);
    let restart_interval = fields
        .get("restart_interval")
        .and_then(|item| item.positive());
    let digits = fields.get("digits").and_then(|item| {
        let digits = item.whole(1)?;
        // 17 significant digits tell any two doubles apart.
        if *digits > 17 {
            item.report(format!("must be <= 17, got {}", *digits));
            return None;
        }
        Some(digits)
    });
    fields.finish();
    Some(Output {
        interval: interval?,
        data,
        ene,
        fstat,
        fstat_interval: fstat_interval?,
        vtk: vtk?,
        vtk_interval: vtk_interval?,
        frames,
        walls,
        triangle_loads,
        liquid,
        droplets,
        pictures,
        track: track?,
        track_interval: track_interval?,
        track_every,
        clumps_as,
        energy_budget,
        restart_interval,
        digits,
    })
}

/// Whether an entry puts exactly one particle or clump.
pub(super) fn is_single(particles: &Particles) -> bool {
    matches!(
        particles.source,
        ParticleSource::One { .. }
            | ParticleSource::Clump {
                at: ClumpPlace::Position(_),
                ..
            }
    )
}
