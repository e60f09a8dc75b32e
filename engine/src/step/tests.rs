//! The engine with what no scene can name.

mod liquid;
