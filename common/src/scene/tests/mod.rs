//! The contract of the scene format: the shared scenes, the exact text of errors, overrides, garbage.

mod bad;
mod garbage;
mod keys;
mod page;
mod set;
mod shared;
