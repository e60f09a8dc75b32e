//! Frames: written, read, and beside the library of Arrow.

mod frames_files;
mod frames_tables;
