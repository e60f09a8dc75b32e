//! Where a sphere touches triangles: by the definition, all of them against all of them.

use glam::{DMat3, DVec3};

use super::walls::{WallContact, square};

/// Normals at a smaller angle than this belong to one smooth region, which touches once \[degrees\].
const SMOOTH: f64 = 12.0;
/// Places nearer than this part of the triangles' size are the same.
const SAME: f64 = 1e-9;

/// Every place where a sphere touches the union of the triangles: each point that is nearer to the centre than all points of
/// the union around it. Such a point is the nearest one of every triangle on which it lies. Of points that hang together by
/// normals at small angles the nearest is taken.
pub(super) fn contacts(triangles: &[[DVec3; 3]], centre: DVec3, radius: f64) -> Vec<WallContact> {
    let size = triangles
        .iter()
        .flatten()
        .fold(0.0f64, |size, x| size.max(x.abs().max_element()));
    let nearest: Vec<DVec3> = triangles
        .iter()
        .map(|&triangle| nearest_point(triangle, centre))
        .collect();
    let mut found: Vec<WallContact> = Vec::new();
    for (feature, &point) in nearest.iter().enumerate() {
        let distance = point.distance(centre);
        if distance >= radius {
            continue;
        }
        let comes_nearer = |(&triangle, other): (&[DVec3; 3], &DVec3)| {
            nearest_point(triangle, point).distance(point) <= SAME * size
                && other.distance(point) > 1e-7 * radius
                && other.distance(centre) < distance
        };
        if !triangles.iter().zip(&nearest).any(comes_nearer) {
            found.push(WallContact {
                feature,
                normal: (centre - point) / distance,
                distance,
                turning: turning(
                    triangles[feature],
                    point,
                    (centre - point) / distance,
                    distance,
                ),
            });
        }
    }
    // Each one again and again takes on the region of its neighbours, until nothing changes.
    let mut region: Vec<usize> = (0..found.len()).collect();
    let mut changed = true;
    while changed {
        changed = false;
        for a in 0..found.len() {
            for b in 0..found.len() {
                let linked = found[a].normal.dot(found[b].normal) > SMOOTH.to_radians().cos();
                if linked && region[b] < region[a] {
                    region[a] = region[b];
                    changed = true;
                }
            }
        }
    }
    let mut leaders: Vec<WallContact> = Vec::new();
    for index in 0..found.len() {
        let members = (0..found.len()).filter(|&k| region[k] == region[index]);
        let leader = members.min_by(|&a, &b| {
            found[a]
                .distance
                .total_cmp(&found[b].distance)
                .then(a.cmp(&b))
        });
        if leader == Some(index) {
            leaders.push(found[index]);
        }
    }
    leaders
}

/// How the normal turns when the centre moves: not over the face, about a side where the point lies on one, about a corner in all
/// directions.
fn turning(corners: [DVec3; 3], point: DVec3, normal: DVec3, distance: f64) -> DMat3 {
    let all = DMat3::IDENTITY - square(normal);
    for k in 0..3 {
        let (p, q) = (corners[k], corners[(k + 1) % 3]);
        // p + (q - p) is q to round-off only.
        let is_at = |corner: DVec3| point.distance(corner) <= 1e-14 * (p.length() + q.length());
        if is_at(p) || is_at(q) {
            return all * (1.0 / distance);
        }
        let along = (q - p).normalize();
        if is_side_point(point, p, q) && normal.dot(face_normal(corners)).abs() < 1.0 - 1e-14 {
            return (all - square(along)) * (1.0 / distance);
        }
    }
    DMat3::ZERO
}

/// Whether a point lies between the ends of a side, to round-off.
fn is_side_point(point: DVec3, p: DVec3, q: DVec3) -> bool {
    let way = (q - p).normalize();
    (point - p).cross(way).length() <= 1e-14 * (p.length() + q.length() + (q - p).length())
}

/// The unit normal of a triangle.
fn face_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize()
}

/// The contact, of those that are left, that goes on as the one with `triangle`: the one whose triangle is now nearest to the
/// point that touches, within half the distance of the centre.
pub(super) fn continued(
    old: impl Iterator<Item = [DVec3; 3]>,
    triangle: [DVec3; 3],
    centre: DVec3,
) -> Option<usize> {
    let foot = nearest_point(triangle, centre);
    let limit = 0.5 * foot.distance(centre);
    old.map(|other| nearest_point(other, centre).distance(foot))
        .enumerate()
        .filter(|&(_, apart)| apart < limit)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, _)| index)
}

/// Whether the points of two triangles that are nearest to `centre` are one, to round-off: a point of the edge or corner that they share.
pub(super) fn share_foot(one: [DVec3; 3], other: [DVec3; 3], centre: DVec3) -> bool {
    let foot = nearest_point(one, centre);
    nearest_point(other, centre).distance(foot) <= 1e-14 * (centre.length() + foot.length())
}

/// The point of a triangle that is nearest to `x`: the foot of the perpendicular if it falls inside, else the nearest point of
/// the sides.
pub(crate) fn nearest_point([a, b, c]: [DVec3; 3], x: DVec3) -> DVec3 {
    let normal = (b - a).cross(c - a).normalize();
    let foot = x - normal * (x - a).dot(normal);
    let is_left_of = |p: DVec3, q: DVec3| (q - p).cross(foot - p).dot(normal) >= 0.0;
    if is_left_of(a, b) && is_left_of(b, c) && is_left_of(c, a) {
        return foot;
    }
    let on_side = |p: DVec3, q: DVec3| {
        let along = (x - p).dot(q - p) / (q - p).length_squared();
        p + (q - p) * along.clamp(0.0, 1.0)
    };
    let sides = [on_side(a, b), on_side(b, c), on_side(c, a)];
    sides
        .into_iter()
        .min_by(|p, q| p.distance(x).total_cmp(&q.distance(x)))
        .unwrap_or(a)
}
