//! Scenes: examples, frozen plans and messages, the page and schema of the format, scenes that strain the numbers; the language of all texts.

mod example_scenes;
mod frozen_scenes;
mod physics;
mod plain_english;
mod run_tables;
mod schema;
mod stress;
