//! The files of a run: frames, energies, wall loads, pictures, its summary and its log.
//!
//! The time loop hands a [`FrameCopy`] to the [`Writer`], whose thread puts it in the order of ids and gives it to one
//! `Stream` for each file. The modules: `schedule` decides when, `moment` and `state` hold what, `energies` sums up, and each kind of
//! file has its own module; `folder` guards what is already there.

mod body_frames;
mod bond_files;
mod budget;
mod budget_file;
mod contact_frames;
mod data_file;
mod data_rows;
mod droplet_frames;
mod ene_file;
mod energies;
mod field_tables;
mod final_picture;
mod flux_counts;
pub mod folder;
mod frame_copy;
mod fstat_file;
mod liquid_file;
mod membrane_files;
mod memory;
mod particle_frames;
mod passage_file;
mod region_counts;
mod schedule;
mod stream;
pub mod summary;
mod table_file;
#[cfg(test)]
mod tests;
mod track_file;
mod triangle_loads;
mod vtk_files;
mod wall_frames;
mod wall_loads;
mod wear_files;
mod writer;

pub use budget::{BudgetRow, Exchanged, Gap, energy_flows, is_closed};
pub use energies::energies;
pub use final_picture::{Put, draw_final};
pub use frame_copy::FrameCopy;
pub use membrane_files::MembraneState;
pub use memory::{OutputBytes, output_bytes};
pub use particle_frames::particle_columns;
pub use region_counts::materials as counted_materials;
pub use schedule::{Due, Schedule};
pub use stream::OutputError;
pub use wear_files::WearState;
pub use writer::{Positions, ToWrite, Writer, Written};

use stream::{StreamEntry, entry};
use table_file::TableFile;

/// All streams but tables of fields, of which a scene has as many as it names. States are passed to them in this order.
const STREAMS: &[StreamEntry] = &[
    entry::<data_file::DataFile>(),
    entry::<ene_file::EneFile>(),
    entry::<fstat_file::FstatFile>(),
    entry::<particle_frames::ParticleFrames>(),
    entry::<wall_frames::WallFrames>(),
    entry::<body_frames::BodyFrames>(),
    entry::<triangle_loads::TriangleLoads>(),
    entry::<droplet_frames::DropletFrames>(),
    entry::<bond_files::BondFrames>(),
    entry::<TableFile<bond_files::BreakFile>>(),
    entry::<vtk_files::VtkFiles>(),
    entry::<contact_frames::ContactFrames>(),
    entry::<TableFile<track_file::TrackFile>>(),
    entry::<TableFile<wall_loads::WallLoads>>(),
    entry::<TableFile<region_counts::RegionCounts>>(),
    entry::<TableFile<flux_counts::FluxCounts>>(),
    entry::<TableFile<passage_file::PassageFile>>(),
    entry::<TableFile<liquid_file::LiquidFile>>(),
    entry::<TableFile<budget_file::BudgetFile>>(),
    entry::<TableFile<wear_files::WearCsv>>(),
    entry::<wear_files::WearFrames>(),
    entry::<wear_files::WearTriangles>(),
    entry::<TableFile<membrane_files::MembraneCsv>>(),
    entry::<TableFile<membrane_files::HoldCsv>>(),
    entry::<membrane_files::MembraneFrames>(),
    entry::<membrane_files::MembraneTriangles>(),
];
