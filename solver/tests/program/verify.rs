//! `mercury-solve verify`: nothing that was changed is missed, and what is changed is named.

use std::fs;
use std::path::Path;

use mercury_solver::output::chain::{Chain, kept_checkpoints};

use super::chain::{HEAP, run};
use crate::common::{code, errors, folder_with, said, solve};

/// Copies a run into another folder beside it.
fn copied(place: &Path, to: &str) {
    let (from, to) = (place.join("a"), place.join(to));
    let kept = "heap.checkpoints";
    for folder in ["", kept] {
        fs::create_dir_all(to.join(folder)).unwrap();
        for entry in fs::read_dir(from.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.is_file() {
                let name = path.file_name().unwrap();
                fs::copy(&path, to.join(folder).join(name)).unwrap();
            }
        }
    }
}

/// Verifies a run: exit code, and what is said.
fn verified(place: &Path, run: &str, more: &[&str]) -> (Option<i32>, String) {
    let ran = solve(place, &[&["verify", run], more].concat());
    (code(&ran), said(&ran) + &errors(&ran))
}

#[test]
fn a_run_is_verified_in_parts_and_as_a_whole() {
    let place = folder_with("heap.toml", HEAP);
    run(place.path(), "a", &[]);
    let all = verified(place.path(), "a", &["--all", "--jobs", "2"]);
    assert_eq!(all.0, Some(0), "{}", all.1);
    assert!(
        all.1
            .starts_with("a: verified\n  links       25, the last is "),
        "{}",
        all.1
    );
    assert!(
        all.1.contains(
            "2500 of 2500 steps (100.0 %): 0 to 800, 800 to 1600, 1600 to 2400, 2400 to 2500"
        ),
        "{}",
        all.1
    );
    let part = verified(
        place.path(),
        "a",
        &["--steps", "20 %", "--seed", "3", "--json"],
    );
    assert_eq!(part.0, Some(0), "{}", part.1);
    let result: serde_json::Value = serde_json::from_str(&part.1).unwrap();
    assert_eq!(
        (&result["right"], &result["segments_of"]),
        (&true.into(), &4.into())
    );
    assert!(result["share"].as_f64().unwrap() >= 0.2);
    assert_eq!(
        part.1,
        verified(
            place.path(),
            "a",
            &["--steps", "20%", "--seed", "3", "--json"]
        )
        .1
    );
    // Nothing was changed, and no folder is left.
    assert!(verified(place.path(), "a", &["--all"]).0 == Some(0));

    // Of a run that was stopped what it has; with two threads; of a study and a branch as of any run.
    run(
        place.path(),
        "b",
        &[
            "--threads",
            "2",
            "--fixed-threads",
            "--set",
            "output.keep_checkpoints=0",
            "--set",
            "title=\"b\"",
        ],
    );
    let start = verified(place.path(), "b", &[]);
    assert!(
        start.0 == Some(0) && start.1.contains("100 of 2500 steps (4.0 %): 0 to 100"),
        "{}",
        start.1
    );
    let ran = solve(
        place.path(),
        &[
            "--from",
            "a",
            "--at",
            "0.02",
            "--set",
            "gravity=[0,0,-5]",
            "--output",
            "c",
            "--quiet",
        ],
    );
    assert!(ran.status.success(), "{}", errors(&ran));
    let branch = verified(place.path(), "c", &["--all"]);
    assert!(
        branch.0 == Some(0) && branch.1.contains("1500 of 2500 steps"),
        "{}",
        branch.1
    );
}

#[test]
fn what_cannot_be_verified_is_said() {
    let place = folder_with("heap.toml", HEAP);
    run(place.path(), "a", &[]);
    let says = |run: &str, exit: i32, text: &str| {
        let (code, said) = verified(place.path(), run, &[]);
        assert_eq!(code, Some(exit), "{said}");
        assert!(said.contains(text), "{said}");
    };
    says("none", 2, "verify: none: there is no run in this folder");
    copied(place.path(), "b");
    let chain = place.path().join("b/heap.chain.jsonl");
    let text = fs::read_to_string(&chain).unwrap();
    fs::write(&chain, text.replace('\n', "\r\n")).unwrap();
    says("b", 1, "heap.chain.jsonl: line 1 ends in CR LF");
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    fs::write(&chain, [&lines[..3], &lines[2..]].concat().concat()).unwrap();
    says(
        "b",
        1,
        "heap.chain.jsonl: line 4 (step 200) does not follow from the line before it",
    );
    fs::write(&chain, lines[..26].concat()).unwrap();
    says(
        "b",
        1,
        "summary.json: the run had finished, and its chain has no end",
    );
    // Another physics, with links that hold.
    fs::write(
        &chain,
        again(&text, &|line| {
            line.replacen("\"physics\":1", "\"physics\":99", 1)
        }),
    )
    .unwrap();
    says(
        "b",
        2,
        "verify: physics 99 in the run, 1 in this program: only a program with physics 99 can make its steps again",
    );
    fs::remove_file(&chain).unwrap();
    says("b", 2, "verify: b: the run has no chain");
    assert_eq!(verified(place.path(), "a", &["--steps", "0%"]).0, Some(2));
    assert_eq!(verified(place.path(), "a", &["--steps", "3"]).0, Some(2));
    let lock = fs::File::create(place.path().join("a/.lock")).unwrap();
    lock.lock().unwrap();
    says(
        "a",
        2,
        "verify: a: this folder is being written by another run",
    );
}

/// A chain whose lines were edited, with links that hold again.
fn again(text: &str, edit: &dyn Fn(&str) -> String) -> String {
    let mut before = String::new();
    let mut all = String::new();
    for line in text.lines() {
        let members = line.rsplit_once(",\"link\":\"").unwrap().0.to_owned() + "}";
        let members = edit(&members);
        let link = mercury_solver::plan::sha256(format!("{before}{members}").as_bytes());
        all += &format!(
            "{},\"link\":\"{link}\"}}\n",
            members.strip_suffix('}').unwrap()
        );
        before = link;
    }
    all
}

/// A small generator of numbers for edits (Marsaglia 2003, xorshift64).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % limit as u64) as usize
    }
}

/// A checkpoint in which a bit of a section is changed, with its right checksum; see `docs/formats/checkpoint.md`.
fn with_other_section(bytes: &[u8], random: &mut Random) -> Option<Vec<u8>> {
    let mut bytes = bytes.to_vec();
    let number = |bytes: &[u8], at: usize| {
        u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize
    };
    // Places of the contents; the last section has sums of names.
    let mut contents = Vec::new();
    let mut at = 12;
    while at < bytes.len() {
        at += 8 + number(&bytes, at);
        let begin = at + 12;
        let end = begin + number(&bytes, at);
        contents.push(begin..end);
        at = end;
    }
    contents.pop();
    let content = contents[random.below(contents.len())].clone();
    if content.is_empty() {
        return None;
    }
    bytes[content.start + random.below(content.len())] ^= 1 << random.below(8);
    let sum = crc32fast::hash(&bytes[content.clone()]);
    bytes[content.start - 4..content.start].copy_from_slice(&sum.to_le_bytes());
    Some(bytes)
}

/// Single edits, each found and named; `MERCURY_EDITS` sets more.
#[test]
fn no_single_edit_is_missed() {
    let edits: usize = std::env::var("MERCURY_EDITS").map_or(60, |text| text.parse().unwrap());
    let place = folder_with("heap.toml", HEAP);
    run(place.path(), "a", &["--set", "time.end=0.02"]);
    let folder = place.path().join("a");
    let chain = Chain::read(&folder.join("heap.chain.jsonl")).unwrap();
    let outputs = chain.end().unwrap().link.outputs.keys().cloned();
    let mut files: Vec<String> = outputs.collect();
    files.push("heap.chain.jsonl".to_owned());
    files.push("heap.scene.toml".to_owned());
    let kept = kept_checkpoints(&folder, "heap").into_keys();
    let kept: Vec<String> = kept
        .map(|step| format!("heap.checkpoints/{step}.restart"))
        .collect();
    assert!(kept.len() >= 2 && files.len() > 8);
    let mut checkpoints = kept.clone();
    checkpoints.push("heap.0.restart".to_owned());
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut missed = Vec::new();
    for number in 0..edits {
        let is_checkpoint = number % 3 == 0;
        let of = if is_checkpoint { &checkpoints } else { &files };
        let name = &of[number / 3 % of.len()];
        let path = folder.join(name);
        let bytes = fs::read(&path).unwrap();
        let edited = match is_checkpoint {
            true => with_other_section(&bytes, &mut random),
            false => {
                let mut edited = bytes.clone();
                let at = random.below(edited.len());
                match number % 4 {
                    0 => drop(edited.remove(at)),
                    1 => edited.insert(at, 48),
                    _ => edited[at] ^= 1 << random.below(8),
                }
                Some(edited).filter(|edited| *edited != bytes)
            }
        };
        let Some(edited) = edited else { continue };
        fs::write(&path, edited).unwrap();
        let (code, said) = verified(place.path(), "a", &["--all"]);
        fs::write(&path, &bytes).unwrap();
        let last = name.rsplit('/').next().unwrap();
        let is_named = said.contains(last) || said.contains("section") || said.contains("state");
        if code != Some(1) || !is_named {
            missed.push(format!("{name}: {code:?} {said}"));
        }
    }
    assert!(
        missed.is_empty(),
        "{} missed:\n{}",
        missed.len(),
        missed.join("\n")
    );
    assert_eq!(verified(place.path(), "a", &["--all"]).0, Some(0));
}

/// Forgeries with recomputed links are found by the steps: a wrong table, and a wrong state.
#[test]
fn a_forged_run_is_found_where_its_steps_are_made_again() {
    let place = folder_with("heap.toml", HEAP);
    run(place.path(), "a", &[]);
    copied(place.path(), "b");
    let path = place.path().join("b/heap.chain.jsonl");
    let text = fs::read_to_string(&path).unwrap();
    // The state of link 14 is invented.
    let forged = again(&text, &|line| match line.contains("\"step\":1400,") {
        false => line.to_owned(),
        true => {
            let (head, rest) = line.split_once("\"state\":\"").unwrap();
            format!("{head}\"state\":\"{}{}", "0".repeat(8), &rest[8..])
        }
    });
    fs::write(&path, &forged).unwrap();
    let summary = place.path().join("b/summary.json");
    let link = Chain::read(&path).unwrap().last().to_owned();
    let old = Chain::read(&place.path().join("a/heap.chain.jsonl")).unwrap();
    let text = fs::read_to_string(&summary).unwrap();
    fs::write(&summary, text.replace(old.last(), &link)).unwrap();
    let (code, said) = verified(place.path(), "b", &["--all"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains(
            "verify: link 14 (step 1400) differs, in its state; it was made again from step 800"
        ),
        "{said}"
    );
    let (code, said) = verified(place.path(), "b", &[]);
    assert!(code == Some(0) || code == Some(1), "{said}");
}
