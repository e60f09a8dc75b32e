//! Loads of elements by the places and motions of their ends, in lanes: pure functions ([`element`](super::element) has the theory).

use std::f64::consts::PI;

use glam::DQuat;

use super::element::{Element, Modes};
use crate::lanes::{Mask, Real, Vector};

/// A rotation: a unit quaternion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rotation<L = f64> {
    pub(super) vector: Vector<L>,
    pub(super) real: L,
}

/// Velocities of both ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion<L = f64> {
    /// Velocity of B less that of A, m/s.
    pub(super) velocity: Vector<L>,
    /// Angular velocities, rad/s.
    pub(super) spins: [Vector<L>; 2],
}

/// Loads of a bond on its ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Loads<L = f64> {
    /// Force on A, N; that on B is its opposite.
    pub(super) force: Vector<L>,
    /// Couples on A and B, N m.
    pub(super) couples: [Vector<L>; 2],
    /// Tension and shear stress, without damping, Pa.
    pub(super) stresses: [L; 2],
    /// Elastic energy, J.
    pub(super) energy: L,
}

/// Axis of an element, its length (m) and the inverse of that.
type Line<L> = (Vector<L>, L, L);

impl<L: Real> Element<L> {
    /// Loads on the ends at this branch from A to B (m), which turned by these rotations. Without a motion nothing is damped.
    #[inline(always)]
    pub(super) fn loads(
        &self,
        branch: Vector<L>,
        rotations: [Rotation<L>; 2],
        motion: Option<&Motion<L>>,
    ) -> Loads<L> {
        let line = line(branch);
        let (axis, length, per_length) = line;
        let [a, b] = rotations_in_frame(axis, rotations);
        let Modes {
            normal,
            shear,
            twist,
            bending,
        } = self.stiffness;
        let half = L::splat(0.5);
        let stretch = length - self.length;
        let difference = b - a;
        let turn = difference.dot(axis);
        let bent = difference - axis * turn;
        let mean = (a + b) * half;
        let sheared = mean - axis * mean.dot(axis);
        let shear = shear * (self.length * self.length);
        let (tension, torque) = (normal * stretch, twist * turn);
        let (couple, balance) = (bent * bending, sheared * -shear);
        // The larger end.
        let half_balance = balance * half;
        let bending_moment = (couple + half_balance)
            .length_squared()
            .max((half_balance - couple).length_squared())
            .sqrt();
        // r/I = 4/(A r).
        let per_area = L::ONE / (self.radius * self.radius * PI);
        let per_moment = per_area * (L::splat(4.0) / self.radius);
        let stresses = [
            tension * per_area + bending_moment * per_moment,
            balance.length() * (per_length * per_area) + torque.abs() * (per_moment * 0.5),
        ];
        let energy = (tension * stretch
            + torque * turn
            + bending * bent.length_squared()
            + shear * sheared.length_squared())
            * 0.5;
        let (mut force, mut couples) = assemble(line, (tension, torque), (couple, balance));
        if let Some(motion) = motion {
            let rates = Rates::of(line, motion);
            let Modes {
                normal,
                shear,
                twist,
                bending,
            } = self.damping;
            let along = (normal * rates.normal, twist * rates.twist);
            let across = (rates.bending * bending, rates.shear * -shear);
            let (more, [on_a, on_b]) = assemble(line, along, across);
            force += more;
            couples = [couples[0] + on_a, couples[1] + on_b];
        }
        Loads {
            force,
            couples,
            stresses,
            energy,
        }
    }
}

impl Element {
    /// Power that the damping takes, W: its forces are of the velocities that the bond saw, `now` are those at the time of the forces.
    pub(super) fn damping_power(&self, branch: Vector, seen: &Motion, now: &Motion) -> f64 {
        let line = line(branch);
        let (forces, rates) = (Rates::of(line, seen), Rates::of(line, now));
        let Modes {
            normal,
            shear,
            twist,
            bending,
        } = self.damping;
        normal * forces.normal * rates.normal
            + twist * forces.twist * rates.twist
            + bending * forces.bending.dot(rates.bending)
            + shear * forces.shear.dot(rates.shear)
    }
}

/// Rates of the four modes.
#[derive(Debug, Clone, Copy)]
struct Rates<L> {
    /// m/s
    normal: L,
    /// rad/s
    twist: L,
    /// rad/s
    bending: Vector<L>,
    /// rad/s
    shear: Vector<L>,
}

impl<L: Real> Rates<L> {
    #[inline(always)]
    fn of((axis, _, per_length): Line<L>, motion: &Motion<L>) -> Self {
        let Motion {
            velocity,
            spins: [a, b],
        } = *motion;
        let (relative, mean) = (b - a, (a + b) * L::splat(0.5));
        let twist = relative.dot(axis);
        // The line of centres turns by axis x velocity/length.
        let turning = axis.cross(velocity) * per_length;
        Self {
            normal: velocity.dot(axis),
            twist,
            bending: relative - axis * twist,
            shear: mean - axis * mean.dot(axis) - turning,
        }
    }
}

impl<L: Real> Rotation<L> {
    /// Rotation `after` this one in its frame: the product of the quaternions.
    #[inline(always)]
    pub(super) fn times(self, after: Self) -> Self {
        let (a, b) = (self.vector, after.vector);
        Self {
            vector: b * self.real + a * after.real + a.cross(b),
            real: self.real * after.real - a.dot(b),
        }
    }
}

impl From<DQuat> for Rotation {
    fn from(DQuat { x, y, z, w }: DQuat) -> Self {
        Self {
            vector: Vector::new(x, y, z),
            real: w,
        }
    }
}

#[inline(always)]
fn line<L: Real>(branch: Vector<L>) -> Line<L> {
    let length = branch.length();
    let per_length = L::ONE / length;
    (branch * per_length, length, per_length)
}

/// Force on A and couples of a tension (N), a torsion (N m), a bending couple on A, and the sum of the couples on both ends across the axis, which forces
/// balance.
#[inline(always)]
fn assemble<L: Real>(
    (axis, _, per_length): Line<L>,
    (tension, torque): (L, L),
    (couple, balance): (Vector<L>, Vector<L>),
) -> (Vector<L>, [Vector<L>; 2]) {
    let half = balance * L::splat(0.5);
    let apart = couple + axis * torque;
    (
        axis * tension - axis.cross(balance) * per_length,
        [half + apart, half - apart],
    )
}

/// Rotation vectors of both ends against the frame of the element, rad.
///
/// The mean of two rotations p and q is the middle of the turn from one to the other: with r the half of that turn, p is the mean turned back by r, q the
/// mean turned on by r. The frame of the mean is turned the shortest way, o, onto the axis; against it the ends are r* o* and r o*, whose parts are
/// computed once.
#[inline(always)]
fn rotations_in_frame<L: Real>(
    axis: Vector<L>,
    [first, second]: [Rotation<L>; 2],
) -> [Vector<L>; 2] {
    // A rotation is two quaternions: those on one side.
    let cosine = first.vector.dot(second.vector) + first.real * second.real;
    let side = L::select(cosine.below(L::ZERO), -L::ONE, L::ONE);
    let cosine = cosine * side;
    let second = Rotation {
        vector: second.vector * side,
        real: second.real * side,
    };
    // The vector of q p*, and the cosine of the half of the half turn from that of the half.
    let turn =
        second.vector * first.real - first.vector * second.real + first.vector.cross(second.vector);
    let half = ((cosine + 1.0) * 0.5).sqrt();
    let r = turn * (L::splat(0.5) / half);
    // The first axis turned by the mean, whose square is 2 + 2 cosine before it is divided by its length.
    let Vector { x, y, z } = first.vector + second.vector;
    let w = first.real + second.real;
    let two = L::splat(2.0);
    let carried = Vector::new(
        (w * w - z * z) + (x * x - y * y),
        two * (x * y + w * z),
        two * (x * z - w * y),
    ) * (L::splat(0.5) / (cosine + 1.0));
    // Bent by half a turn, no way is the shortest: any is as good.
    let real = (carried.dot(axis) + 1.0).max(L::splat(1e-12));
    let scale = L::ONE / (two * real).sqrt();
    let (o, real) = (carried.cross(axis) * scale, real * scale);
    let along = r.dot(o);
    let (common, own) = (o * half, r * real - r.cross(o));
    [
        rotation_vector(half * real - along, -own - common),
        rotation_vector(half * real + along, own - common),
    ]
}

/// Rotation vector (rad) of a quaternion: 2 asin(s)/s times its vector of length s, by its series.
/// Off by 1e-7 of itself for turns of 0.7 rad, by 1e-4 of 1.7 rad.
#[inline(always)]
fn rotation_vector<L: Real>(real: L, vector: Vector<L>) -> Vector<L> {
    let s = vector.length_squared();
    let series = s * (35.0 / 576.0) + 5.0 / 56.0;
    let series = s * (s * (s * series + 3.0 / 20.0) + 1.0 / 3.0) + 2.0;
    let is_behind = real.below(L::ZERO);
    let factor = if is_behind.any() {
        L::select(is_behind, -series, series)
    } else {
        series
    };
    vector * factor
}
