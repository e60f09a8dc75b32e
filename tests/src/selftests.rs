//! MercuryDPM's own self tests, run by our engine and compared with the files it ships, number by number.
//!
//! The files stay outside the project. Time: the source adds up its steps and may make one step more than end/dt; it writes before
//! a step and once at the end. `run` makes the same steps and looks at the same states; our time of a state is its step number
//! times dt, which is what is compared with the printed time. Laws are taken in the source's variants where they differ from our
//! defaults (springs turned incrementally, spring increment in the first force evaluation, lever 2R* of rolling).

mod collisions;
mod comparison;
mod deletion;
mod dense_packing;
mod discs;
mod impacts;
mod mindlin;
mod restart_file;
mod run;
mod squeezed_sphere;
mod wall_friction;

use std::path::PathBuf;

use anyhow::Result;

pub use comparison::{Comparison, Tolerance};
pub use dense_packing::energy_of_a_packing;

/// Where the shipped files are.
#[derive(Debug, Clone, PartialEq)]
pub struct Data {
    folder: PathBuf,
}

impl Data {
    /// The files beside the project; `None` where they are not installed.
    #[must_use]
    pub fn find() -> Option<Self> {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/selftest");
        folder.is_dir().then_some(Self { folder })
    }

    /// The path of one file.
    fn file(&self, relative: &str) -> PathBuf {
        self.folder.join(relative)
    }
}

/// A set-up: its number in the list of the reference data, and how it is run.
pub struct SetUp {
    /// Number.
    pub number: u32,
    /// Runs and compares.
    pub run: fn(&Data) -> Result<Comparison>,
}

/// All set-ups.
pub const ALL: [SetUp; 18] = [
    SetUp {
        number: 1,
        run: collisions::two_particles,
    },
    SetUp {
        number: 2,
        run: collisions::free_fall,
    },
    SetUp {
        number: 3,
        run: collisions::newtons_cradle,
    },
    SetUp {
        number: 4,
        run: collisions::square_packing,
    },
    SetUp {
        number: 6,
        run: impacts::plastic,
    },
    SetUp {
        number: 7,
        run: impacts::hertz_wall,
    },
    SetUp {
        number: 8,
        run: |data| wall_friction::run(data, 0),
    },
    SetUp {
        number: 9,
        run: |data| wall_friction::run(data, 1),
    },
    SetUp {
        number: 10,
        run: |data| wall_friction::run(data, 2),
    },
    SetUp {
        number: 11,
        run: |data| wall_friction::run(data, 3),
    },
    SetUp {
        number: 12,
        run: |data| wall_friction::run(data, 4),
    },
    SetUp {
        number: 19,
        run: discs::extreme_overlap,
    },
    SetUp {
        number: 20,
        run: squeezed_sphere::rolling,
    },
    SetUp {
        number: 21,
        run: squeezed_sphere::torsion,
    },
    SetUp {
        number: 22,
        run: mindlin::oblique_impact,
    },
    SetUp {
        number: 23,
        run: mindlin::loading,
    },
    SetUp {
        number: 24,
        run: mindlin::shearing,
    },
    SetUp {
        number: 29,
        run: deletion::deletion,
    },
];

/// Runs the set-up with this number.
///
/// # Errors
/// If there is none, a file cannot be read, or a file and the run differ in structure.
pub fn run_number(data: &Data, number: u32) -> Result<Comparison> {
    let set_up = ALL.iter().find(|set_up| set_up.number == number);
    let set_up = set_up.ok_or_else(|| anyhow::anyhow!("there is no set-up {number}"))?;
    (set_up.run)(data)
}
