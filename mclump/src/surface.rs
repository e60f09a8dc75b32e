//! Is the surface fit for volume integrals? Report and repair.
