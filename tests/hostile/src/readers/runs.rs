//! Readers of a run's own folder: checkpoints, locks, plans.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use mercury_engine::step::Engine;
use mercury_solver::output::folder::{Earlier, prepare};
use mercury_solver::plan::{Plan, plan, read_scene};
use mercury_solver::run::{Checkpoints, RunOptions, checkpoint, run_from};

use super::{KB, MB, Reader};
use crate::checks::{said, say};
use crate::mutate::Make::{Binary, Text};
use crate::mutate::{Random, mutated};
use crate::place::Place;

pub(super) const READERS: &[Reader] = &[
    Reader::new("checkpoint", Binary, |place| vec![place.of_run("scene.0.restart")], inspected)
        .bound(256 * KB, 64, "the file; its values, of which the smallest take one byte there and a list of lists 24 here, three times while lists \
            grow; the words of `--inspect`")
        .own(resealed),
    Reader::new("checkpoint-resumed", Binary, |place| vec![place.of_run("scene.0.restart")], resumed)
        .bound(64 * MB, 400, "the file; its values; the engine that goes on from them, with its lists and blocks")
        .own(resealed),
    Reader::new("run-resumed", Binary, |place| vec![place.of_run("scene.0.restart")], gone_on)
        .bound(64 * MB, 600, "the file; its values; the engine that goes on from them; what the outputs of the run hold, and a checkpoint")
        .own(resealed),
    Reader::new("lock", Text(&["node 17", "1", "4294967295"]), |_| vec![b"node17 4711\n".to_vec(), b"a b 1\n".to_vec()], lock)
        .bound(256 * KB, 8, "the text, twice; what the folder needs"),
    Reader::new("plan-document", Text(&["prefix", "\"scene\"", "[[insertions]]", "psd", "mixture"]), |place| vec![place.of_run("plan.toml")], plan_document)
        .bound(MB, 600, "TOML's tree: some 200 bytes for a key of 4 (`a=1`), three times while tables grow"),
];

/// The sections of a checkpoint: name, value.
fn sections(bytes: &[u8]) -> Option<Vec<(&[u8], &[u8])>> {
    let mut rest = bytes.get(12..)?;
    let mut found = Vec::new();
    let number = |bytes: &[u8]| Some(u64::from_le_bytes(bytes.get(..8)?.try_into().ok()?) as usize);
    while !rest.is_empty() {
        let name_length = number(rest)?;
        let name = rest.get(8..8 + name_length)?;
        rest = &rest[8 + name_length..];
        let length = number(rest)?;
        found.push((name, rest.get(12..12 + length)?));
        rest = &rest[12 + length..];
    }
    Some(found)
}

/// Changes the values of a section or two, and makes lengths and checksums right again: what reads the values has to cope.
pub(super) fn resealed(random: &mut Random, samples: &[Vec<u8>]) -> Vec<u8> {
    let sample = random.pick(samples);
    let Some(sections) = sections(sample) else {
        return sample.clone();
    };
    let chosen = random.below(sections.len());
    let second = random.below(sections.len());
    let mut out = sample[..12].to_vec();
    for (k, (name, value)) in sections.iter().enumerate() {
        let value = if k == chosen || (k == second && random.one_in(3)) {
            let all: Vec<Vec<u8>> = vec![value.to_vec()];
            mutated(random, &all, Binary)
        } else {
            value.to_vec()
        };
        out.extend_from_slice(&(name.len() as u64).to_le_bytes());
        out.extend_from_slice(name);
        out.extend_from_slice(&(value.len() as u64).to_le_bytes());
        out.extend_from_slice(&crc32fast::hash(&value).to_le_bytes());
        out.extend_from_slice(&value);
    }
    out
}

/// Reads a checkpoint as `mercury-solve --inspect` does.
fn inspected(bytes: &[u8], place: &Place) {
    let path = place.write("a.0.restart", bytes);
    if let Some(checkpoint) = said(checkpoint::read(&path))
        && let Some(contents) = said(checkpoint.contents())
    {
        let _ = contents.to_string();
    }
    if let Err(error) = checkpoint::newest(path.parent().unwrap_or(Path::new("")), "a") {
        say(&error);
    }
}

thread_local! {
    static PLAN: RefCell<Option<Arc<Plan>>> = const { RefCell::new(None) };
}

/// Resumes as `mercury-solve --resume` does, up to the engine and some steps.
fn resumed(bytes: &[u8], place: &Place) {
    let plan = PLAN.with_borrow_mut(|known| {
        let plan = known.get_or_insert_with(|| {
            place.scene();
            let scene = read_scene(&place.path("scene.toml"), &[]).expect("a scene");
            Arc::new(plan(&scene).expect("a plan"))
        });
        Arc::clone(plan)
    });
    let path = place.write("a.0.restart", bytes);
    let Some(checkpoint) = said(checkpoint::read(&path)) else {
        return;
    };
    if let Err(error) = checkpoint.fits(&plan, &checkpoint.head.scene) {
        return say(&error);
    }
    let Some(mut engine) = said(Engine::restore(plan, checkpoint.snapshot, 1)) else {
        return;
    };
    for _ in 0..3 {
        if said(engine.step(None)).is_none() {
            return;
        }
    }
    let _ = engine.snapshot().encode();
}

thread_local! {
    /// The plan of the run with a later end, and the statement of its scene then.
    static LONGER: RefCell<Option<(Plan, BTreeMap<String, String>)>> = const { RefCell::new(None) };
}

/// Resumes as `mercury-solve --resume` does, with all files of the run: some steps, a checkpoint, the end.
fn gone_on(bytes: &[u8], place: &Place) {
    let (plan, scene) = LONGER.with_borrow_mut(|known| {
        let known = known.get_or_insert_with(|| {
            let run = place.run();
            let path = run.with_file_name("scene.toml");
            let scene = read_scene(&path, &["time.end=0.00406".to_owned()]).expect("a scene");
            let stated = scene.statement.entries().expect("the files are there");
            (plan(&scene).expect("a plan"), stated)
        });
        known.clone()
    });
    let folder = place.path("gone-on");
    copy(place.run(), &folder);
    place.write("gone-on/scene.0.restart", bytes);
    let Some(Some((checkpoint, _))) = said(checkpoint::newest(&folder, "scene")) else {
        return;
    };
    if let Err(error) = checkpoint.fits(&plan, &scene) {
        return say(&error);
    }
    let _ = checkpoint.is_at_end(&plan);
    let options = RunOptions {
        folder,
        threads: 1,
        checkpoints: Some(Checkpoints {
            at_end: true,
            ..Checkpoints::default()
        }),
        ..RunOptions::default()
    };
    if let Some(report) = said(run_from(Some(checkpoint), plan, &options, &mut |_| {})) {
        let _ = report.to_string();
    }
}

/// Puts the files of a folder into another one, and takes what else was in it away.
fn copy(from: &Path, to: &Path) {
    let _ = std::fs::remove_dir_all(to);
    std::fs::create_dir(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let (from, to) = entry
            .map(|entry| (entry.path(), to.join(entry.file_name())))
            .expect("a file");
        if from.is_dir() {
            copy(&from, &to);
        } else {
            std::fs::copy(from, to).expect("a file");
        }
    }
}

fn lock(bytes: &[u8], place: &Place) {
    let folder = place.path("locked");
    let _ = std::fs::create_dir(&folder);
    for name in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
        let _ = std::fs::remove_file(name.path());
    }
    place.write("locked/.lock", bytes);
    said(prepare(&folder, "scene", Earlier::Refuse));
}

fn plan_document(bytes: &[u8], place: &Place) {
    let folder = place.path("planned");
    let _ = std::fs::create_dir(&folder);
    place.write("planned/plan.toml", bytes);
    said(prepare(&folder, "other", Earlier::Replace));
}
