//! How well pebbles stand for a surface.

use mercury_common::formats::clump::Pebble;

/// Volume of the space that pebbles cover, in m3.
pub(crate) fn union_volume(pebbles: &[Pebble]) -> f64 {
    /// Columns across the longer horizontal extent.
    const COLUMNS: f64 = 160.0;
    let (mut low, mut high) = (glam::DVec3::INFINITY, glam::DVec3::NEG_INFINITY);
    for pebble in pebbles {
        low = low.min(pebble.position - pebble.radius);
        high = high.max(pebble.position + pebble.radius);
    }
    let edge = (high - low).truncate().max_element() / COLUMNS;
    let count = ((high - low).truncate() / edge).ceil();
    let mut volume = 0.0;
    let mut spans: Vec<(f64, f64)> = Vec::new();
    for i in 0..count.x as usize {
        let x = low.x + edge * (i as f64 + 0.5);
        for j in 0..count.y as usize {
            let y = low.y + edge * (j as f64 + 0.5);
            spans.clear();
            for pebble in pebbles {
                let (dx, dy) = (x - pebble.position.x, y - pebble.position.y);
                let square = pebble.radius * pebble.radius - dx * dx - dy * dy;
                if square > 0.0 {
                    let half = square.sqrt();
                    spans.push((pebble.position.z - half, pebble.position.z + half));
                }
            }
            spans.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut top = f64::NEG_INFINITY;
            for &(from, to) in &spans {
                volume += (to - from.max(top)).max(0.0) * edge * edge;
                top = top.max(to);
            }
        }
    }
    volume
}
