//! Shape descriptors of a body: elongation, flatness, sphericity, convexity, roundness.
