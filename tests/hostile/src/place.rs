//! A folder for the files of a reader, and samples that programs of Mercury wrote.

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use mercury_solver::plan::{document, parse_scene, plan};
use mercury_solver::run::{Checkpoints, RunOptions, memory, run};

/// A temporary folder.
#[derive(Debug)]
pub struct Place {
    folder: tempfile::TempDir,
    run: OnceCell<PathBuf>,
}

/// The folder of the repository.
#[must_use]
pub fn repository() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.parent().and_then(Path::parent).unwrap_or(own)
}

/// A file of the repository.
///
/// # Panics
/// If it is not there.
#[must_use]
pub fn file(name: &str) -> Vec<u8> {
    let path = repository().join(name);
    fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

impl Place {
    /// A new one.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn new() -> io::Result<Self> {
        // In memory where the system has such a folder: there are hundreds of thousands of files.
        let memory = Path::new("/dev/shm");
        let folder = if memory.is_dir() {
            tempfile::tempdir_in(memory)?
        } else {
            tempfile::tempdir()?
        };
        Ok(Self {
            folder,
            run: OnceCell::new(),
        })
    }

    /// The path of a file in it.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file.
    ///
    /// # Panics
    /// If it cannot be written.
    pub fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, bytes).expect("the temporary folder takes a file");
        path
    }

    /// The scene of [`Self::run`], which stands in this folder with all its files.
    ///
    /// # Panics
    /// If the folder takes no files.
    pub fn scene(&self) -> String {
        for (name, from) in [
            ("rod.clump.toml", "tests/scenes/good/rod.clump.toml"),
            ("dish.obj", "tests/scenes/good/dish.obj"),
            ("lift.csv", "tests/scenes/good/lift.csv"),
            ("some.csv", "tests/scenes/good/some.csv"),
            ("sizes.csv", "tests/scenes/good/sizes.csv"),
            ("rate.csv", "tests/scenes/good/rate.csv"),
        ] {
            self.write(name, &file(from));
        }
        let scene = include_str!("scene.toml").to_owned();
        self.write("scene.toml", scene.as_bytes());
        scene
    }

    /// The folder of a short run with particles, contacts, bodies, walls and a checkpoint; the prefix is `scene`.
    ///
    /// # Panics
    /// If it fails.
    pub fn run(&self) -> &Path {
        self.run.get_or_init(|| {
            let text = self.scene();
            let path = self.path("scene.toml");
            let scene = parse_scene(&path, &text, &[], mercury_common::scene::Files::MustExist)
                .unwrap_or_else(|errors| panic!("{errors}"));
            let stated: BTreeMap<String, String> =
                scene.statement.entries().expect("the files are there");
            let plan = plan(&scene).unwrap_or_else(|errors| panic!("{errors}"));
            let folder = self.path("run");
            fs::create_dir_all(&folder).expect("a folder");
            let options = RunOptions {
                folder: folder.clone(),
                threads: 1,
                plan_document: Some(document(&plan, &memory(&plan)).expect("a plan in words")),
                checkpoints: Some(Checkpoints {
                    every: None,
                    at_end: true,
                    now: std::sync::Arc::default(),
                    scene: stated,
                }),
                ..RunOptions::default()
            };
            run(plan, &options, &mut |_| {}).unwrap_or_else(|error| panic!("{error}"));
            folder
        })
    }

    /// A file of the run.
    ///
    /// # Panics
    /// If it is not there.
    pub fn of_run(&self, name: &str) -> Vec<u8> {
        let path = self.run().join(name);
        fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    }
}
