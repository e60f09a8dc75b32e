//! boundaries.
