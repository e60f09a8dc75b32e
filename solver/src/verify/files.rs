//! The files of a run against the sums in its chain.

use std::collections::BTreeMap;
use std::io;

use mercury_common::whole_file::FileError;
use serde_json::Value;

use crate::output::chain::{CHAIN, EndResult, Link};
use crate::output::folder::VTK;
use crate::plan::FileSum;
use crate::results::NamedResult;
use crate::run::Recorded;
use crate::run::checkpoint::Checkpoint;

/// The first difference between the files of a run and its chain, in words.
pub(super) fn first_difference(
    recorded: &Recorded,
    checkpoints: &[Checkpoint],
) -> Result<Option<String>, FileError> {
    let mut sums: BTreeMap<String, FileSum> = BTreeMap::new();
    for (number, (link, _)) in recorded.chain.links().enumerate() {
        let what = format!("link {} (step {})", number + 1, link.step);
        if let Some(found) = differs_at(recorded, link, &what, &mut sums)? {
            return Ok(Some(found));
        }
    }
    if let Some(end) = recorded.chain.end() {
        if let Some(found) = differs_at(recorded, &end.link, "its end", &mut sums)? {
            return Ok(Some(found));
        }
        for (name, (bytes, _)) in &end.link.outputs {
            let path = recorded.folder.join(name);
            let failed = FileError::of(&path, "the file cannot be read");
            let length = std::fs::metadata(&path).map_err(failed)?.len();
            if length > *bytes {
                return Ok(Some(format!(
                    "{}: the file has {length} bytes, and had {bytes} at the end of the run",
                    path.display()
                )));
            }
        }
        if let Some(found) = wrong_result(recorded, &end.results) {
            return Ok(Some(found));
        }
    }
    Ok(wrong_summary(recorded).or_else(|| wrong_position(recorded, checkpoints)))
}

/// A file that differs from its sum in a link.
fn differs_at(
    recorded: &Recorded,
    link: &Link,
    what: &str,
    sums: &mut BTreeMap<String, FileSum>,
) -> Result<Option<String>, FileError> {
    for (name, (bytes, expected)) in &link.outputs {
        let path = recorded.folder.join(name);
        let sum = sums.entry(name.clone()).or_default();
        match sum.go_on(&path, Some(*bytes)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Ok(Some(format!("{}: the file is missing", path.display())));
            }
            read => read.map_err(FileError::of(&path, "the file cannot be read"))?,
        }
        if sum.bytes < *bytes {
            return Ok(Some(format!(
                "{}: the file has {} bytes, and had {bytes} at {what}",
                path.display(),
                sum.bytes
            )));
        }
        if sum.hex() != *expected {
            return Ok(Some(format!(
                "{}: its first {bytes} bytes are not those of {what}",
                path.display()
            )));
        }
    }
    Ok(None)
}

/// A result that does not follow from the tables.
fn wrong_result(recorded: &Recorded, results: &BTreeMap<String, EndResult>) -> Option<String> {
    let settled = Some(recorded.plan.settled().time);
    for (name, then) in results {
        let now = NamedResult::parse(&format!("{name}={}", then.of));
        // Results of a program that drove the run may be of other kinds.
        let Ok(now) = now else { continue };
        let read = now.read(&recorded.folder, &recorded.prefix, settled);
        let error = read.estimate.as_ref().and_then(|known| known.error);
        if read.value != then.value || error != then.error {
            let number = |value: Option<f64>| value.map_or("none".to_owned(), |v| v.to_string());
            return Some(format!(
                "result `{name}` at its end is {} with the error {}, from the tables {} with the error {}",
                number(then.value),
                number(then.error),
                number(read.value),
                number(error)
            ));
        }
    }
    None
}

/// A summary of another run.
fn wrong_summary(recorded: &Recorded) -> Option<String> {
    let path = recorded.folder.join("summary.json");
    let wrong = |problem: &str| Some(format!("{}: {problem}", path.display()));
    // A run that was killed may have none.
    let text = std::fs::read_to_string(&path).ok()?;
    let Ok(summary) = serde_json::from_str::<Value>(&text) else {
        return wrong("it is no JSON");
    };
    // That of a stopped run which was gone on with and killed is older than its chain.
    let ended = recorded.chain.end();
    if ended.is_some() && summary["link"] != recorded.chain.last() {
        return wrong("its link is not the last one of the chain");
    }
    if ended.is_none() && summary["status"] == "finished" {
        return wrong("the run had finished, and its chain has no end: lines are missing");
    }
    for (name, result) in ended.iter().flat_map(|end| &end.results) {
        let there = &summary["results"][name];
        if there["value"].as_f64() != result.value || there["error"].as_f64() != result.error {
            return wrong(&format!("result `{name}` is not that of the chain"));
        }
    }
    None
}

/// A checkpoint whose outputs are not as long as its links have them.
fn wrong_position(recorded: &Recorded, checkpoints: &[Checkpoint]) -> Option<String> {
    let lines = &recorded.chain.lines;
    for checkpoint in checkpoints {
        let (path, step) = (checkpoint.path.display(), checkpoint.head.step);
        let streams = checkpoint.positions.streams();
        // At a line of this step another scene may begin, and the end may follow.
        let mut ends = lines.iter().enumerate().filter(|(index, line)| {
            let next = lines.get(index + 1);
            line.content.step() <= step && next.is_none_or(|next| next.content.step() >= step)
        });
        let position = streams.get(CHAIN).copied();
        if !ends.any(|(_, line)| Some(line.end) == position) {
            return Some(format!(
                "{path}: by its section `outputs` the chain has other lines up to step {step}"
            ));
        }
        let Some((number, link)) = recorded.link_at(step) else {
            continue;
        };
        let is_linked =
            |name: &&String| *name != CHAIN && *name != VTK && !name.starts_with("fields.");
        let named = streams.keys().filter(is_linked);
        let named = named.map(|name| format!("{}.{name}", recorded.prefix));
        if !named.eq(link.outputs.keys().cloned()) {
            return Some(format!(
                "{path}: its section `outputs` has other files than link {number} (step {step})"
            ));
        }
        for (name, position) in streams {
            let file = format!("{}.{name}", recorded.prefix);
            let linked = link.outputs.get(&file);
            // Those of frames are counted.
            if let Some((bytes, _)) = linked.filter(|_| !name.ends_with(".arrow"))
                && bytes != position
            {
                return Some(format!(
                    "{path}: by its section `outputs` {file} has {position} bytes, and it had {bytes} at link {number} (step {step})"
                ));
            }
        }
    }
    None
}
