//! Frozen counter-based random numbers.
