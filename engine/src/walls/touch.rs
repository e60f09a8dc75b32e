//! The result of a query for the surface of a wall near a sphere.

use glam::DVec3;

/// Touches that have their place in the list itself: more than a sphere has in the corner of a box.
const IN_PLACE: usize = 8;

/// One place where a sphere's centre is near a wall, in the frame of the query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// Distance from the centre to the surface in m; negative if the centre is beyond a one-sided
    /// surface.
    pub distance: f64,
    /// Unit vector at the surface, towards the particle's side: the direction of a repulsive force.
    pub normal: DVec3,
    /// Face or edge of the wall that is touched. Contact histories are kept per feature.
    pub feature: u32,
    /// Principal curvatures of the wall at the foot of the normal in 1/m: positive if the wall is
    /// convex towards the particle (a sphere from outside), negative if concave (a cylinder from
    /// inside). Zero at edges and tips, where an ideal shape has none: the scene does not state how
    /// far the real edge is rounded.
    pub curvature: [f64; 2],
    /// How the normal turns when the centre moves along the surface.
    pub turning: Turning,
}

/// How a wall's normal turns when a sphere's centre moves: the second derivatives of the distance from the wall.
///
/// At the distance s from a surface of the principal curvature k the normal turns by k/(1 + k s) for each metre; beside an edge or
/// a tip by 1/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turning {
    /// A principal direction in the tangent plane, of length 1; the other one is normal x `along`.
    pub along: DVec3,
    /// For each metre along it, and along the other one, rad/m.
    pub rates: [f64; 2],
}

impl Turning {
    /// On a flat face.
    pub const NONE: Self = Self {
        along: DVec3::X,
        rates: [0.0; 2],
    };

    /// The change of the normal (1) for a change of the centre's place (m), or of both for each second.
    #[inline]
    #[must_use]
    pub fn of(&self, normal: DVec3, way: DVec3) -> DVec3 {
        let across = normal.cross(self.along);
        self.along * (self.rates[0] * way.dot(self.along))
            + across * (self.rates[1] * way.dot(across))
    }
}

impl Touch {
    /// The content of unused slots.
    const NONE: Self = Self {
        distance: f64::INFINITY,
        normal: DVec3::ZERO,
        feature: u32::MAX,
        curvature: [0.0; 2],
        turning: Turning::NONE,
    };
}

/// A list of touches. It allocates only for a sphere that touches more than `IN_PLACE` features of a wall at once.
#[derive(Debug, Clone)]
pub struct Touches {
    items: [Touch; IN_PLACE],
    len: usize,
    /// All of them, if there are more than [`IN_PLACE`].
    many: Vec<Touch>,
}

impl Touches {
    /// An empty list.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            items: [Touch::NONE; IN_PLACE],
            len: 0,
            many: Vec::new(),
        }
    }

    /// Forgets all touches.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds a touch.
    #[inline]
    pub fn push(&mut self, touch: Touch) {
        match self.items.get_mut(self.len) {
            Some(item) => *item = touch,
            None => self.push_beyond(touch),
        }
        self.len += 1;
    }

    /// Adds a touch to a list of [`IN_PLACE`] or more.
    #[cold]
    fn push_beyond(&mut self, touch: Touch) {
        if self.len == IN_PLACE {
            self.many.clear();
            self.many.extend_from_slice(&self.items);
        }
        self.many.push(touch);
    }

    /// The touches, in an order that depends only on the wall and the centre.
    pub fn iter(&self) -> std::slice::Iter<'_, Touch> {
        self.as_slice().iter()
    }

    /// The touches as a slice.
    #[must_use]
    pub fn as_slice(&self) -> &[Touch] {
        if self.len <= IN_PLACE {
            &self.items[..self.len]
        } else {
            &self.many
        }
    }

    /// Number of touches.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.len
    }

    /// Whether the sphere is near nothing.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }
}

impl Default for Touches {
    fn default() -> Self {
        Self::new()
    }
}

impl<'a> IntoIterator for &'a Touches {
    type Item = &'a Touch;
    type IntoIter = std::slice::Iter<'a, Touch>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(distance: f64, feature: u32) -> Touch {
        Touch {
            distance,
            normal: DVec3::X,
            feature,
            curvature: [0.0; 2],
            turning: Turning::NONE,
        }
    }

    #[test]
    fn no_touch_is_dropped() {
        let mut touches = Touches::new();
        for count in [20, 3, 8, 9, 1000] {
            touches.clear();
            assert!(touches.is_empty());
            assert_eq!((&touches).into_iter().count(), 0);
            for i in 0..count {
                touches.push(touch(f64::from(i), i));
                assert_eq!(touches.len(), i as usize + 1);
            }
            let kept: Vec<u32> = touches.iter().map(|touch| touch.feature).collect();
            assert_eq!(kept, (0..count).collect::<Vec<_>>());
        }
    }
}
