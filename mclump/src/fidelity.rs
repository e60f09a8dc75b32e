//! How well pebbles stand for a surface.
