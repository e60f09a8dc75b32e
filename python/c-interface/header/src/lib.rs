//! Nothing but a test: `tests/header.rs`.
