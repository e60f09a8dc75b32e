//! Where a sphere touches a wall, and how the wall moves there.
//!
//! A sphere touches a wall at every point that is nearer to its centre than all points around it:
//! once on a plane, twice in the groove between two faces, once on the edge where two faces meet
//! the other way. A surface of revolution is looked at in the half plane (r, z) through the axis
//! and the centre of the sphere, where it is a chain of straight segments.

use glam::{DMat3, DQuat, DVec3};

use super::triangles;

/// A wall: a shape, as it stands at t = 0, that may move.
#[derive(Debug, Clone)]
pub struct Wall {
    /// The shape at t = 0.
    pub shape: Shape,
    /// Its rigid motion.
    pub motion: Motion,
    /// Index that the pair-parameter function receives.
    pub material: usize,
}

/// Where the particles are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Inside the closed shape.
    Inside,
    /// Outside of it.
    Outside,
}

/// The shape of a wall. Axes are unit vectors.
#[derive(Debug, Clone)]
pub enum Shape {
    /// A half space: particles are where `normal` (unit) points, the rest is solid.
    Plane {
        /// A point of the surface \[m\].
        point: DVec3,
        /// Unit normal, into the space of the particles.
        normal: DVec3,
    },
    /// A circular cylinder without ends; behind it everything is solid.
    Cylinder {
        /// A point of the axis \[m\].
        origin: DVec3,
        /// Direction of the axis.
        axis: DVec3,
        /// Radius \[m\].
        radius: f64,
        /// Where the particles are.
        side: Side,
    },
    /// A sphere; behind its surface everything is solid.
    Sphere {
        /// Centre \[m\].
        origin: DVec3,
        /// Radius \[m\].
        radius: f64,
        /// Where the particles are.
        side: Side,
    },
    /// A thin shell, touched from both sides and at its rims: a chain of segments in the (r, z)
    /// plane turned about the axis.
    Revolution {
        /// The point of the axis with z = 0 \[m\].
        origin: DVec3,
        /// Direction of the axis.
        axis: DVec3,
        /// The corners (r, z) of the chain \[m\].
        profile: Vec<(f64, f64)>,
    },
    /// Triangles, touched from both sides.
    Triangles(Vec<[DVec3; 3]>),
}

impl Shape {
    /// A flat round plate, touched from both sides and at its rim.
    pub fn disc(origin: DVec3, axis: DVec3, radius: f64) -> Self {
        Shape::Revolution {
            origin,
            axis,
            profile: vec![(0.0, 0.0), (radius, 0.0)],
        }
    }

    /// A pipe of finite length, as a thin shell; `along`: its extent on the axis from the origin.
    pub fn pipe(origin: DVec3, axis: DVec3, radius: f64, along: [f64; 2]) -> Self {
        Shape::cone(origin, axis, along, [radius, radius])
    }

    /// A truncated cone, as a thin shell, with the `radii` at the two ends of `along`.
    pub fn cone(origin: DVec3, axis: DVec3, along: [f64; 2], radii: [f64; 2]) -> Self {
        let profile = vec![(radii[0], along[0]), (radii[1], along[1])];
        Shape::Revolution {
            origin,
            axis,
            profile,
        }
    }

    /// Every place where a sphere touches the shape.
    pub fn contacts(&self, centre: DVec3, radius: f64) -> Vec<WallContact> {
        let nearest = match self {
            Shape::Triangles(triangles) => triangles::contacts(triangles, centre, radius),
            Shape::Plane { point, normal } => {
                let distance = (centre - *point).dot(*normal);
                vec![WallContact {
                    feature: 0,
                    normal: *normal,
                    distance,
                    turning: DMat3::ZERO,
                }]
            }
            Shape::Cylinder {
                origin,
                axis,
                radius,
                side,
            } => {
                let from_origin = centre - *origin;
                let outward = from_origin - from_origin.dot(*axis) * *axis;
                vec![round_contact(outward, *radius, *side, square(*axis))]
            }
            Shape::Sphere {
                origin,
                radius,
                side,
            } => {
                vec![round_contact(centre - *origin, *radius, *side, DMat3::ZERO)]
            }
            Shape::Revolution {
                origin,
                axis,
                profile,
            } => {
                let from_origin = centre - *origin;
                let z = from_origin.dot(*axis);
                let outward = from_origin - z * *axis;
                let r = outward.length();
                let radial = outward
                    .try_normalize()
                    .unwrap_or(axis.any_orthonormal_vector());
                let nearest = nearest_on_chain(profile, (r, z));
                let contact = |(feature, (foot_r, foot_z)): (usize, (f64, f64))| {
                    let from_foot = (r - foot_r) * radial + (z - foot_z) * *axis;
                    let distance = from_foot.length();
                    let normal = from_foot.try_normalize()?; // centre on the shell: no side to push to
                    // Round the axis the normal keeps its angle with it; in the half plane it turns about a corner.
                    let round = axis.cross(radial);
                    let is_corner = feature % 2 == 1;
                    let across = if is_corner {
                        square(normal.cross(round)) * (1.0 / distance)
                    } else {
                        DMat3::ZERO
                    };
                    Some(WallContact {
                        feature,
                        normal,
                        distance,
                        turning: square(round) * (normal.dot(radial) / r) + across,
                    })
                };
                nearest.into_iter().filter_map(contact).collect()
            }
        };
        nearest
            .into_iter()
            .filter(|contact| contact.distance < radius)
            .collect()
    }

    /// Whether a sphere rolls from one feature straight onto the other: from a segment onto one of its corners and back, and
    /// from a segment onto the next, as a step may be longer than the way round the corner.
    pub fn adjacent(&self, one: usize, other: usize) -> bool {
        let apart = (one.wrapping_sub(other) as isize).unsigned_abs();
        let both_corners = one % 2 == 1 && other % 2 == 1;
        matches!(self, Shape::Revolution { .. }) && (apart == 1 || apart == 2 && !both_corners)
    }
}

/// One place where a sphere touches a wall.
#[derive(Debug, Clone, Copy)]
pub struct WallContact {
    /// Part of the wall: the triangle; or 2 i is segment i of a profile, 2 i + 1 the corner after it; corner 0 is `usize::MAX`.
    /// Other shapes have one part, 0. History passes between adjacent parts.
    pub feature: usize,
    /// Unit normal from the wall to the particle.
    pub normal: DVec3,
    /// Distance of the centre from the wall \[m\]; negative when a centre is behind the surface.
    pub distance: f64,
    /// How the normal changes when the centre moves, 1/m: the second derivatives of the distance.
    pub turning: DMat3,
}

/// u uᵀ.
pub(super) fn square(u: DVec3) -> DMat3 {
    DMat3::from_cols(u * u.x, u * u.y, u * u.z)
}

/// The contact with a circle or sphere around the origin of `outward`.
///
/// `straight`: the square of the direction in which it does not bend.
fn round_contact(outward: DVec3, radius: f64, side: Side, straight: DMat3) -> WallContact {
    let from_centre = outward.length();
    let direction = outward.try_normalize().unwrap_or(DVec3::X);
    let turning = (DMat3::IDENTITY - square(direction) - straight) * (1.0 / from_centre);
    match side {
        Side::Inside => WallContact {
            feature: 0,
            normal: -direction,
            distance: radius - from_centre,
            turning: turning * -1.0,
        },
        Side::Outside => WallContact {
            feature: 0,
            normal: direction,
            distance: from_centre - radius,
            turning,
        },
    }
}

/// The points of a chain of segments that are locally nearest to `centre`, each with its feature.
fn nearest_on_chain(chain: &[(f64, f64)], centre: (f64, f64)) -> Vec<(usize, (f64, f64))> {
    // Where along each segment the foot of the perpendicular falls: 0 its start, 1 its end.
    let foot_of = |segment: &[(f64, f64)]| {
        let (start, end) = (segment[0], segment[1]);
        let along = (end.0 - start.0, end.1 - start.1);
        let towards = (centre.0 - start.0, centre.1 - start.1);
        let square = along.0 * along.0 + along.1 * along.1;
        (along.0 * towards.0 + along.1 * towards.1) / square
    };
    let feet: Vec<f64> = chain.windows(2).map(foot_of).collect();
    let mut nearest = Vec::new();
    for (i, &foot) in feet.iter().enumerate() {
        if foot > 0.0 && foot < 1.0 {
            let (start, end) = (chain[i], chain[i + 1]);
            let point = (
                start.0 + foot * (end.0 - start.0),
                start.1 + foot * (end.1 - start.1),
            );
            nearest.push((2 * i, point));
        }
    }
    // A corner is nearest where neither of its segments comes nearer.
    for (i, &corner) in chain.iter().enumerate() {
        let before_ends_here = i == 0 || feet[i - 1] >= 1.0;
        let after_starts_here = i == feet.len() || feet[i] <= 0.0;
        if before_ends_here && after_starts_here {
            nearest.push(((2 * i).wrapping_sub(1), corner));
        }
    }
    nearest
}

/// A steady rigid motion that begins at t = 0.
#[derive(Debug, Clone, Copy, Default)]
pub enum Motion {
    /// At rest.
    #[default]
    None,
    /// Constant velocity \[m/s\].
    Translation(DVec3),
    /// Constant rotation about a fixed point.
    Rotation {
        /// A point of the axis \[m\].
        origin: DVec3,
        /// Along the axis, right-handed \[rad/s\].
        angular_velocity: DVec3,
    },
}

impl Motion {
    /// Velocity of the wall's material at a point \[m/s\].
    pub fn velocity_at(&self, point: DVec3) -> DVec3 {
        match *self {
            Motion::None => DVec3::ZERO,
            Motion::Translation(velocity) => velocity,
            Motion::Rotation {
                origin,
                angular_velocity,
            } => angular_velocity.cross(point - origin),
        }
    }

    /// Angular velocity of the wall \[rad/s\].
    pub fn angular_velocity(&self) -> DVec3 {
        match *self {
            Motion::Rotation {
                angular_velocity, ..
            } => angular_velocity,
            _ => DVec3::ZERO,
        }
    }
}

impl Wall {
    /// A wall at rest, of material 0.
    pub fn at_rest(shape: Shape) -> Self {
        Self {
            shape,
            motion: Motion::None,
            material: 0,
        }
    }

    /// Where a point that moves with the wall was at t = 0.
    pub fn carried_back(&self, point: DVec3, time: f64) -> DVec3 {
        match self.motion {
            Motion::None => point,
            Motion::Translation(velocity) => point - velocity * time,
            Motion::Rotation {
                origin,
                angular_velocity,
            } => {
                let turn = DQuat::from_scaled_axis(angular_velocity * time);
                origin + turn.inverse() * (point - origin)
            }
        }
    }

    /// Every place where a sphere touches the wall at time `time`: the sphere is carried back to
    /// where the wall stood at t = 0, and the normals found there are carried forward.
    pub fn contacts(&self, centre: DVec3, radius: f64, time: f64) -> Vec<WallContact> {
        match self.motion {
            Motion::None => self.shape.contacts(centre, radius),
            Motion::Translation(velocity) => self.shape.contacts(centre - velocity * time, radius),
            Motion::Rotation {
                angular_velocity, ..
            } => {
                let turn = DQuat::from_scaled_axis(angular_velocity * time);
                let carried_back = self.carried_back(centre, time);
                let mut contacts = self.shape.contacts(carried_back, radius);
                for contact in &mut contacts {
                    contact.normal = turn * contact.normal;
                    let turn = DMat3::from_quat(turn);
                    contact.turning = turn * contact.turning * turn.transpose();
                }
                contacts
            }
        }
    }
}
