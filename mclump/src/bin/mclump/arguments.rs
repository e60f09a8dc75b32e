//! Arguments of the command line.

use std::path::PathBuf;

use clap::{Parser, ValueEnum};
use mercury_common::cli::{Shell, positive, quantity};
use mercury_common::units::Dimension;

const EXAMPLES: &str = "\
Examples:
  mclump rod.csv --density 2500                       pebbles x,y,z,r; writes rod.clump.toml
  mclump rod.csv --inertia union                      overlaps of pebbles count once
  mclump celt.stl celt.csv --scale 1mm                files in mm; inertia from the surface
  mclump celt.stl --generate tangent --pebbles 100    pebbles made for the surface
  mclump celt.stl --generate tangent --pebbles 20 --protrusion auto
                                                      few pebbles of the surface's volume
  mclump celt.stl                                     look at the surface; no clump is written
  mclump celt.stl celt.csv --repair --json            close small holes; result as JSON, for scripts

Files: NAME.clump.toml, NAME.pebbles.csv, NAME.pebbles.vtu, NAME.png and with a surface NAME.surface.stl, NAME.surface.vtu.
Exit codes: 0 done, 1 the clump cannot be made or written, 2 wrong usage or input.";

/// Makes a rigid clump from a surface and pebbles: mass, centre, inertia, principal axes.
#[derive(Debug, Parser)]
#[command(name = "mclump", version, after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// A surface (.stl, .obj), a pebble list (x,y,z,r per line), or both
    #[arg(value_name = "FILE", required_unless_present = "completions", num_args = 1..=2)]
    pub(crate) files: Vec<PathBuf>,

    /// The clump file; a name without suffix gets .clump.toml [default: NAME.clump.toml in this folder]
    #[arg(short, long, value_name = "NAME.clump.toml")]
    pub(crate) output: Option<PathBuf>,

    /// Where mass, centre and inertia come from [default: surface; without one pebbles, or union where they overlap]
    #[arg(long, value_name = "ROUTE")]
    pub(crate) inertia: Option<RouteName>,

    /// Density in kg/m3, or with a unit: "2.5 g/cm3"
    #[arg(long, value_name = "RHO", default_value_t = 1.0, allow_negative_numbers = true, value_parser = quantity(Dimension::DENSITY))]
    pub(crate) density: f64,

    /// Length in m of one unit of the files: 1e-3 or "1 mm" for files in mm
    #[arg(long, value_name = "LENGTH", default_value_t = 1.0, allow_negative_numbers = true, value_parser = quantity(Dimension::LENGTH))]
    pub(crate) scale: f64,

    /// Make pebbles for the surface
    #[arg(long, value_name = "METHOD")]
    pub(crate) generate: Option<MethodName>,

    /// Number of pebbles to make
    #[arg(long, value_name = "N", requires = "generate", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) pebbles: Option<u32>,

    /// Make pebbles until the volume of their union falls short of the surface's by at most this fraction (favier: differs)
    #[arg(long, value_name = "FRACTION", requires = "generate", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) fidelity: Option<f64>,

    /// No pebble smaller than this radius in m, or with a unit: "50 um" [default: 1/1000 of the body]
    #[arg(long, value_name = "LENGTH", requires = "generate", allow_negative_numbers = true, value_parser = quantity(Dimension::LENGTH))]
    pub(crate) smallest_radius: Option<f64>,

    /// How far each pebble may stand out of the surface in m, or with a unit; auto: as far as makes the volume that of the surface [default: 0]
    #[arg(long, value_name = "LENGTH", requires = "generate", allow_negative_numbers = true, value_parser = protrusion)]
    pub(crate) protrusion: Option<Protrusion>,

    /// Seed of the generator's random points
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        allow_negative_numbers = true
    )]
    pub(crate) seed: u64,

    /// Mend the surface: weld vertices, drop doubled triangles, turn inconsistent ones, close small holes
    #[arg(long)]
    pub(crate) repair: bool,

    /// Voxels along the longest edge
    #[arg(long, value_name = "N", default_value_t = 100, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=2000))]
    pub(crate) voxels: u32,

    /// Refine the voxels to this relative accuracy
    #[arg(long, value_name = "FRACTION", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) voxel_tolerance: Option<f64>,

    /// Describe the shape of a surface of any size (elongation, sphericity, roundness, ...)
    #[arg(long)]
    pub(crate) shape: bool,

    /// Leave out the picture
    #[arg(long)]
    pub(crate) no_picture: bool,

    /// Replace files that are there already
    #[arg(long)]
    pub(crate) force: bool,

    /// No report, only errors
    #[arg(long)]
    pub(crate) quiet: bool,

    /// Print the result as one JSON object on standard output
    #[arg(long)]
    pub(crate) json: bool,

    /// Print completions for a shell and exit
    #[arg(long, value_name = "SHELL")]
    pub(crate) completions: Option<Shell>,
}

/// How far pebbles stand out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Protrusion {
    /// So far, m.
    Length(f64),
    /// Protrusion at which the volume of the union is that of the surface.
    Auto,
}

fn protrusion(text: &str) -> Result<Protrusion, String> {
    if text == "auto" {
        return Ok(Protrusion::Auto);
    }
    quantity(Dimension::LENGTH)(text).map(Protrusion::Length)
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum RouteName {
    /// Signed tetrahedra of the surface
    Surface,
    /// The space that the pebbles cover
    Union,
    /// The space that the pebbles cover, by voxels
    Voxels,
    /// Every pebble for itself
    Pebbles,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum MethodName {
    /// Largest balls by the distance to the surface
    Euclidean,
    /// Balls tangent to the surface, chosen for the volume they add
    Tangent,
    /// One ball per slab, for bodies of revolution
    Favier,
}
