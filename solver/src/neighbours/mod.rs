//! neighbours.
