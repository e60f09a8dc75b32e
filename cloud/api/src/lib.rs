//! Messages between server, worker, page and command line, and how a run goes from state to state.
//!
//! Nothing here reads a clock, a file or a socket: [`lifecycle`] is pure functions, the rest is types.

pub mod answers;
pub mod head;
pub mod id;
pub mod lifecycle;
pub mod names;
pub mod problem;
pub mod requests;
pub mod spec;

pub use head::{
    Beat, Cause, Checkpoint, Control, Ending, Head, Note, Phase, Segment, Stream, Whole,
};
pub use id::RunId;
pub use lifecycle::{RunState, Wish};
pub use problem::Problem;
pub use spec::{Branch, InputFile, Spec, memory_of_rank};
