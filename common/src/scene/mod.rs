//! The scene file: what was typed, with the place where it was typed.
