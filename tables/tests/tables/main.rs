//! Tables: round trips and bad input.

mod bad_input;
mod round_trip;
