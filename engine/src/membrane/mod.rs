//! Elastic sheets: the mechanics of a mesh whose vertices have mass.
//!
//! [`Topology`] holds which triangles meet at which edges, [`Sheet`] the sheet at rest and the forces on its vertices. All are
//! functions of positions and velocities; the state of a run lies elsewhere. See `docs/theory/membranes.md`.

mod borders;
mod critical;
mod elements;
mod forces;
mod now;
mod part;
mod pressure;
mod seen;
mod shapes;
mod sheet;
#[cfg(test)]
mod tests;
mod topology;

pub use critical::Rates;
pub use elements::{Fold, Strained, Tension, hinge_energy};
pub use forces::{Evaluation, Powers, Workspace};
pub use now::{
    Fault, Gap, HoldCourse, HoldLoad, HoldPlan, MembraneNow, MembranePlan, Moment, STRETCHES,
    SavedMembrane, Works,
};
pub(crate) use part::Membranes;
pub use pressure::{Enclosed, Load};
pub use seen::{Scatter, SheetSummary, TriangleTension};
pub use shapes::{about_triangles, cylinder, disc, rectangle, sphere};
pub use sheet::{Bending, Elasticity, Law, Sheet};
pub use topology::{Edge, NONE, Topology, TopologyError};
