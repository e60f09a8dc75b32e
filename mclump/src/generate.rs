//! Generators of pebbles from a closed surface.
