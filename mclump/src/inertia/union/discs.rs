//! Area, first and second moments of a union of discs, in closed form.
//!
//! The border of the union consists of arcs. With the field `f (u, v)`, f homogeneous of degree k, the divergence theorem gives
//! `∬ f dA = 1/(k + 2) ∮ f (u dv - v du)`, and on an arc all integrands are polynomials in the sine and cosine.

use std::f64::consts::TAU;

/// A disc in the plane of a section.
#[derive(Debug, Clone, Copy)]
pub(super) struct Disc {
    pub(super) u: f64,
    pub(super) v: f64,
    pub(super) radius: f64,
}

/// Integrals of 1; u, v; uu, uv, vv over the union.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Section {
    pub(super) area: f64,
    pub(super) first: [f64; 2],
    pub(super) second: [f64; 3],
}

/// Integrates over the union: every circle contributes the arcs that no other disc covers.
pub(super) fn union_of_discs(discs: &[Disc]) -> Section {
    let mut section = Section::default();
    // Large ones first: most circles inside a body are covered by a few of them.
    let mut discs = discs.to_vec();
    discs.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    let discs = &discs[..];
    // Angles that are covered, as intervals within [0, 2 pi].
    let mut covered: Vec<(f64, f64)> = Vec::new();
    for (index, disc) in discs.iter().enumerate() {
        if !covered_angles(discs, index, &mut covered) {
            continue;
        }
        covered.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut reached = 0.0;
        for &(from, to) in &covered {
            if from > reached {
                section.add_arc(disc, reached, from);
            }
            reached = f64::max(reached, to);
        }
        if reached < TAU {
            section.add_arc(disc, reached, TAU);
        }
    }
    section
}

/// Collects the angles of a circle that other discs cover; false if one covers the whole circle.
fn covered_angles(discs: &[Disc], index: usize, covered: &mut Vec<(f64, f64)>) -> bool {
    covered.clear();
    let mut next_look = 4;
    let disc = &discs[index];
    for (j, other) in discs.iter().enumerate() {
        if j == index {
            continue;
        }
        let (du, dv) = (other.u - disc.u, other.v - disc.v);
        let square = du * du + dv * dv;
        let (sum, difference) = (other.radius + disc.radius, other.radius - disc.radius);
        if square >= sum * sum {
            continue;
        }
        if square <= difference * difference {
            // One in the other; of equal discs the first has the border.
            if difference > 0.0 || (difference == 0.0 && j < index) {
                return false;
            }
            continue;
        }
        let distance = square.sqrt();
        // Law of cosines, written with the difference of radii: it keeps its digits for discs of nearly equal size.
        let cosine = (square - difference * sum) / (2.0 * distance * disc.radius);
        let half = cosine.clamp(-1.0, 1.0).acos();
        let towards = dv.atan2(du);
        let from = (towards - half).rem_euclid(TAU);
        let to = from + 2.0 * half;
        covered.push((from, to.min(TAU)));
        if to > TAU {
            covered.push((0.0, to - TAU));
        }
        if covered.len() >= next_look {
            if is_all_covered(covered) {
                return false;
            }
            next_look *= 2;
        }
    }
    true
}

/// Whether the intervals leave nothing of a circle.
fn is_all_covered(covered: &mut [(f64, f64)]) -> bool {
    covered.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut reached = 0.0;
    for &(from, to) in covered.iter() {
        if from > reached {
            return false;
        }
        reached = f64::max(reached, to);
    }
    reached >= TAU
}

impl Section {
    /// Adds the part of the contour integrals along an arc, counter-clockwise from angle `a` to `b`.
    fn add_arc(&mut self, disc: &Disc, a: f64, b: f64) {
        let (p, q, r) = (disc.u, disc.v, disc.radius);
        let ((sa, ca), (sb, cb)) = (a.sin_cos(), b.sin_cos());
        let t = b - a;
        // Integrals of powers of c = cos and s = sin over the arc.
        let c1 = sb - sa;
        let s1 = ca - cb;
        let c2 = 0.5 * (t + sb * cb - sa * ca);
        let s2 = t - c2;
        let cs = 0.5 * (sb * sb - sa * sa);
        let cube = |x: f64| x * x * x;
        let c3 = c1 - (cube(sb) - cube(sa)) / 3.0;
        let s3 = s1 - (cube(ca) - cube(cb)) / 3.0;
        let c2s = (cube(ca) - cube(cb)) / 3.0;
        let cs2 = (cube(sb) - cube(sa)) / 3.0;
        // u dv - v du = r (p c + q s + r) dt, with u = p + r c and v = q + r s.
        let (w0, w1, w2) = (
            p * c1 + q * s1 + r * t,
            p * c2 + q * cs + r * c1,
            p * cs + q * s2 + r * s1,
        );
        let wcc = p * c3 + q * c2s + r * c2;
        let wcs = p * c2s + q * cs2 + r * cs;
        let wss = p * cs2 + q * s3 + r * s2;
        self.area += 0.5 * r * w0;
        self.first[0] += r / 3.0 * (p * w0 + r * w1);
        self.first[1] += r / 3.0 * (q * w0 + r * w2);
        self.second[0] += 0.25 * r * (p * p * w0 + 2.0 * p * r * w1 + r * r * wcc);
        self.second[1] += 0.25 * r * (p * q * w0 + r * (p * w2 + q * w1) + r * r * wcs);
        self.second[2] += 0.25 * r * (q * q * w0 + 2.0 * q * r * w2 + r * r * wss);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn disc(u: f64, v: f64, radius: f64) -> Disc {
        Disc { u, v, radius }
    }

    fn assert_close(found: f64, expected: f64) {
        assert!(
            (found - expected).abs() < 1e-13 * expected.abs().max(1.0),
            "{found} {expected}"
        );
    }

    #[test]
    fn one_disc_has_its_moments() {
        let (u, v, r) = (0.7, -1.3, 0.4);
        let section = union_of_discs(&[disc(u, v, r)]);
        let area = PI * r * r;
        assert_close(section.area, area);
        assert_close(section.first[0], area * u);
        assert_close(section.first[1], area * v);
        assert_close(section.second[0], area * (u * u + r * r / 4.0));
        assert_close(section.second[1], area * u * v);
        assert_close(section.second[2], area * (v * v + r * r / 4.0));
    }

    #[test]
    fn a_lens_counts_once() {
        // Two unit discs at distance 1: the lens has the area 2 pi/3 - sqrt(3)/2.
        let section = union_of_discs(&[disc(0.0, 0.0, 1.0), disc(1.0, 0.0, 1.0)]);
        let lens = 2.0 * PI / 3.0 - 3f64.sqrt() / 2.0;
        assert_close(section.area, 2.0 * PI - lens);
        assert_close(section.first[0], 0.5 * section.area);
        assert_close(section.first[1], 0.0);
    }

    #[test]
    fn hidden_and_equal_discs_add_nothing() {
        let one = union_of_discs(&[disc(0.1, 0.2, 1.0)]);
        let many = union_of_discs(&[
            disc(0.1, 0.2, 1.0),
            disc(0.1, 0.2, 1.0),
            disc(0.2, 0.2, 0.5),
            // Touches from inside.
            disc(0.6, 0.2, 0.5),
        ]);
        assert_close(many.area, one.area);
        assert_close(many.second[1], one.second[1]);
    }
}
