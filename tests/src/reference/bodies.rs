//! Rigid bodies made of pebbles: the equations of motion of one body.

use glam::{DMat3, DVec3};

/// A rigid body. Its pebbles are particles that hold its index.
#[derive(Debug, Clone)]
pub struct Body {
    /// Position of the centre of mass \[m\].
    pub position: DVec3,
    /// Velocity of the centre of mass \[m/s\].
    pub velocity: DVec3,
    /// Its columns are the principal axes in the global frame.
    pub rotation: DMat3,
    /// Angular momentum about the centre of mass, global frame \[kg m²/s\].
    pub angular_momentum: DVec3,
    /// Principal moments of inertia \[kg m²\].
    pub moments: DVec3,
    /// Mass \[kg\].
    pub mass: f64,
    /// Indices of its pebbles among the particles, and where they are in the principal frame \[m\].
    pub pebbles: Vec<(usize, DVec3)>,
    /// Never moves, and counts as infinitely heavy.
    pub fixed: bool,
    /// Components of the velocity that keep their present value.
    pub velocity_held: [bool; 3],
    /// Components of the angular velocity that have given values \[rad/s\].
    pub angular_velocity_held: [Option<f64>; 3],
    /// Sum of the contact forces \[N\].
    pub force: DVec3,
    /// Sum of the contact torques about the centre of mass \[N m\].
    pub torque: DVec3,
}

impl Body {
    /// I = R diag(moments) Rᵀ in the global frame.
    pub fn inertia(&self) -> DMat3 {
        self.rotation * DMat3::from_diagonal(self.moments) * self.rotation.transpose()
    }

    /// ω: where free, L = I ω; where held, its given value.
    pub fn angular_velocity(&self) -> DVec3 {
        let inertia = self.inertia();
        let mut matrix = [inertia.row(0), inertia.row(1), inertia.row(2)];
        let mut right = self.angular_momentum;
        for axis in 0..3 {
            if let Some(value) = self.angular_velocity_held[axis] {
                matrix[axis] = DVec3::AXES[axis];
                right[axis] = value;
            }
        }
        DMat3::from_cols(matrix[0], matrix[1], matrix[2])
            .transpose()
            .inverse()
            * right
    }

    /// v += (F/m + g) dt/2, L += T dt/2.
    pub fn half_kick(&mut self, half: f64, gravity: DVec3) {
        if self.fixed {
            return;
        }
        let acceleration = self.force / self.mass + gravity;
        for axis in 0..3 {
            if !self.velocity_held[axis] {
                self.velocity[axis] += acceleration[axis] * half;
            }
        }
        self.angular_momentum += self.torque * half;
    }

    /// x += v dt, and the rotation of `time` seconds. Returns ω of the middle: the mean of before and after, or that of the midpoint
    /// rule.
    pub fn drift(&mut self, time: f64) -> DVec3 {
        let before = self.angular_velocity();
        if self.fixed {
            return before;
        }
        self.position += self.velocity * time;
        if self.angular_velocity_held == [None; 3] {
            // Dullweber, Leimkuhler & McLachlan 1997: rotations about the principal axes 1, 2, 3, 2, 1 in turn, each by the angle that the
            // angular momentum along it gives, which stays where it is in the global frame.
            for (axis, share) in [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)] {
                let along = (self.rotation.transpose() * self.angular_momentum)[axis];
                let angle = share * time * along / self.moments[axis];
                self.rotation *= DMat3::from_axis_angle(DVec3::AXES[axis], angle);
            }
            0.5 * (before + self.angular_velocity())
        } else {
            // Midpoint rule.
            let start = self.rotation;
            let turned = |spin: DVec3, time: f64| match spin.try_normalize() {
                Some(axis) => DMat3::from_axis_angle(axis, spin.length() * time) * start,
                None => start,
            };
            self.rotation = turned(self.angular_velocity(), 0.5 * time);
            let middle = self.angular_velocity();
            self.rotation = turned(middle, time);
            self.angular_momentum = self.inertia() * self.angular_velocity();
            middle
        }
    }

    /// From the centre of mass to a pebble \[m\].
    pub fn lever(&self, pebble: usize) -> DVec3 {
        self.rotation * self.pebbles[pebble].1
    }

    /// The inverse of the mass that an impulse along `normal` meets at `lever` from the centre of mass \[1/kg\].
    pub fn mobility(&self, lever: DVec3, normal: DVec3) -> f64 {
        if self.fixed {
            return 0.0;
        }
        let arm = lever.cross(normal);
        1.0 / self.mass + arm.dot(self.inertia().inverse() * arm)
    }
}
