//! `[output]`: what is written, and when.

use super::cursor::Fields;
use super::item::Item;
use super::keys::{Absent, Kind, TableKeys, Word, key, positive, word};
use super::particles::{ClumpPlace, ParticleSource, Particles};
use super::source::Located;
use crate::run_tables::Switches;

/// `[output]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Files that are written.
    pub switches: Switches,
    /// Between frames and rows, s.
    pub interval: Located<f64>,
    /// Between rows of `.walls.csv`, `.regions.csv`, `.flux.csv` and `.ene`, s; default `interval`.
    pub rows_interval: Located<f64>,
    /// Between frames of `.fstat`, s; default `interval`.
    pub fstat_interval: Located<f64>,
    /// Between VTK files, s; default `interval`.
    pub vtk_interval: Located<f64>,
    /// Names of particles, clumps (each a single one) or insertions with rows in `.track.csv`; default none.
    pub track: Vec<Located<String>>,
    /// Between rows of `.track.csv`, s; default `interval`.
    pub track_interval: Located<f64>,
    /// Interval of the grains of an insertion that are followed, from the first on; default 1.
    pub track_every: Option<Located<u64>>,
    /// Rows of `.data` for clumps; default bodies.
    pub clumps_as: ClumpsAs,
    /// Whether energy is audited by mechanism; default false.
    pub energy_budget: bool,
    /// Between checkpoints, s of simulated time; none: by wall time.
    pub restart_interval: Option<Located<f64>>,
    /// Between links of the chain, s of simulated time; default a hundredth of `time.end`.
    pub link_interval: Option<Located<f64>>,
    /// Checkpoints that stay, at most; default none.
    pub keep_checkpoints: u64,
    /// Significant digits of text files, 1 to 17; none: the shortest that read back exactly.
    pub digits: Option<Located<u64>>,
}

/// Meaning of a row of `.data` for clumps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ClumpsAs {
    /// A body.
    Bodies,
    /// A pebble.
    Pebbles,
}

/// Objects that a trackable name stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Trackable {
    /// A single particle or clump.
    One,
    /// Several of an entry of `[[particles]]`.
    Several,
    /// The grains of an insertion.
    Insertion,
}

impl Word for ClumpsAs {
    const WHAT: &'static str = "choice";
    const WORDS: &'static [(&'static str, Self)] =
        &[("bodies", Self::Bodies), ("pebbles", Self::Pebbles)];
}

/// `[output]`
#[rustfmt::skip]
pub(super) static OUTPUT: TableKeys = TableKeys::new(&[&[
    key("interval", positive("s"), "0.01   # s between frames", "between frames and rows"),
    key("rows_interval", positive("s"), "1e-3", "between rows of `.walls.csv`, `.regions.csv`, `.flux.csv` and `.ene`").or_open("`interval`"),
], Switches::KEYS, &[
    key("fstat_interval", positive("s"), "0.1", "between frames of `.fstat`").or_open("`interval`"),
    key("vtk_interval", positive("s"), "0.1", "between frames of `vtk/`").or_open("`interval`"),
    key("track", Kind::List("", &Kind::Text), "[\"first\"]", "names of single particles or clumps, and of insertions, whose grains are followed from when they come: rows of [`.track.csv`](#trackcsv)").absent(Absent::EmptyList),
    key("track_interval", positive("s"), "1e-3", "between these rows").or_open("`interval`"),
    key("track_every", Kind::Whole(1, u64::MAX), "100", "of each insertion in `track` the first grain and every n-th one after it").or_open("1"),
    key("clumps_as", word::<ClumpsAs>(), "\"pebbles\"", "rows of `.data`, to which `.fstat` refers: one for each body, with its circumscribed radius and its orientation, or with `\"pebbles\"` one for each pebble").or_word("bodies"),
    key("energy_budget", Kind::Flag, "true", "the full audit by mechanism, in every step: [`<prefix>.budget.csv`](tables.md#energy-budget)").or_flag(false),
    key("restart_interval", positive("s"), "0.5", "simulated time between [checkpoints](checkpoint.md), besides those by the clock (`--checkpoint-every`), at a stop and at the end").or_open("by the clock"),
    key("link_interval", positive("s"), "0.05", "simulated time between links of the [chain](chain.md)").or_open("a hundredth of `time.end`, and at least 200 steps"),
    key("keep_checkpoints", Kind::Whole(0, 100_000), "16", "checkpoints that stay, at most, at links evenly spaced over the run: `<prefix>.checkpoints/<step>.restart`, from which [branches](../how-to/branch-and-verify.md) begin").or_open("0"),
    // 17 significant digits tell any two doubles apart.
    key("digits", Kind::Whole(1, 17), "10", "significant digits of text files; 10 has MercuryDPM's look").or_open("shortest exact"),
]]);

/// Reads `[output]`. `names` are those of `[[particles]]` and `[[insertions]]`.
pub(super) fn read(fields: &Fields<'_>, names: &[(String, Trackable)]) -> Output {
    let interval: Located<f64> = fields.read("interval");
    let other_interval = |key| -> Located<f64> {
        let given: Option<Located<f64>> = fields.read(key);
        given.unwrap_or_else(|| interval.clone())
    };
    let tracked = fields.get("track").and_then(|item| item.list());
    let tracked = tracked.unwrap_or_default();
    let keep: Option<Located<u64>> = fields.read("keep_checkpoints");
    let track = tracked.iter().filter_map(|item| read_tracked(item, names));
    Output {
        switches: Switches::read(|key| fields.read(key)),
        rows_interval: other_interval("rows_interval"),
        fstat_interval: other_interval("fstat_interval"),
        vtk_interval: other_interval("vtk_interval"),
        track: track.collect(),
        track_interval: other_interval("track_interval"),
        track_every: fields.read("track_every"),
        clumps_as: fields.read("clumps_as"),
        energy_budget: fields.read("energy_budget"),
        restart_interval: fields.read("restart_interval"),
        link_interval: fields.read("link_interval"),
        keep_checkpoints: keep.map_or(0, |keep| keep.value),
        digits: fields.read("digits"),
        interval,
    }
}

/// A name of `track`.
fn read_tracked(item: &Item<'_>, names: &[(String, Trackable)]) -> Option<Located<String>> {
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
        item.report("an entry of [[particles]] and one of [[insertions]] have this name");
        return None;
    }
    Some(name)
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
