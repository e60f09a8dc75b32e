//! Clipping of lines and areas to a chart, whose corners are (0, 0) and (1, 1).

/// A point as shares of the chart's width and height; `None`: it has no place.
pub(super) type Shares = Option<(f64, f64)>;

/// The parts of a line inside; a point without a place breaks it.
pub(super) fn line(points: impl Iterator<Item = Shares>) -> Vec<Vec<(f64, f64)>> {
    let mut parts: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut last: Shares = None;
    for point in points {
        if let (Some(from), Some(to)) = (last, point)
            && let Some((a, b)) = segment(from, to)
        {
            match parts.last_mut() {
                // Goes on where the part ended, unless that was where it left the chart.
                Some(part) if part.last() == Some(&a) && a == from => part.push(b),
                _ => parts.push(vec![a, b]),
            }
        }
        last = point;
    }
    parts
}

/// The part of a segment inside (Y.-D. Liang and B. A. Barsky, 1984).
fn segment(from: (f64, f64), to: (f64, f64)) -> Option<((f64, f64), (f64, f64))> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (towards, left) in [
        (-dx, from.0),
        (dx, 1.0 - from.0),
        (-dy, from.1),
        (dy, 1.0 - from.1),
    ] {
        if towards == 0.0 {
            if left < 0.0 {
                return None;
            }
        } else if towards < 0.0 {
            enter = enter.max(left / towards);
        } else {
            leave = leave.min(left / towards);
        }
    }
    if enter > leave {
        return None;
    }
    let at = |t: f64, end: (f64, f64)| {
        if t == 0.0 {
            from
        } else if t == 1.0 {
            end
        } else {
            (from.0 + t * dx, from.1 + t * dy)
        }
    };
    Some((at(enter, to), at(leave, to)))
}

/// The part of an area inside, edge by edge (I. E. Sutherland and G. W. Hodgman, 1974); fewer than three points: nothing.
pub(super) fn area(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    type Depth = fn((f64, f64)) -> f64;
    let edges: [Depth; 4] = [|p| p.0, |p| 1.0 - p.0, |p| p.1, |p| 1.0 - p.1];
    for depth in edges {
        let mut kept = Vec::with_capacity(points.len() + 4);
        for (place, &to) in points.iter().enumerate() {
            let from = points[(place + points.len() - 1) % points.len()];
            let (a, b) = (depth(from), depth(to));
            if (a < 0.0) != (b < 0.0) {
                let t = a / (a - b);
                kept.push((from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1)));
            }
            if b >= 0.0 {
                kept.push(to);
            }
        }
        points = kept;
    }
    points
}

/// Thinned line that looks like the original, with at most four points to a column: the first, the lowest, the highest and the
/// last of those that share it, in their order.
pub(super) fn thinned(points: &[(f64, f64)], column: f64) -> Vec<(f64, f64)> {
    let column = |point: &(f64, f64)| (point.0 / column).floor();
    points
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
    use proptest::prelude::*;

    #[test]
    fn a_line_is_cut_at_the_edges_and_broken_where_it_has_no_place() {
        let points = [
            Some((-1.0, 0.5)),
            Some((0.5, 0.5)),
            Some((0.5, 2.0)),
            None,
            Some((0.1, 0.1)),
            Some((0.2, 0.2)),
        ];
        let parts = line(points.into_iter());
        assert_eq!(
            parts,
            [
                vec![(0.0, 0.5), (0.5, 0.5), (0.5, 1.0)],
                vec![(0.1, 0.1), (0.2, 0.2)]
            ]
        );
    }

    #[test]
    fn thinning_keeps_the_extremes_of_a_million_rows() {
        let number = 1_000_000;
        let places: Vec<(f64, f64)> = (0..number)
            .map(|i| {
                (
                    800.0 * f64::from(i) / f64::from(number),
                    f64::from(i % 104_729 * 7919 % 104_729),
                )
            })
            .collect();
        let few = thinned(&places, 1.0);
        assert!(few.len() <= 4 * 801, "{}", few.len());
        let highest = |spots: &[(f64, f64)]| spots.iter().map(|s| s.1).fold(f64::MIN, f64::max);
        assert_eq!(highest(&few), highest(&places));
        assert!(
            few.windows(2).all(|pair| pair[0].0 <= pair[1].0),
            "order is kept"
        );
    }

    /// Twice the signed area.
    fn size(points: &[(f64, f64)]) -> f64 {
        (0..points.len())
            .map(|i| (points[i], points[(i + 1) % points.len()]))
            .map(|((ax, ay), (bx, by))| ax * by - bx * ay)
            .sum()
    }

    proptest! {
        #[test]
        fn nothing_is_left_outside(points in prop::collection::vec((-3.0..3.0f64, -3.0..3.0f64), 0..20)) {
            let inside = |p: &(f64, f64)| (-1e-9..=1.0 + 1e-9).contains(&p.0) && (-1e-9..=1.0 + 1e-9).contains(&p.1);
            prop_assert!(line(points.iter().copied().map(Some)).iter().flatten().all(inside));
            prop_assert!(area(points).iter().all(inside));
        }

        #[test]
        fn a_rectangle_keeps_the_area_that_it_shares(x in -2.0..1.0f64, y in -2.0..1.0f64, w in 0.1..4.0f64, h in 0.1..4.0f64) {
            let cut = area(vec![(x, y), (x + w, y), (x + w, y + h), (x, y + h)]);
            let shared = |low: f64, size: f64| ((low + size).min(1.0) - low.max(0.0)).max(0.0);
            prop_assert!((0.5 * size(&cut) - shared(x, w) * shared(y, h)).abs() < 1e-9);
        }
    }
}
