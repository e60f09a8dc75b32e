//! Where a sphere touches triangles: by the definition, all of them against all of them.

use glam::DVec3;

use super::walls::WallContact;

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

/// Whether two triangles share a corner.
pub(super) fn share_a_corner(one: &[DVec3; 3], other: &[DVec3; 3]) -> bool {
    one.iter().any(|corner| other.contains(corner))
}

/// The point of a triangle that is nearest to `x`: the foot of the perpendicular if it falls inside, else the nearest point of
/// the sides.
fn nearest_point([a, b, c]: [DVec3; 3], x: DVec3) -> DVec3 {
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
