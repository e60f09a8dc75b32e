//! Arguments of the command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use mercury_common::cli;
use mercury_common::formats::vtu::{VtuCompression, VtuPrecision};
use mercury_common::run_tables::{self, TableSpec};
use mercury_export::sinks::pictures;
use mercury_export::{ClumpsAs, FrameChoice, Region, Table};

use crate::picture_command::Look;

const EXAMPLES: &str = "\
Examples:
  mercury-export vtu drum                        series for ParaView in drum/vtu/
  mercury-export vtu drum --frames last --region \"z=0..0.05\" --precision single -o small
  mercury-export xballs drum                     drum/xballs/drum.data and drum.disp, which starts XBalls
  mercury-export vtu old.data                    a file of MercuryDPM, or the .disp or .xballs that shows it
  mercury-export vtu stones --clumps surface     clumps as their own surfaces, stones.clumps.pvd
  mercury-export csv drum --frames \"every 10\"    a table per frame
  mercury-export csv drum --table walls          the loads on the walls, drum.walls.csv, names with units
  mercury-export parquet drum --table contacts   all contacts of all frames in one table
  mercury-export parquet repose-study            the table of a study: repose-study/study.parquet
  mercury-export query drum \"SELECT material, AVG(vz) FROM particles WHERE time > 0.3 GROUP BY material\"
  mercury-export query drum \"SELECT time, fz FROM walls WHERE name = 'lid'\" -o lid.csv
  mercury-export particles drum --frames last    the table that scenes read: file = \"drum.0010.csv\"
  mercury-export particles bed.lmp               the same from a dump or data file of LAMMPS or LIGGGHTS, with what the scene says
  mercury-export lammps drum                     a dump that OVITO and LAMMPS read
  mercury-export stl screen --frames last        its worn meshes, screen.bars.0100.stl, which a scene can take
  mercury-export png screen --frames last --colour depth   how deep its walls are worn
  mercury-export png drum --frames last          the last frame as a picture, drum/png/drum.0050.png
  mercury-export png drum --strip 5 --size 1600x420   five frames side by side
  mercury-export gif drum --colour material --size 640x480   a film in drum/film/drum.gif

INPUT is a run folder, NAME.particles.arrow, NAME.data, NAME.data.0000 (a series), NAME.disp, NAME.xballs, or a dump \
(dump custom) or data file (read_data) of spheres of LAMMPS or LIGGGHTS in SI units, whatever its name.
Exit codes: 0 done (also if the input was cut: its good frames are there, and a warning says so), 1 a file could not be \
written, 2 wrong usage or input.";

/// Turns what the solver wrote into what people look at.
#[derive(Debug, Parser)]
#[command(name = "mercury-export", version, after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Series for ParaView, pyvista and meshio: .vtu files, .pvd lists with times, and a script that opens them
    Vtu {
        #[command(flatten)]
        common: Common,
        /// 64 bits per number, or 32 in half the space
        #[arg(long, value_enum, default_value_t)]
        precision: Precision,
        /// none, fast (only what shrinks), or a level from 1 (fast) to 9 (small)
        #[arg(long, default_value = "fast", value_parser = compression, allow_negative_numbers = true)]
        compression: VtuCompression,
        /// Leave contacts, and the liquid bridges among them, out
        #[arg(long)]
        no_contacts: bool,
        /// Leave walls out
        #[arg(long)]
        no_walls: bool,
        /// Clumps as spheres, as their own surfaces (.clumps.pvd), or both
        #[arg(long, value_enum, default_value_t)]
        clumps: ClumpsName,
    },
    /// .data as XBalls and MercuryDPM's tools read it, and the script .disp that starts XBalls
    Xballs {
        #[command(flatten)]
        common: Common,
        /// 2 (format 8) or 3 (format 14) [default: what the input is]
        #[arg(long, value_parser = clap::value_parser!(u8).range(2..=3), allow_negative_numbers = true)]
        dimensions: Option<u8>,
        /// The last column, which XBalls colours by: material, speed, or the name of a column
        #[arg(long, default_value = "material")]
        info: String,
        /// Significant digits (10 is MercuryDPM's look) [default: as many as read back exactly]
        #[arg(long, value_parser = clap::value_parser!(u8).range(1..=17), allow_negative_numbers = true)]
        digits: Option<u8>,
    },
    /// Tables as text, one file per frame; of those that a run writes as text the whole
    Csv {
        #[command(flatten)]
        common: Common,
        /// Particles, contacts, bodies (clumps) or worn triangles frame by frame; any other as a whole
        #[arg(long, value_enum, default_value_t)]
        table: TableName,
    },
    /// All frames in one Parquet table, one row group per frame; of a study, its table of runs
    Parquet {
        #[command(flatten)]
        common: Common,
        /// Particles, contacts, bodies (clumps) or worn triangles, all frames; or a table that the run wrote as text
        #[arg(long, value_enum, default_value_t)]
        table: TableName,
    },
    /// SQL over the tables of a run or study, printed or written; frames are read part by part, so that they need not fit into memory
    Query {
        /// Run folder or its .particles.arrow, or the folder of a study
        #[arg(value_name = "INPUT")]
        input: PathBuf,
        /// SELECT ... FROM particles (contacts, bodies, walls, flux, ..., study); times of frames are the column `time`
        sql: String,
        /// Write the whole answer to this file: .csv, .parquet or .arrow
        #[arg(short, long, value_name = "FILE")]
        output: Option<PathBuf>,
        /// Replace a file that is there
        #[arg(long)]
        force: bool,
    },
    /// The particle table that scenes read, one file per frame, and what a scene says to start from it
    Particles {
        #[command(flatten)]
        common: Common,
    },
    /// A text dump of all frames for LAMMPS, LIGGGHTS and OVITO
    Lammps {
        #[command(flatten)]
        common: Common,
    },
    /// Data files for read_data of LAMMPS (atom_style sphere) and LIGGGHTS (granular), one per frame
    Liggghts {
        #[command(flatten)]
        common: Common,
        /// Density of all particles in kg/m^3; needed where the input has no masses (.data)
        #[arg(long, allow_negative_numbers = true)]
        density: Option<f64>,
    },
    /// Mesh walls as they are at each frame, worn or not: .stl, one file per wall and frame, in the units and the frame of the mesh file of the scene
    Stl {
        #[command(flatten)]
        common: Common,
        /// In metres and the frame of the scene instead: for a wall without scale, rotate and offset
        #[arg(long)]
        scene_frame: bool,
    },
    /// Pictures of frames: shaded particles, walls, colour bar, scale
    Png {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        look: Look,
        /// Instead of a picture of each frame one with N of them side by side
        #[arg(long, value_name = "N", value_parser = strip, allow_negative_numbers = true)]
        strip: Option<usize>,
    },
    /// Pictures of frames as vector graphics
    Svg {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        look: Look,
    },
    /// A film as animated GIF: plays anywhere, 255 colours a frame
    Gif {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        look: Look,
        /// Seconds that the film takes [default: 20 frames a second]
        #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
        duration: Option<f64>,
    },
    /// A film as animated PNG: all colours, plays in browsers
    Apng {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        look: Look,
        /// Seconds that the film takes [default: 20 frames a second]
        #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
        duration: Option<f64>,
    },
    /// Completions for a shell
    Completions {
        /// The shell
        shell: cli::Shell,
    },
}

#[derive(Debug, Args)]
pub(crate) struct Common {
    /// Run folder or file
    #[arg(value_name = "INPUT")]
    pub(crate) input: PathBuf,
    /// Folder for the files [default: a folder named after the command, beside the input]; of one picture or film also its file: drum.png
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// all, last, a number, A..B (without B), A.., ..B, "every N", or A..B/N
    #[arg(long, default_value = "all", allow_negative_numbers = true)]
    pub(crate) frames: FrameChoice,
    /// Only particles with their centre in a box, as in x=0..0.1,z=..0.05 (m)
    #[arg(long, value_name = "RANGES")]
    pub(crate) region: Option<Region>,
    /// Only particles of this material, by name or index; may be repeated
    #[arg(long, value_name = "NAME", allow_negative_numbers = true)]
    pub(crate) material: Vec<String>,
    /// Replace files of an earlier export
    #[arg(long)]
    pub(crate) force: bool,
    /// No progress and no report, only errors and warnings
    #[arg(long)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub(crate) enum Precision {
    #[default]
    Double,
    Single,
}

impl From<Precision> for VtuPrecision {
    fn from(name: Precision) -> Self {
        match name {
            Precision::Double => Self::Double,
            Precision::Single => Self::Single,
        }
    }
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub(crate) enum ClumpsName {
    #[default]
    Pebbles,
    Surface,
    Both,
}

impl From<ClumpsName> for ClumpsAs {
    fn from(name: ClumpsName) -> Self {
        match name {
            ClumpsName::Pebbles => Self::Pebbles,
            ClumpsName::Surface => Self::Surface,
            ClumpsName::Both => Self::Both,
        }
    }
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub(crate) enum TableName {
    #[default]
    Particles,
    Contacts,
    Bonds,
    Bodies,
    #[value(name = "wear_triangles", alias = "wear-triangles")]
    WearTriangles,
    Walls,
    Regions,
    Flux,
    Left,
    Track,
    Budget,
    Liquid,
    Breaks,
    Wear,
    Membranes,
    Holds,
    Results,
}

impl TableName {
    /// A table of frames, or one that is text.
    pub(crate) fn kind(self) -> Result<Table, &'static TableSpec> {
        match self {
            Self::Particles => Ok(Table::Particles),
            Self::Contacts => Ok(Table::Contacts),
            Self::Bonds => Ok(Table::Bonds),
            Self::Bodies => Ok(Table::Bodies),
            Self::WearTriangles => Ok(Table::WearTriangles),
            Self::Walls => Err(&run_tables::WALLS),
            Self::Regions => Err(&run_tables::REGIONS),
            Self::Flux => Err(&run_tables::FLUX),
            Self::Left => Err(&run_tables::LEFT),
            Self::Track => Err(&run_tables::TRACK),
            Self::Budget => Err(&run_tables::BUDGET),
            Self::Liquid => Err(&run_tables::LIQUID),
            Self::Breaks => Err(&run_tables::BREAKS),
            Self::Wear => Err(&run_tables::WEAR),
            Self::Membranes => Err(&run_tables::MEMBRANES),
            Self::Holds => Err(&run_tables::HOLDS),
            Self::Results => Err(&run_tables::RESULTS),
        }
    }
}

fn compression(text: &str) -> Result<VtuCompression, String> {
    match text {
        "none" => Ok(VtuCompression::None),
        "fast" => Ok(VtuCompression::Adaptive),
        _ => match text.parse() {
            Ok(level @ 1..=9) => Ok(VtuCompression::Level(level)),
            _ => Err("expected none, fast, or a level from 1 to 9".to_owned()),
        },
    }
}

fn strip(text: &str) -> Result<usize, String> {
    let most = pictures::LONGEST_STRIP;
    let number = text.parse().ok();
    let number = number.filter(|number| (1..=most).contains(number));
    number.ok_or_else(|| format!("expected 1 to {most} frames"))
}
