//! The half-plane of a surface of revolution: which features of a polygon are near a point.
//!
//! The point of a surface of revolution that is closest to a sphere's centre lies in the half-plane
//! of that centre, so everything happens in `(r, z)`.
//!
//! Rules. A piece of the polygon (a *face*) is touched where the centre projects onto it; a corner is
//! touched only where the centre projects onto neither of its pieces, so that every place on the
//! particle's side of a convex corner belongs to one feature, and a concave corner gives one touch
//! per face. Whether the centre lies beyond a one-sided surface is decided by the nearest feature: if
//! the centre is in front of that one, faces seen from behind (the far side of a thin lip) don't
//! count; if it is behind, that feature pushes it back, and so do all those it is in front of.
//!
//! Feature numbers of `n` pieces and `c` corners: pieces `0..n`, corners `n..n + c`, and for two-sided
//! surfaces the backs of the pieces `n + c..2 n + c`.

use super::error::{WallError, finite, not_negative};
use super::side::Side;
use glam::DVec2;

/// Corners that turn by less than this (sine of the angle) count as straight.
const STRAIGHT: f64 = 1e-9;

/// How the polygon turns at a corner, seen from the front.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Turn {
    /// The polygon ends here.
    End,
    Straight,
    Convex,
    Concave,
}

#[derive(Debug, Clone, PartialEq)]
struct Corner {
    point: DVec2,
    turn: Turn,
}

#[derive(Debug, Clone, PartialEq)]
struct Piece {
    start: DVec2,
    direction: DVec2,
    length: f64,
    /// Towards the front.
    normal: DVec2,
}

/// Where a point is, relative to a piece.
#[derive(Debug, Clone, Copy)]
struct Projection {
    /// Distance from the start along the piece.
    along: f64,
    /// Height above the line of the piece, positive in front.
    height: f64,
    within: bool,
}

impl Piece {
    #[inline]
    fn project(&self, point: DVec2) -> Projection {
        let offset = point - self.start;
        let along = offset.dot(self.direction);
        Projection {
            along,
            height: offset.dot(self.normal),
            within: along >= 0.0 && along <= self.length,
        }
    }
}

/// A feature near a point of the half-plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Near {
    /// Negative beyond a one-sided surface.
    pub(super) distance: f64,
    /// Unit vector towards the particle's side.
    pub(super) normal: DVec2,
    pub(super) feature: u32,
    /// Distance from the axis of the foot of the normal; infinite at corners, which have no
    /// curvature.
    pub(super) foot_radius: f64,
    /// How the normal turns in the half-plane when the point moves along the surface, rad/m.
    pub(super) turning: f64,
}

/// A polygon in the half-plane `r >= 0`, open or closed.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Profile {
    pieces: Vec<Piece>,
    corners: Vec<Corner>,
    closed: bool,
    side: Side,
    two_sided: bool,
    min: DVec2,
    max: DVec2,
}

impl Profile {
    /// Largest distance of its points from the axis, m.
    pub(super) fn widest(&self) -> f64 {
        self.max.x
    }

    /// The polygon through `points` `(r, z)`; closed if it ends where it began.
    ///
    /// The inside is the region between the polygon and the axis (within a closed polygon), in
    /// whichever direction the points are listed. A polygon that encloses nothing with the axis, like
    /// a horizontal piece, has its inside to the left of its direction (`r` to the right, `z` up).
    pub(super) fn new(points: &[[f64; 2]], side: Side) -> Result<Self, WallError> {
        if points.len() < 2 {
            return Err(WallError::TooFewPoints {
                count: points.len(),
            });
        }
        for &[r, z] in points {
            not_negative("profile", r)?;
            finite("profile", z)?;
        }
        let points: Vec<DVec2> = points.iter().map(|&p| DVec2::from_array(p)).collect();
        for (index, pair) in points.windows(2).enumerate() {
            if pair[0] == pair[1] {
                return Err(WallError::RepeatedPoint { index });
            }
            if pair[0].x == 0.0 && pair[1].x == 0.0 {
                return Err(WallError::PieceOnAxis { index });
            }
        }
        let closed = points.len() > 3 && points.first() == points.last();
        refuse_crossings(&points, closed)?;

        let front = inside_sign(&points) * if side == Side::Outside { -1.0 } else { 1.0 };
        let pieces: Vec<Piece> = points
            .windows(2)
            .map(|pair| {
                let length = (pair[1] - pair[0]).length();
                let direction = (pair[1] - pair[0]) / length;
                Piece {
                    start: pair[0],
                    direction,
                    length,
                    normal: direction.perp() * front,
                }
            })
            .collect();
        let corners = corners(&points, &pieces, closed, front);
        let mut min = points[0];
        let mut max = points[0];
        for &point in &points {
            min = min.min(point);
            max = max.max(point);
        }
        Ok(Self {
            pieces,
            corners,
            closed,
            side,
            two_sided: side == Side::Both,
            min,
            max,
        })
    }

    /// The corners as `(r, z)`, each once.
    pub(super) fn points(&self) -> impl Iterator<Item = DVec2> + '_ {
        self.corners.iter().map(|corner| corner.point)
    }

    pub(super) fn side(&self) -> Side {
        self.side
    }

    /// Whether the last corner is joined to the first.
    pub(super) fn is_closed(&self) -> bool {
        self.closed
    }

    /// Whether `point` is closer than `reach` to the polygon.
    pub(super) fn is_near(&self, point: DVec2, reach: f64) -> bool {
        if point.cmplt(self.min - reach).any() || point.cmpgt(self.max + reach).any() {
            return false;
        }
        self.pieces.iter().any(|piece| {
            let offset = point - piece.start;
            let along = offset.dot(piece.direction).clamp(0.0, piece.length);
            offset.distance_squared(piece.direction * along) < reach * reach
        })
    }

    /// Its points, for [`Profile::with_numbers`].
    pub(super) fn numbers(&self) -> Vec<f64> {
        let points = self.points();
        let end = self.corners.first().filter(|_| self.closed);
        let all = points.chain(end.map(|corner| corner.point));
        all.flat_map(|point| point.to_array()).collect()
    }

    /// This polygon through other points; `None` if it is none or if pieces come or go.
    pub(super) fn with_numbers(&self, numbers: &[f64]) -> Option<Self> {
        let (points, rest) = numbers.as_chunks::<2>();
        let new = Self::new(points, self.side).ok()?;
        (rest.is_empty() && self.is_like(&new)).then_some(new)
    }

    /// Whether the features of the two are the same in number and meaning.
    fn is_like(&self, other: &Self) -> bool {
        let sizes = |profile: &Self| (profile.pieces.len(), profile.corners.len());
        sizes(self) == sizes(other) && self.closed == other.closed && self.side == other.side
    }

    /// How far a point moves when this polygon becomes `other`; `None` if it cannot.
    pub(super) fn way_to(&self, other: &Self) -> Option<f64> {
        let corners = self.points().zip(other.points());
        let farthest = corners.fold(0.0f64, |most, (one, other)| most.max(one.distance(other)));
        self.is_like(other).then_some(farthest)
    }

    /// Largest coordinate.
    pub(super) fn scale(&self) -> f64 {
        self.min.abs().max(self.max.abs()).max_element()
    }

    /// Reports every feature within `reach` of `point`.
    #[inline]
    pub(super) fn near(&self, point: DVec2, reach: f64, mut report: impl FnMut(Near)) {
        if point.cmplt(self.min - reach).any() || point.cmpgt(self.max + reach).any() {
            return;
        }
        let mut nearest_in_front = f64::INFINITY;
        let mut behind: Option<Near> = None;
        let mut collect = |near: Near| {
            if near.distance >= 0.0 {
                nearest_in_front = nearest_in_front.min(near.distance);
                report(near);
            } else if behind.is_none_or(|other| near.distance > other.distance) {
                behind = Some(near);
            }
        };

        let last = self.pieces.len() - 1;
        let mut previous = self.closed.then(|| self.pieces[last].project(point));
        for (index, piece) in self.pieces.iter().enumerate() {
            let here = piece.project(point);
            if here.along < 0.0
                && previous.is_none_or(|p| p.along > self.pieces[before(index, last)].length)
                && let Some(near) = self.corner(index, here, point, reach)
            {
                collect(near);
            }
            let shared = here.within
                && previous
                    .is_some_and(|p| p.within && self.is_shared(index, p.height, here.height));
            if here.within && !shared && here.height.abs() < reach {
                collect(self.face(index, here));
            }
            previous = Some(here);
        }
        if !self.closed
            && let Some(end) = previous.filter(|p| p.along > self.pieces[last].length)
            && let Some(near) = self.corner(last + 1, end, point, reach)
        {
            collect(near);
        }

        if let Some(near) = behind.filter(|near| -near.distance < nearest_in_front) {
            report(near);
        }
    }

    /// Whether a point that projects onto both pieces of a corner does so only by round-off (it is at
    /// the tip, or the corner is none), so that they are one place.
    #[inline]
    fn is_shared(&self, corner: usize, height_before: f64, height_after: f64) -> bool {
        match self.corners[corner].turn {
            Turn::End => false,
            Turn::Straight => true,
            Turn::Convex => height_before >= 0.0 && height_after >= 0.0,
            Turn::Concave => self.two_sided && height_before <= 0.0 && height_after <= 0.0,
        }
    }

    #[inline]
    fn face(&self, index: usize, at: Projection) -> Near {
        let piece = &self.pieces[index];
        let flipped = self.two_sided && at.height < 0.0;
        let back = self.pieces.len() + self.corners.len();
        Near {
            distance: if flipped { -at.height } else { at.height },
            normal: if flipped { -piece.normal } else { piece.normal },
            feature: (if flipped { back + index } else { index }) as u32,
            foot_radius: piece.start.x + at.along * piece.direction.x,
            turning: 0.0,
        }
    }

    /// The touch of a corner by a point that projects onto none of its pieces; `beside` is the
    /// projection onto one of them.
    fn corner(&self, index: usize, beside: Projection, point: DVec2, reach: f64) -> Option<Near> {
        let corner = &self.corners[index];
        let offset = point - corner.point;
        let length = offset.length();
        if length >= reach {
            return None;
        }
        let piece = index.min(self.pieces.len() - 1);
        // Round-off can put a point between two pieces in line, or at a tip, beside both of them.
        if corner.turn == Turn::Straight || length == 0.0 {
            return Some(self.face(piece, beside));
        }
        let sign = if corner.turn == Turn::Concave && !self.two_sided {
            -1.0
        } else {
            1.0
        };
        Some(Near {
            distance: sign * length,
            normal: offset * (sign / length),
            feature: (self.pieces.len() + index) as u32,
            foot_radius: f64::INFINITY,
            turning: sign / length,
        })
    }

    /// Whether a contact that rolls along the surface passes from one feature to the other without
    /// meeting a third: a face and one of its corners, or two faces with a corner in common.
    pub(super) fn adjacent(&self, a: u32, b: u32) -> bool {
        let pieces = self.pieces.len() as u32;
        let corners = self.corners.len() as u32;
        // (is a face, is a back, number)
        let split = |feature: u32| {
            if feature < pieces {
                (true, false, feature)
            } else if feature < pieces + corners {
                (false, false, feature - pieces)
            } else {
                (true, true, feature - pieces - corners)
            }
        };
        if a == b || a.max(b) >= 2 * pieces + corners {
            return false;
        }
        let ((a_face, a_back, a), (b_face, b_back, b)) = (split(a), split(b));
        let next = |i: u32| if i + 1 == corners { 0 } else { i + 1 };
        match (a_face, b_face) {
            (true, true) if a_back == b_back => {
                let in_line = |i: u32, j: u32| j == i + 1 || (self.closed && j == next(i));
                in_line(a, b) || in_line(b, a)
            }
            (true, false) => b == a || b == next(a),
            (false, true) => a == b || a == next(b),
            _ => false,
        }
    }
}

fn before(index: usize, last: usize) -> usize {
    if index == 0 { last } else { index - 1 }
}

/// +1 if the inside is to the left of the direction of the polygon, -1 if to the right.
fn inside_sign(points: &[DVec2]) -> f64 {
    // The area between the polygon and the axis is the integral of r dz (Green's theorem), positive if
    // it lies to the left. For a closed polygon the same sum is its own area.
    let mut area = 0.0;
    let mut size = 0.0;
    for pair in points.windows(2) {
        let step = pair[1] - pair[0];
        area += 0.5 * (pair[0].x + pair[1].x) * step.y;
        size += (pair[0].x + pair[1].x) * step.length();
    }
    if area < -1e-12 * size { -1.0 } else { 1.0 }
}

fn corners(points: &[DVec2], pieces: &[Piece], closed: bool, front: f64) -> Vec<Corner> {
    let mirror = |direction: DVec2| DVec2::new(direction.x, -direction.y);
    let last = pieces.len() - 1;
    let count = if closed {
        points.len() - 1
    } else {
        points.len()
    };
    (0..count)
        .map(|i| {
            let point = points[i];
            let incoming = (i > 0 || closed).then(|| pieces[before(i, last)].direction);
            let outgoing = (i <= last).then(|| pieces[i].direction);
            // A polygon that ends on the axis goes on as its mirror image.
            let (incoming, outgoing) = match (incoming, outgoing) {
                (None, Some(out)) if point.x == 0.0 => (Some(mirror(out)), Some(out)),
                (Some(into), None) if point.x == 0.0 => (Some(into), Some(mirror(into))),
                both => both,
            };
            let turn = match (incoming, outgoing) {
                (Some(into), Some(out)) => {
                    let sine = front * into.perp_dot(out);
                    if sine > STRAIGHT {
                        Turn::Concave
                    } else if sine < -STRAIGHT {
                        Turn::Convex
                    } else {
                        Turn::Straight
                    }
                }
                _ => Turn::End,
            };
            Corner { point, turn }
        })
        .collect()
}

/// Refuses polygons whose pieces have more in common than the corners between neighbours.
fn refuse_crossings(points: &[DVec2], closed: bool) -> Result<(), WallError> {
    let pieces = points.len() - 1;
    for first in 0..pieces {
        let (a, b) = (points[first], points[first + 1]);
        for second in first + 1..pieces {
            let (c, d) = (points[second], points[second + 1]);
            let neighbours_at = if second == first + 1 {
                Some((a, b, d))
            } else if closed && first == 0 && second == pieces - 1 {
                Some((c, a, b))
            } else {
                None
            };
            let bad = match neighbours_at {
                Some((p, q, r)) => folds_back(p, q, r),
                None => meet((a, b), (c, d)),
            };
            if bad {
                return Err(WallError::Crossing { first, second });
            }
        }
    }
    Ok(())
}

/// Whether the way p - q - r returns on itself at q.
fn folds_back(p: DVec2, q: DVec2, r: DVec2) -> bool {
    let (into, out) = ((q - p).normalize(), (r - q).normalize());
    into.dot(out) < 0.0 && into.perp_dot(out).abs() <= STRAIGHT
}

/// Whether two closed line segments have a point in common.
fn meet((a, b): (DVec2, DVec2), (c, d): (DVec2, DVec2)) -> bool {
    if a.max(b).cmplt(c.min(d)).any() || c.max(d).cmplt(a.min(b)).any() {
        return false;
    }
    let side = |p: DVec2, q: DVec2, x: DVec2| (q - p).perp_dot(x - p);
    side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0
}
