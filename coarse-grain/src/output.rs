//! Output: `.stat`, CSV, VTI, pictures.

pub mod chart;
pub mod csv;
pub mod stat;
pub mod vti;
mod writer;

pub use writer::{Format, Succession, Writer, about, push_table};
