//! Scenes: examples, frozen plans and messages, scenes that strain the numbers.

mod example_scenes;
mod frozen_scenes;
mod scene_checks;
mod stress;
