//! The contract of the pictures: what is where, in which colour, how things hide each other, and that no input breaks them.

mod blending;
mod films;
mod grains;
mod numbers;
mod robustness;
mod silhouettes;
mod texts;

use glam::DVec3;

use crate::{Frame, Framing, Image, Options, Overview, Painter, Sphere, View};

/// A picture of the scene alone, seen along y: x right, z up.
fn bare(width: u32, height: u32) -> Options {
    Options {
        width,
        height,
        view: View::FRONT,
        framing: Framing::Everything,
        headings: false,
        legend: false,
        scale_bar: false,
        axes: false,
        domain: false,
        ..Options::default()
    }
}

fn sphere(x: f64, y: f64, z: f64, radius: f64) -> Sphere {
    Sphere {
        centre: DVec3::new(x, y, z),
        radius,
        value: 0.0,
        fixed: false,
    }
}

fn frame(spheres: Vec<Sphere>) -> Frame {
    Frame {
        title: "Test".into(),
        spheres,
        ..Frame::default()
    }
}

fn draw(frame: &Frame, options: &Options) -> Image {
    Painter::new(options, Overview::of(frame, options))
        .unwrap()
        .image(frame)
}

fn svg(frame: &Frame, options: &Options) -> String {
    Painter::new(options, Overview::of(frame, options))
        .unwrap()
        .svg(frame)
        .unwrap()
}
