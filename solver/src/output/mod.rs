//! The files of a run: frames, energies, wall loads, pictures, its summary and its log.
//!
//! The time loop hands a [`FrameCopy`] to the [`Writer`], whose thread puts it in the order of ids and gives it to one
//! `Stream` for each file. The modules: `schedule` decides when, `moment` and `state` hold what, `energies` sums up, and each kind of
//! file has its own module; `folder` guards what is already there.

mod body_frames;
mod budget;
mod budget_file;
pub mod chain;
mod contact_frames;
mod data_file;
mod data_rows;
mod ene_file;
mod energies;
mod field_tables;
mod final_picture;
pub mod folder;
mod frame_copy;
mod fstat_file;
mod memory;
mod particle_frames;
mod schedule;
pub(crate) mod stream;
pub mod summary;
pub(crate) mod table_file;
#[cfg(test)]
mod tests;
mod track_file;
mod triangle_loads;
mod vtk_files;
mod wall_frames;
mod wall_loads;
mod writer;

pub use budget::{BudgetRow, Exchanged, Gap, energy_flows, is_closed};
pub(crate) use contact_frames::contact_table;
pub use energies::energies;
pub use final_picture::{Put, draw_final};
pub use frame_copy::FrameCopy;
pub use memory::{OutputBytes, output_bytes};
pub use particle_frames::particle_columns;
pub(crate) use particle_frames::particle_table;
pub use schedule::{Due, Schedule};
pub use stream::OutputError;
pub(crate) use wall_loads::wall_table;
pub use writer::{Positions, ToWrite, Writer, Written};

use stream::{StreamEntry, entry};
use table_file::TableFile;

use crate::bonds::output::{BondFrames, BreakFile};
pub use crate::boundaries::output::region_counts::materials as counted_materials;
use crate::boundaries::output::{flux_counts, passage_file, region_counts};
use crate::liquid::output::LiquidFile;
pub use crate::membranes::output::MembraneState;
use crate::membranes::output::{HoldCsv, MembraneCsv, MembraneFrames, MembraneTriangles};
use crate::sprays::output::DropletFrames;
pub use crate::wear::output::WearState;
use crate::wear::output::{WearCsv, WearFrames, WearTriangles};

/// All streams but tables of fields, of which a scene has as many as it names. States are passed to them in this order.
const STREAMS: &[StreamEntry] = &[
    entry::<data_file::DataFile>(),
    entry::<ene_file::EneFile>(),
    entry::<fstat_file::FstatFile>(),
    entry::<particle_frames::ParticleFrames>(),
    entry::<wall_frames::WallFrames>(),
    entry::<body_frames::BodyFrames>(),
    entry::<triangle_loads::TriangleLoads>(),
    entry::<DropletFrames>(),
    entry::<BondFrames>(),
    entry::<TableFile<BreakFile>>(),
    entry::<vtk_files::VtkFiles>(),
    entry::<contact_frames::ContactFrames>(),
    entry::<TableFile<track_file::TrackFile>>(),
    entry::<TableFile<wall_loads::WallLoads>>(),
    entry::<TableFile<region_counts::RegionCounts>>(),
    entry::<TableFile<flux_counts::FluxCounts>>(),
    entry::<TableFile<passage_file::PassageFile>>(),
    entry::<TableFile<LiquidFile>>(),
    entry::<TableFile<budget_file::BudgetFile>>(),
    entry::<TableFile<WearCsv>>(),
    entry::<WearFrames>(),
    entry::<WearTriangles>(),
    entry::<TableFile<MembraneCsv>>(),
    entry::<TableFile<HoldCsv>>(),
    entry::<MembraneFrames>(),
    entry::<MembraneTriangles>(),
];
