//! Curves of many points, thinned to what the eye can tell apart.

use crate::canvas::{Canvas, Spot, Stroke};

/// A line through `places`; a dot where there is only one.
pub(super) fn curve(canvas: &mut dyn Canvas, places: &[Spot], stroke: Stroke) {
    match places {
        [] => {}
        [only] => canvas.disc(*only, 3.0 + 0.5 * stroke.width, stroke.colour),
        _ => canvas.polyline(&thinned(places), stroke),
    }
}

/// The same line for the eye with at most four places to a point of width: of the places that share a column,
/// the first, the lowest, the highest and the last.
fn thinned(places: &[Spot]) -> Vec<Spot> {
    let column = |spot: &Spot| spot.0.floor();
    places
        .chunk_by(|a, b| column(a) == column(b))
        .flat_map(|chunk| {
            let by_height = |a: &usize, b: &usize| f64::total_cmp(&chunk[*a].1, &chunk[*b].1);
            let lowest = (0..chunk.len()).min_by(by_height).unwrap_or(0);
            let highest = (0..chunk.len()).max_by(by_height).unwrap_or(0);
            let mut kept = vec![0, lowest, highest, chunk.len() - 1];
            kept.sort_unstable();
            kept.dedup();
            kept.into_iter()
                .map(|place| chunk[place])
                .collect::<Vec<_>>()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_extremes_of_a_million_rows() {
        let number = 1_000_000;
        let places: Vec<Spot> = (0..number)
            .map(|i| {
                (
                    800.0 * f64::from(i) / f64::from(number),
                    f64::from(i % 104_729 * 7919 % 104_729),
                )
            })
            .collect();
        let few = thinned(&places);
        assert!(few.len() <= 4 * 801, "{}", few.len());
        let highest = |spots: &[Spot]| spots.iter().map(|s| s.1).fold(f64::MIN, f64::max);
        assert_eq!(highest(&few), highest(&places));
        assert!(
            few.windows(2).all(|pair| pair[0].0 <= pair[1].0),
            "time order is kept"
        );
    }
}
