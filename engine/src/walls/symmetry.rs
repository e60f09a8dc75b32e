//! How far a moved surface lies from where it was, when turning or sliding a shape in itself counts
//! as no motion.
//!
//! Let `D` be the motion in the wall's own frame, and `S` any motion that maps the shape onto itself.
//! The moved surface is `D(W) = D(S(W))`, so the point `x` of the surface may be compared with
//! `D(S(x))` for the `S` that makes the difference least. Here `S` undoes the part of the rotation
//! about the shape's own axis (the "twist" of a swing-twist
//! decomposition).

use super::pose::Pose;
use glam::{DQuat, DVec3};

/// Below this many units of round-off in the positions a motion counts as none, so that a drum that
/// turns in itself does so exactly.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// Rest of `rotation` when it is preceded by the turn about `axis` (unit) that makes the rest smallest: a rotation about an axis
/// normal to `axis`.
fn swing(rotation: DQuat, axis: DVec3) -> DQuat {
    let along = DVec3::new(rotation.x, rotation.y, rotation.z).dot(axis);
    let norm = (along * along + rotation.w * rotation.w).sqrt();
    if norm < f64::EPSILON {
        return rotation; // half a turn about a perpendicular axis: any twist is as good
    }
    let v = axis * (along / norm);
    rotation * DQuat::from_xyzw(v.x, v.y, v.z, rotation.w / norm).conjugate()
}

/// Length of the chord that a unit vector can at most draw under the rotation: `2 sin(angle/2)`.
fn chord(rotation: DQuat) -> f64 {
    2.0 * DVec3::new(rotation.x, rotation.y, rotation.z).length()
}

fn without_round_off(
    bound: f64,
    from: &Pose,
    to: &Pose,
    about: DVec3,
    reach: f64,
    anchor: DVec3,
) -> f64 {
    let scale = from.translation.length()
        + to.translation.length()
        + about.length()
        + anchor.length()
        + reach;
    if bound <= ROUND_OFF * scale {
        0.0
    } else {
        bound
    }
}

/// Bound for a plane through `point` with unit `normal`: in-plane motions don't count.
pub(super) fn of_plane(
    from: &Pose,
    to: &Pose,
    (point, normal): (DVec3, DVec3),
    about: DVec3,
    reach: f64,
) -> f64 {
    let motion = from.relative_to(to);
    let swing = swing(motion.rotation, normal);
    // Points of the plane within reach of `about` are within reach of its foot as well.
    let foot = about - normal * (about - point).dot(normal);
    let lift = (motion.to_global(foot) - foot).dot(swing * normal);
    let bound = lift.abs() + chord(swing) * reach;
    without_round_off(bound, from, to, about, reach, point)
}

/// Bound for a shape that is symmetric about the axis through `origin` along `axis` (unit); `slides`
/// if shifts along the axis don't change it either.
pub(super) fn of_axis(
    from: &Pose,
    to: &Pose,
    (origin, axis): (DVec3, DVec3),
    slides: bool,
    about: DVec3,
    reach: f64,
) -> f64 {
    let motion = from.relative_to(to);
    let swing = swing(motion.rotation, axis);
    let foot = origin + axis * (about - origin).dot(axis);
    let mut shift = motion.to_global(foot) - foot;
    let arm = about - foot;
    if slides {
        let new_axis = swing * axis;
        shift -= new_axis * shift.dot(new_axis);
    }
    let bound = (shift + (swing * arm - arm)).length() + chord(swing) * reach;
    without_round_off(bound, from, to, about, reach, origin)
}

/// Bound for a sphere about `centre`: rotations don't count.
pub(super) fn of_point(from: &Pose, to: &Pose, centre: DVec3, about: DVec3, reach: f64) -> f64 {
    let bound = (to.to_global(centre) - from.to_global(centre)).length();
    without_round_off(bound, from, to, about, reach, centre)
}
