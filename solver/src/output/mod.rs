//! The files of a run: frames, energies, wall loads, pictures, its summary and its log.
//!
//! The time loop hands a [`FrameCopy`] to the [`Writer`], whose thread puts it in the order of ids ([`OrderedFrame`]) and gives it to one
//! `Stream` for each file. The modules: `schedule` decides when, `moment` and `state` hold what, `energies` sums up, and each
//! kind of file has its own module; `folder` guards what is already there.

mod body_frames;
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
mod ordered_frame;
mod particle_frames;
mod passage_file;
mod region_counts;
mod schedule;
mod stream;
pub mod summary;
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
pub use flux_counts::COLUMNS as FLUX_COLUMNS;
pub use frame_copy::FrameCopy;
pub use membrane_files::MembraneState;
pub use memory::{OutputBytes, output_bytes};
pub use ordered_frame::OrderedFrame;
pub use particle_frames::particle_columns;
pub use region_counts::{COLUMNS as REGION_COLUMNS, materials as counted_materials};
pub use schedule::{Due, Schedule};
pub use stream::OutputError;
pub use track_file::COLUMNS as TRACK_COLUMNS;
pub use wall_loads::COLUMNS as WALL_COLUMNS;
pub use wear_files::WearState;
pub use writer::{Positions, ToWrite, Writer, Written};

use stream::{StreamEntry, entry};

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
    entry::<vtk_files::VtkFiles>(),
    entry::<contact_frames::ContactFrames>(),
    entry::<track_file::TrackFile>(),
    entry::<wall_loads::WallLoads>(),
    entry::<region_counts::RegionCounts>(),
    entry::<flux_counts::FluxCounts>(),
    entry::<passage_file::PassageFile>(),
    entry::<liquid_file::LiquidFile>(),
    entry::<budget_file::BudgetFile>(),
    entry::<wear_files::WearCsv>(),
    entry::<wear_files::WearFrames>(),
    entry::<wear_files::WearTriangles>(),
    entry::<membrane_files::MembraneCsv>(),
    entry::<membrane_files::HoldCsv>(),
    entry::<membrane_files::MembraneFrames>(),
    entry::<membrane_files::MembraneTriangles>(),
];
