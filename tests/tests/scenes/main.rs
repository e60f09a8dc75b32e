//! Scenes: examples, frozen plans and messages, scenes that strain the numbers; the language of all texts.

mod example_scenes;
mod frozen_scenes;
mod plain_english;
mod stress;
