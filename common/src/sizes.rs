//! Particle size distributions.
