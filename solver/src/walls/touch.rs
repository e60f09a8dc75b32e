//! What a wall answers when asked where a sphere is near it.

use glam::DVec3;

/// Most touches one query reports; further ones are dropped, the most distant first.
pub const MAX_TOUCHES: usize = 8;

/// One place where a sphere's centre is near a wall, in the frame of the query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// Distance from the centre to the surface in m; negative if the centre is beyond a one-sided
    /// surface.
    pub distance: f64,
    /// Unit vector at the surface, towards the particle's side: the direction of a repulsive force.
    pub normal: DVec3,
    /// Which face or edge of the wall this is. Contact histories are kept per feature.
    pub feature: u32,
    /// Principal curvatures of the wall at the foot of the normal in 1/m: positive if the wall is
    /// convex towards the particle (a sphere from outside), negative if concave (a cylinder from
    /// inside). Zero at edges and tips, where an ideal shape has none: the scene does not say how
    /// far the real edge is rounded.
    pub curvature: [f64; 2],
}

impl Touch {
    /// The content of unused slots.
    const NONE: Self = Self {
        distance: f64::INFINITY,
        normal: DVec3::ZERO,
        feature: u32::MAX,
        curvature: [0.0; 2],
    };
}

/// A list of at most [`MAX_TOUCHES`] touches that never allocates.
#[derive(Debug, Clone, Copy)]
pub struct Touches {
    items: [Touch; MAX_TOUCHES],
    len: usize,
}

impl Touches {
    /// An empty list.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            items: [Touch::NONE; MAX_TOUCHES],
            len: 0,
        }
    }

    /// Forgets all touches.
    pub const fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds a touch. A full list keeps the [`MAX_TOUCHES`] nearest ones (of equals, those that came
    /// first).
    pub fn push(&mut self, touch: Touch) {
        if self.len < MAX_TOUCHES {
            self.items[self.len] = touch;
            self.len += 1;
            return;
        }
        let mut farthest = 0;
        for i in 1..MAX_TOUCHES {
            if self.items[i].distance >= self.items[farthest].distance {
                farthest = i;
            }
        }
        if touch.distance < self.items[farthest].distance {
            self.items[farthest] = touch;
        }
    }

    /// The touches, in an order that depends only on the wall and the centre.
    pub fn iter(&self) -> std::slice::Iter<'_, Touch> {
        self.as_slice().iter()
    }

    /// The touches as a slice.
    #[must_use]
    pub fn as_slice(&self) -> &[Touch] {
        &self.items[..self.len]
    }

    /// How many touches there are.
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
        }
    }

    #[test]
    fn a_full_list_keeps_the_nearest() {
        let mut touches = Touches::new();
        for i in 0..20_u32 {
            // 7, 14, 1, 8, ...: every distance 0..20 once, not in order
            touches.push(touch(f64::from((7 * (i + 1)) % 20), i));
        }
        let mut kept: Vec<f64> = touches.iter().map(|t| t.distance).collect();
        kept.sort_by(f64::total_cmp);
        assert_eq!(kept, (0..8).map(f64::from).collect::<Vec<_>>());
        touches.clear();
        assert!(touches.is_empty());
        assert_eq!((&touches).into_iter().count(), 0);
    }
}
