//! Hostile input for every reader: no panic, no hang, no memory beyond a bound.
//!
//! Each reader runs in a process of its own, which is watched: whatever ends it (a stack that overflows, memory that cannot be
//! had, a loop without end) is reported with the file that caused it. `MERCURY_HOSTILE_CASES` sets the number of files for each
//! reader, `MERCURY_HOSTILE_SEED` other files, `MERCURY_HOSTILE_GROWN` the bytes of the large ones; with `MERCURY_HOSTILE_KEEP`
//! all files are kept.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::FileExt as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use mercury_hostile::checks::{Stopwatch, longest};
use mercury_hostile::place::{Place, repository};
use mercury_hostile::readers::{self, Reader};
use peak_alloc::PeakAlloc;

#[global_allocator]
static COUNTED: PeakAlloc = PeakAlloc;

/// Default number of files for each reader: all of them together take some seconds.
const CASES: u64 = 150;
/// Bytes of the large files.
const GROWN: u64 = 1 << 18;
/// A process that is at one file for so long hangs.
const HANGS: Duration = Duration::from_secs(300);
/// Faults of one reader that are reported at once.
const MOST_FAULTS: usize = 12;

fn number(name: &str, default: u64) -> u64 {
    match std::env::var(name) {
        Ok(text) => text
            .parse()
            .unwrap_or_else(|_| panic!("{name}={text} is no whole number")),
        Err(_) => default,
    }
}

fn seed() -> u64 {
    number("MERCURY_HOSTILE_SEED", 1)
}

fn grown() -> usize {
    number("MERCURY_HOSTILE_GROWN", GROWN) as usize
}

thread_local! {
    /// Message of the last panic, and its place.
    static PANIC: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Notes the panics of this thread, and of those that a reader starts, in place of reporting them. Other tests report theirs.
fn note_panics() {
    let own = std::thread::current().id();
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        let thread = std::thread::current();
        if thread.id() != own && thread.name().is_some() {
            return report(info);
        }
        let place = info.location().map(ToString::to_string).unwrap_or_default();
        let words = info
            .payload_as_str()
            .unwrap_or("a panic without words")
            .to_owned();
        PANIC.with_borrow_mut(|last| *last = format!("{place}: {words}"));
    }));
}

/// Fault in how a reader takes a file, if there is one.
fn fault(reader: &Reader, place: &Place, bytes: &[u8]) -> Result<(), String> {
    let size = (reader.size)(bytes);
    COUNTED.reset_peak_usage();
    let before = COUNTED.current_usage();
    let watch = Stopwatch::start();
    let read = catch_unwind(AssertUnwindSafe(|| (reader.read)(bytes, place)));
    let (time, peak) = (
        watch.elapsed(),
        COUNTED.peak_usage().saturating_sub(before) as u64,
    );
    if read.is_err() {
        return Err(PANIC.with_borrow(Clone::clone));
    }
    if time > longest(size) {
        return Err(format!(
            "{time:.1?} for {size} bytes, at most {:.1?}",
            longest(size)
        ));
    }
    let most = reader.bound.of(size);
    if peak > most {
        return Err(format!(
            "{peak} bytes were allocated for {size} bytes, at most {most}"
        ));
    }
    if std::env::var_os("MERCURY_HOSTILE_SHOW").is_some() && size > 4000 {
        println!(
            "{} {size} bytes: {peak} allocated, {:.1} for each; {time:.3?}",
            reader.name,
            peak as f64 / size as f64
        );
    }
    Ok(())
}

/// Runs inside the process that is watched. It reports its progress after each file.
#[test]
#[ignore = "the tests below start it"]
fn worker() {
    let Ok(name) = std::env::var("MERCURY_HOSTILE_WORKER") else {
        return;
    };
    let reader = readers::all()
        .iter()
        .find(|reader| reader.name == name)
        .expect("a reader");
    let (first, count) = (
        number("MERCURY_HOSTILE_FIRST", 0),
        number("MERCURY_HOSTILE_COUNT", 1),
    );
    let progress = std::env::var("MERCURY_HOSTILE_PROGRESS").expect("a file for the progress");
    let progress = fs::File::create(progress).expect("a file for the progress");
    let place = Place::new().expect("a temporary folder");
    let mut samples = (reader.samples)(&place);
    samples.extend(small(reader));
    if std::env::var_os("MERCURY_HOSTILE_LOUD").is_none() {
        note_panics();
    }
    let mut faults = BTreeMap::new();
    for number in first..first + count {
        progress
            .write_all_at(&number.to_le_bytes(), 0)
            .expect("progress");
        let bytes = mercury_hostile::case(reader, &samples, seed(), number, grown());
        if std::env::var_os("MERCURY_HOSTILE_KEEP").is_some() {
            keep(reader, number, &bytes);
        }
        if let Err(fault) = fault(reader, &place, &bytes) {
            // Numbers in words do not make another fault.
            let kind: String = fault
                .chars()
                .filter(|c| !c.is_ascii_digit() || fault.contains(".rs:"))
                .take(120)
                .collect();
            let known = faults.entry(kind).or_insert_with(|| {
                let path = keep(reader, number, &bytes);
                (0, format!("{fault}\n    {}", path.display()))
            });
            known.0 += 1;
            if faults.len() >= MOST_FAULTS {
                break;
            }
        }
    }
    for (times, fault) in faults.values() {
        eprintln!("{times} x {fault}");
    }
    std::process::exit(i32::from(!faults.is_empty()));
}

/// Writes the file of a case, to be examined later.
fn keep(reader: &Reader, number: u64, bytes: &[u8]) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("hostile");
    let path = folder.join(format!("{}-{}-{number}", reader.name, seed()));
    let written = fs::create_dir_all(&folder).and_then(|()| fs::write(&path, bytes));
    written.expect("the folder for tests takes a file");
    path
}

/// The small files of the corpus, which are mutated as the samples are.
fn small(reader: &Reader) -> impl Iterator<Item = Vec<u8>> {
    let files = corpus(reader).into_iter().map(|(_, bytes)| bytes);
    files.filter(|bytes| bytes.len() <= 4000)
}

/// The files of `tests/corpus/NAME`.
fn corpus(reader: &Reader) -> Vec<(String, Vec<u8>)> {
    let folder = repository().join("tests/corpus").join(reader.name);
    let mut files: Vec<_> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .map(|entry| entry.expect("the corpus can be listed").path())
        .map(|path| {
            (
                path.file_name()
                    .unwrap_or_default()
                    .to_string_lossy()
                    .into_owned(),
                fs::read(&path).expect("a file of the corpus"),
            )
        })
        .collect();
    files.sort();
    files
}

/// Reads `cases` files in processes of their own, and goes on behind a file that ended one.
fn hostile(name: &str) {
    let reader = readers::all()
        .iter()
        .find(|reader| reader.name == name)
        .expect("a reader");
    let cases = number("MERCURY_HOSTILE_CASES", CASES);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let progress = folder.path().join("progress");
    let mut first = number("MERCURY_HOSTILE_FROM", 0);
    let last = first + cases;
    let mut faults = Vec::new();
    while first < last && faults.len() < MOST_FAULTS {
        let errors = fs::File::create(folder.path().join("errors")).expect("a file");
        let _ = fs::remove_file(&progress);
        let mut child = Command::new(std::env::current_exe().expect("this program"))
            .args([
                "--exact",
                "worker",
                "--ignored",
                "--nocapture",
                "--test-threads=1",
            ])
            .env("MERCURY_HOSTILE_WORKER", name)
            .env("MERCURY_HOSTILE_FIRST", first.to_string())
            .env("MERCURY_HOSTILE_COUNT", (last - first).to_string())
            .env("MERCURY_HOSTILE_PROGRESS", &progress)
            .stdout(if std::env::var_os("MERCURY_HOSTILE_SHOW").is_some() {
                Stdio::inherit()
            } else {
                Stdio::null()
            })
            .stderr(errors)
            .spawn()
            .expect("a process");
        let at = || {
            let bytes = fs::read(&progress).ok()?;
            Some(u64::from_le_bytes(bytes.try_into().ok()?))
        };
        let (mut since, mut known, mut pause) = (Instant::now(), None, 1);
        let (ended, hung) = loop {
            if let Some(status) = child.try_wait().expect("a process") {
                break (status.code(), false);
            }
            let now = at();
            if now != known {
                (since, known) = (Instant::now(), now);
            } else if since.elapsed() > HANGS {
                child.kill().expect("a process of our own");
                child.wait().expect("a process of our own");
                break (None, true);
            }
            std::thread::sleep(Duration::from_millis(pause));
            pause = (pause * 2).min(50);
        };
        let errors = fs::read_to_string(folder.path().join("errors")).unwrap_or_default();
        if let (Some(0), Some(_)) = (ended, at()) {
            break;
        }
        let (Some(number), false) = (at(), ended == Some(1) && !errors.contains("has overflowed"))
        else {
            faults.push(errors);
            break;
        };
        // It died: the file is made once more, here.
        let place = Place::new().expect("a temporary folder");
        let mut samples = (reader.samples)(&place);
        samples.extend(small(reader));
        let bytes = mercury_hostile::case(reader, &samples, seed(), number, grown());
        let path = keep(reader, number, &bytes);
        let how = if hung {
            format!("hangs for {HANGS:?}")
        } else {
            format!("ends the process: {errors}")
        };
        faults.push(format!("{how}\n    {}", path.display()));
        first = number + 1;
    }
    assert!(faults.is_empty(), "{name}:\n{}", faults.join("\n"));
}

macro_rules! readers {
    ($($test:ident $name:literal)*) => {
        $(#[test]
        fn $test() {
            hostile($name);
        })*

        #[test]
        fn every_reader_has_a_test() {
            let tested = [$($name),*];
            let all: Vec<&str> = readers::all().iter().map(|reader| reader.name).collect();
            assert_eq!(all, tested);
            for name in all {
                let target = repository().join(format!("fuzz/fuzz_targets/{name}.rs"));
                let call = format!("mercury_hostile::fuzz(\"{name}\", bytes)");
                let text = fs::read_to_string(target).unwrap_or_default();
                assert!(text.contains(&call), "fuzz/ has no target for {name}");
            }
        }
    };
}

readers! {
    scene "scene"
    overrides "override"
    clump_file "clump-file"
    size_law "size-law"
    size_law_of_files "size-law-of-files"
    scene_with_particles "scene-with-particles"
    scene_with_mesh "scene-with-mesh"
    scene_with_stl "scene-with-stl"
    scene_with_motion "scene-with-motion"
    scene_with_rate "scene-with-rate"
    scene_with_sizes "scene-with-sizes"
    scene_with_clump "scene-with-clump"
    scene_from_run "scene-from-run"
    data "data"
    fstat "fstat"
    ene "ene"
    particle_csv "particle-csv"
    pebble_list "pebble-list"
    stl "stl"
    stl_text "stl-text"
    obj "obj"
    motion_table "motion-table"
    pvd "pvd"
    frames_particles "frames-particles"
    frames_contacts "frames-contacts"
    frames_bonds "frames-bonds"
    frames_bodies "frames-bodies"
    frames_walls "frames-walls"
    frames_surfaces "frames-surfaces"
    frames_triangle_loads "frames-triangle-loads"
    frames_wear "frames-wear"
    frames_wear_triangles "frames-wear-triangles"
    frames_membranes "frames-membranes"
    frames_membrane_triangles "frames-membrane-triangles"
    checkpoint "checkpoint"
    checkpoint_resumed "checkpoint-resumed"
    run_resumed "run-resumed"
    lock "lock"
    plan_document "plan-document"
    size_table "size-table"
    sizes_argument "sizes-argument"
    sizes_parquet "sizes-parquet"
    psd_run_frames "psd-run-frames"
    psd_run_plan "psd-run-plan"
    csv_table "csv-table"
    parquet "parquet"
    cg_data "cg-data"
    cg_fstat "cg-fstat"
    cg_data_compressed "cg-data-compressed"
    restart "restart"
    restart_compressed "restart-compressed"
    cg_run "cg-run"
    cg_run_contacts "cg-run-contacts"
    cg_points "cg-points"
    cg_fields "cg-fields"
    xballs_script "xballs-script"
    export_data "export-data"
    export_run "export-run"
    export_files "export-files"
    export_pictures "export-pictures"
    export_bonds "export-bonds"
}

/// Each file of the corpus broke a reader once; `tests/corpus/README.md` has a line on each.
#[test]
fn the_corpus_is_read() {
    let lines = fs::read_to_string(repository().join("tests/corpus/README.md"))
        .expect("the list of the corpus");
    let mut wrong = String::new();
    note_panics();
    for reader in readers::all() {
        let files = corpus(reader);
        if files.is_empty() {
            continue;
        }
        let place = Place::new().expect("a temporary folder");
        (reader.samples)(&place);
        for (name, bytes) in files {
            if let Err(fault) = fault(reader, &place, &bytes) {
                wrong += &format!("{}/{name}: {fault}\n", reader.name);
            }
            if !lines.contains(&format!("`{}/{name}`", reader.name)) {
                wrong += &format!(
                    "{}/{name}: no line in tests/corpus/README.md\n",
                    reader.name
                );
            }
        }
    }
    let _ = std::panic::take_hook();
    assert!(wrong.is_empty(), "{wrong}");
}
