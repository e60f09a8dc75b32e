//! Where the camera stands, what it frames, and where things fall on the picture.

mod axes;
mod extent;
mod lens;
mod overview;

pub(crate) use axes::Axes;
pub(crate) use lens::Lens;
pub use overview::Overview;

/// The part of a picture that shows a scene (pixels).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Window {
    pub(crate) x: usize,
    pub(crate) y: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}
