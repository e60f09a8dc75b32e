//! The time step.
