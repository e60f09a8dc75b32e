//! How the series of a chart look.

use super::chart::{Series, Shape};
use super::palette::{Dash, Hue, Marker};
use crate::canvas::Stroke;

/// How a series looks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    pub(super) stroke: Stroke,
    pub(super) marker: Marker,
}

/// The look of each series: its own, else the next of each cycle.
pub(super) fn looks(series: &[Series]) -> Vec<Look> {
    let (mut hues, mut dashes, mut markers) = (
        Hue::CYCLE.iter().cycle(),
        Dash::CYCLE.iter().cycle(),
        Marker::CYCLE.iter().cycle(),
    );
    let mut last = Hue::Blue;
    let one = |one: &Series| {
        let follows = matches!(one.shape, Shape::Band { .. } | Shape::Heat(_));
        let hue = one.hue.unwrap_or_else(|| {
            if follows {
                last
            } else {
                *hues.next().unwrap_or(&Hue::Ink)
            }
        });
        last = hue;
        let lines = matches!(one.shape, Shape::Line(_) | Shape::Steps(_));
        let dash = match one.dash {
            Some(dash) => dash,
            None if lines => *dashes.next().unwrap_or(&Dash::Solid),
            None => Dash::Solid,
        };
        let points = matches!(one.shape, Shape::Points { .. } | Shape::MarkedLine(_));
        let marker = match one.marker {
            Some(marker) => marker,
            None if points => *markers.next().unwrap_or(&Marker::Disc),
            None => Marker::Disc,
        };
        Look {
            stroke: Stroke {
                colour: hue.colour(),
                width: one.width,
                dashes: dash.lengths(),
            },
            marker,
        }
    };
    series.iter().map(one).collect()
}
