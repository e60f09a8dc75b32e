//! Frames for the viewer: particles as few bytes as they need, walls as triangles.
//!
//! The streams of a run are put together in a folder of this machine, where `mercury_common` reads them; they grow there
//! as they grow in the store, and go when no viewer has looked for a while.

use std::fs::{self, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow};
use cloud_api::{Head, RunId};
use cloud_store::Store;
use cloud_store::frames::MARKER;
use mercury_common::frames::{Column, FrameReader, FramesHeader};
use serde_json::{Value, json};

use crate::content::Content;
use crate::state::ByRun;

/// How long a run's files stay here after the last look.
const KEPT: Duration = Duration::from_secs(600);

/// The largest value of a number of 16 bits.
const FULL: f64 = 65_535.0;

/// Runs that are looked at.
pub(crate) struct Cache {
    folder: PathBuf,
    runs: ByRun<Arc<Mutex<Viewed>>>,
}

/// A run that is looked at.
pub(crate) struct Viewed {
    folder: PathBuf,
    /// Revision and how often streams were cut: what is here is of another past if they have changed.
    past: (u32, u64),
    particles: Option<FrameReader>,
}

impl Cache {
    pub(crate) fn new(folder: PathBuf) -> Self {
        Self {
            folder,
            runs: ByRun::default(),
        }
    }

    /// Drops what no viewer has looked at for a while.
    pub(crate) fn tidy(&self) {
        let mut runs = self
            .runs
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner());
        runs.retain(|run, (used, _)| {
            let keep = used.elapsed() < KEPT;
            if !keep {
                let _ = fs::remove_dir_all(self.folder.join(run));
            }
            keep
        });
    }

    /// Drops what is here of a run.
    pub(crate) fn forget(&self, run: &str) {
        self.runs
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
            .remove(run);
        let _ = fs::remove_dir_all(self.folder.join(run));
    }

    /// The run as the store has it now.
    fn viewed(&self, store: &dyn Store, run: &RunId, head: &Head) -> Result<Arc<Mutex<Viewed>>> {
        let folder = self.folder.join(run.as_str());
        let viewed = {
            let mut runs = self
                .runs
                .lock()
                .unwrap_or_else(|poisoned| poisoned.into_inner());
            let (used, viewed) = runs.entry(run.to_string()).or_insert_with(|| {
                (
                    Instant::now(),
                    Arc::new(Mutex::new(Viewed {
                        folder,
                        past: (0, 0),
                        particles: None,
                    })),
                )
            });
            *used = Instant::now();
            Arc::clone(viewed)
        };
        viewed
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
            .follow(store, run, head)?;
        Ok(viewed)
    }
}

impl Viewed {
    fn follow(&mut self, store: &dyn Store, run: &RunId, head: &Head) -> Result<()> {
        let past = (head.revision, head.cuts);
        if self.past != past {
            self.particles = None;
            let _ = fs::remove_dir_all(&self.folder);
            self.past = past;
        }
        fs::create_dir_all(&self.folder)?;
        let ending = |end: &str| {
            let mut names = head.streams.keys().chain(head.whole.keys());
            names
                .find(|name| name.ends_with(end) && !name.contains('/'))
                .cloned()
        };
        let bring = |name: &str| bring(store, run, head, name, &self.folder.join(name));
        if let Some(name) = ending(".particles.arrow") {
            bring(&name)?;
            match &mut self.particles {
                Some(reader) => drop(reader.refresh()),
                None => self.particles = FrameReader::open(self.folder.join(&name)).ok(),
            }
        }
        if let Some(name) = ending(".walls.arrow") {
            let meshes = ending(".surfaces.arrow");
            if let Some(meshes) = &meshes {
                bring(meshes)?;
            }
            bring(&name)?;
        }
        Ok(())
    }
}

/// Brings a file up to what the store has of it.
fn bring(store: &dyn Store, run: &RunId, head: &Head, name: &str, path: &Path) -> Result<()> {
    let content = Content::of(run, head, name).ok_or_else(|| anyhow!("{name} is gone"))?;
    let mut file = OpenOptions::new()
        .create(true)
        .truncate(false)
        .read(true)
        .write(true)
        .open(path)?;
    let grows = head.streams.contains_key(name);
    let here = file
        .metadata()?
        .len()
        .saturating_sub(if grows { MARKER.len() as u64 } else { 0 });
    let mut at = here;
    // From the old marker on; the first bytes of a frame come last, as the solver writes them.
    file.seek(SeekFrom::Start(at))?;
    while at < content.bytes() {
        let piece = content.read(store, at..content.bytes())?;
        at += piece.len() as u64;
        file.write_all(&piece)?;
    }
    Ok(())
}

/// Number, time, step and rows of each frame, and what there is to see.
pub(crate) fn list(cache: &Cache, store: &dyn Store, run: &RunId, head: &Head) -> Result<Value> {
    let viewed = cache.viewed(store, run, head)?;
    let viewed = viewed
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner());
    let version = format!("{}.{}", viewed.past.0, viewed.past.1);
    let Some(reader) = &viewed.particles else {
        return Ok(json!({"version": version, "frames": [], "columns": []}));
    };
    let header =
        FramesHeader::of(reader.schema()).map_err(|found| anyhow!("{}", found.join(" ")))?;
    let frames: Vec<Value> = reader
        .infos()
        .map(|info| json!({"time": info.time, "step": info.step, "rows": info.rows}))
        .collect();
    let numbers = reader
        .schema()
        .columns()
        .iter()
        .filter(|column| !matches!(column.name.as_str(), "time" | "x" | "y" | "z"));
    let mut columns: Vec<Value> = numbers
        .map(|column| json!({"name": column.name, "unit": column.unit}))
        .collect();
    columns.insert(0, json!({"name": "speed", "unit": "m/s"}));
    let domain = header
        .domain
        .map(|(min, max)| json!([min.to_array(), max.to_array()]));
    Ok(json!({
        "version": version, "frames": frames, "columns": columns, "materials": header.materials, "walls": header.walls,
        "domain": domain, "dimensions": header.dimensions.unwrap_or(3),
    }))
}

/// A hash of an id that spreads neighbours (finalizer of MurmurHash3): a threshold on it picks the same grains in each
/// frame.
fn spread(id: u32) -> u32 {
    let mut h = id;
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// Rows that are shown, in the order of their hash: any first part of them is spread over all, and is the same grains in
/// each frame. `largest` is the number of rows of the largest frame, so that the threshold does not follow this one's.
fn chosen(ids: &[u32], most: usize, largest: usize) -> Vec<usize> {
    let share = (most as f64 / largest.max(1) as f64).min(1.0);
    let threshold = (share * f64::from(u32::MAX)) as u32;
    let mut rows: Vec<usize> = (0..ids.len())
        .filter(|&row| spread(ids[row]) <= threshold)
        .collect();
    rows.sort_unstable_by_key(|&row| spread(ids[row]));
    rows
}

/// A frame as the viewer takes it: length of the head (u32), head (JSON, padded to 4 bytes), then `id` as u32 and every
/// column as u16 within its range, one behind the other, each padded to 4 bytes. All little-endian.
pub(crate) fn frame(
    cache: &Cache,
    store: &dyn Store,
    run: &RunId,
    head: &Head,
    k: usize,
    columns: &[String],
    most: usize,
) -> Result<Option<Vec<u8>>> {
    let viewed = cache.viewed(store, run, head)?;
    let viewed = viewed
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner());
    let Some(reader) = &viewed.particles else {
        return Ok(None);
    };
    let Some(info) = reader.info(k) else {
        return Ok(None);
    };
    let most_rows = reader.infos().map(|info| info.rows).max().unwrap_or(0);
    let frame = reader.frame(k).context("a frame of the store")?;
    let column = |name: &str| -> Option<Vec<f64>> {
        if name == "speed" {
            let at = |name: &str| frame.columns.get(reader.schema().index_of(name)?)?.as_f64();
            let (x, y, z) = (at("vx")?, at("vy")?, at("vz")?);
            return Some(
                (0..x.len())
                    .map(|k| (x[k] * x[k] + y[k] * y[k] + z[k] * z[k]).sqrt())
                    .collect(),
            );
        }
        Some(numbers(frame.columns.get(reader.schema().index_of(name)?)?))
    };
    let ids: Vec<u32> = reader
        .schema()
        .index_of("id")
        .and_then(|at| frame.columns.get(at)?.as_u32())
        .unwrap_or_default()
        .to_vec();
    let rows = chosen(&ids, most, most_rows);
    let mut body: Vec<u8> = rows
        .iter()
        .flat_map(|&row| ids[row].to_le_bytes())
        .collect();
    let mut described = Vec::new();
    for name in ["x", "y", "z", "radius"]
        .into_iter()
        .chain(columns.iter().map(String::as_str))
    {
        let Some(values) = column(name) else {
            return Ok(None);
        };
        let finite = || {
            rows.iter()
                .map(|&row| values[row])
                .filter(|value| value.is_finite())
        };
        let (min, max) = finite().fold((f64::MAX, f64::MIN), |(min, max), value| {
            (min.min(value), max.max(value))
        });
        let (min, max) = if min <= max { (min, max) } else { (0.0, 0.0) };
        let scale = if max > min { FULL / (max - min) } else { 0.0 };
        body.extend(rows.iter().flat_map(|&row| {
            // What is no number is shown as the least.
            let value = (values[row] - min) * scale;
            ((value + 0.5) as u16).to_le_bytes()
        }));
        body.resize(body.len().next_multiple_of(4), 0);
        described.push(json!({"name": name, "min": min, "max": max}));
    }
    let head = json!({"time": info.time, "step": info.step, "rows": rows.len(), "of": info.rows, "columns": described});
    let mut head = head.to_string().into_bytes();
    head.resize(head.len().next_multiple_of(4), b' ');
    let mut bytes = (head.len() as u32).to_le_bytes().to_vec();
    bytes.extend(head);
    bytes.extend(body);
    Ok(Some(bytes))
}

/// All values of one particle in a frame.
pub(crate) fn row(
    cache: &Cache,
    store: &dyn Store,
    run: &RunId,
    head: &Head,
    k: usize,
    id: u32,
) -> Result<Option<Value>> {
    let viewed = cache.viewed(store, run, head)?;
    let viewed = viewed
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner());
    let Some(reader) = &viewed.particles else {
        return Ok(None);
    };
    if reader.info(k).is_none() {
        return Ok(None);
    }
    let frame = reader.frame(k).context("a frame of the store")?;
    let ids = reader
        .schema()
        .index_of("id")
        .and_then(|at| frame.columns.get(at)?.as_u32())
        .unwrap_or_default();
    let Some(row) = ids.iter().position(|&other| other == id) else {
        return Ok(None);
    };
    let values = reader.schema().columns().iter().zip(&frame.columns);
    let values = values.map(|(spec, column)| json!({"name": spec.name, "unit": spec.unit, "value": numbers(column)[row]}));
    Ok(Some(Value::Array(values.collect())))
}

pub(crate) fn numbers(column: &Column) -> Vec<f64> {
    match column {
        Column::F64(values) => values.clone(),
        Column::U32(values) => values.iter().map(|&value| f64::from(value)).collect(),
        Column::I32(values) => values.iter().map(|&value| f64::from(value)).collect(),
        Column::U64(values) => values.iter().map(|&value| value as f64).collect(),
        Column::U8(values) => values.iter().map(|&value| f64::from(value)).collect(),
        Column::OptionalU32(values) => values
            .iter()
            .map(|value| value.map_or(f64::NAN, f64::from))
            .collect(),
        Column::Text(_) => vec![f64::NAN; column.len()],
    }
}

/// The folder of this machine with the streams of a run.
pub(crate) fn folder(
    cache: &Cache,
    store: &dyn Store,
    run: &RunId,
    head: &Head,
) -> Result<PathBuf> {
    let viewed = cache.viewed(store, run, head)?;
    let viewed = viewed
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner());
    Ok(viewed.folder.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1 in 10 of 100,000: binomial, with a standard deviation of 95; 5 of them are 475.
    #[test]
    fn a_subsample_has_the_same_grains_in_each_frame() {
        let ids: Vec<u32> = (0..100_000).collect();
        let shuffled: Vec<u32> = ids.iter().rev().copied().collect();
        let grains = |ids: &[u32], most: usize| -> Vec<u32> {
            let rows = chosen(ids, most, 100_000);
            rows.into_iter().map(|row| ids[row]).collect()
        };
        let first = grains(&ids, 10_000);
        assert!(first.len().abs_diff(10_000) < 475, "{}", first.len());
        assert_eq!(first, grains(&shuffled, 10_000));
        // Fewer are a first part of more, and a frame without some grains has the same others.
        assert_eq!(grains(&ids, 1_000)[..], first[..grains(&ids, 1_000).len()]);
        let without: Vec<u32> = ids[..50_000].to_vec();
        let expected: Vec<u32> = first.iter().copied().filter(|&id| id < 50_000).collect();
        assert_eq!(grains(&without, 10_000), expected);
        assert_eq!(grains(&ids, 200_000).len(), 100_000);
    }
}
