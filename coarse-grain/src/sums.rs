//! The sums over particles and contacts that fields are made of, and where each lies in memory.
//!
//! Sums are linear in the particles: they are what is averaged over frames, added over materials and summed in space. Everything
//! else (velocity, temperature, pressure, ...) is computed from them at the end, see [`fields`](crate::fields).

/// Source of the spread values, and the function that spreads them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Spread {
    /// Something of each particle, by the kernel at its centre.
    Particles,
    /// Something of each particle, by the gradient of the kernel.
    Gradients,
    /// Something of each contact, by the line integral along its branch vector.
    Lines,
    /// Something of each contact, by the first moment of the line integral.
    Moments,
    /// Forces of boundaries, by the kernel at the contact point.
    Boundary,
}

/// All kinds of spreading.
pub const SPREADS: [Spread; 5] = [
    Spread::Particles,
    Spread::Gradients,
    Spread::Lines,
    Spread::Moments,
    Spread::Boundary,
];

/// How numbers turn with the axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rank {
    /// Numbers that do not turn, of this count.
    Scalars(usize),
    /// A vector: x, y, z.
    Vector,
    /// A vector that keeps its sense in a mirror's plane: angular velocity, torque.
    Axial,
    /// A symmetric tensor: xx, xy, xz, yy, yz, zz.
    Symmetric,
    /// A tensor: xx, xy, xz, yx, ..., zz.
    Tensor,
    /// A tensor whose first index is axial.
    AxialTensor,
}

impl Rank {
    /// The number of components.
    #[must_use]
    pub fn components(self) -> usize {
        match self {
            Self::Scalars(count) => count,
            Self::Vector | Self::Axial => 3,
            Self::Symmetric => 6,
            Self::Tensor | Self::AxialTensor => 9,
        }
    }

    /// Axes (as bits) whose mirroring turns the sign, of each component.
    #[must_use]
    pub fn parity(self) -> Vec<u8> {
        let polar = |axis: usize| 1u8 << axis;
        let axial = |axis: usize| 7u8 ^ (1 << axis);
        let pairs = |first: &dyn Fn(usize) -> u8| -> Vec<u8> {
            (0..9).map(|k| first(k / 3) ^ polar(k % 3)).collect()
        };
        match self {
            Self::Scalars(count) => vec![0; count],
            Self::Vector => (0..3).map(polar).collect(),
            Self::Axial => (0..3).map(axial).collect(),
            Self::Symmetric => SYMMETRIC
                .iter()
                .map(|&(a, b)| polar(a) ^ polar(b))
                .collect(),
            Self::Tensor => pairs(&polar),
            Self::AxialTensor => pairs(&axial),
        }
    }
}

/// Indices of the components of a symmetric tensor.
pub const SYMMETRIC: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

macro_rules! sums {
    ($($(#[$doc:meta])* $name:ident: $spread:ident, $rank:expr;)*) => {
        /// A sum over particles or contacts.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Sum { $($(#[$doc])* $name,)* }

        /// All sums, in the order in which they lie in memory.
        pub const SUMS: &[Sum] = &[$(Sum::$name),*];

        impl Sum {
            /// Function by which the sum is spread.
            #[must_use]
            pub fn spread(self) -> Spread {
                match self { $(Self::$name => Spread::$spread,)* }
            }

            /// How its numbers turn with the axes.
            #[must_use]
            pub fn rank(self) -> Rank {
                match self { $(Self::$name => $rank,)* }
            }
        }
    };
}

sums! {
    /// Powers 0 to 5 of the radius.
    Sizes: Particles, Rank::Scalars(6);
    /// Volume.
    Volume: Particles, Rank::Scalars(1);
    /// Mass m.
    Mass: Particles, Rank::Scalars(1);
    /// Momentum m v.
    Momentum: Particles, Rank::Vector;
    /// Flux of momentum m v (x) v.
    MomentumFlux: Particles, Rank::Symmetric;
    /// Number of particles that it touches.
    Touching: Particles, Rank::Scalars(1);
    /// Angular velocity.
    AngularVelocity: Particles, Rank::Axial;
    /// Spin I w.
    Spin: Particles, Rank::Axial;
    /// Flux of spin I w (x) v.
    SpinFlux: Particles, Rank::AxialTensor;
    /// Rotational energy w . I w / 2.
    SpinEnergy: Particles, Rank::Scalars(1);
    /// Volume of the liquid that it holds.
    Liquid: Particles, Rank::Scalars(1);
    /// Mass of the particles whose displacement is known.
    DisplacedMass: Particles, Rank::Scalars(1);
    /// Their mass times displacement m u.
    Displacement: Particles, Rank::Vector;
    /// Gradient of the density.
    MassGradient: Gradients, Rank::Vector;
    /// Gradient of the momentum density, first index momentum, second direction.
    MomentumGradient: Gradients, Rank::Tensor;
    /// Gradient of the density of displaced mass.
    DisplacedMassGradient: Gradients, Rank::Vector;
    /// Gradient of the density of mass times displacement.
    DisplacementGradient: Gradients, Rank::Tensor;
    /// F (x) l: force and branch vector.
    Stress: Lines, Rank::Tensor;
    /// Number of contacts.
    ContactCount: Lines, Rank::Scalars(1);
    /// n (x) n of the normal.
    Fabric: Lines, Rank::Symmetric;
    /// Half the difference of the couples on both ends (x) l.
    CoupleDifference: Lines, Rank::AxialTensor;
    /// The sum of the couples on both ends (x) l.
    CoupleSum: Moments, Rank::AxialTensor;
    /// Force of walls and fixed particles.
    BoundaryForce: Boundary, Rank::Vector;
    /// Force of particles of other materials.
    Drag: Boundary, Rank::Vector;
    /// Couple of walls and fixed particles.
    BoundaryCouple: Boundary, Rank::Axial;
}

/// Sums that there are, and their places.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    sums: Vec<Sum>,
}

impl Layout {
    /// A layout of these sums, in the order of [`SUMS`] whatever the order here.
    #[must_use]
    pub fn new(wanted: &[Sum]) -> Self {
        Self {
            sums: SUMS
                .iter()
                .copied()
                .filter(|sum| wanted.contains(sum))
                .collect(),
        }
    }

    /// The sums spread in this way.
    pub fn of(&self, spread: Spread) -> impl Iterator<Item = Sum> + '_ {
        self.sums
            .iter()
            .copied()
            .filter(move |sum| sum.spread() == spread)
    }

    /// Whether a sum is there.
    #[must_use]
    pub fn has(&self, sum: Sum) -> bool {
        self.sums.contains(&sum)
    }

    /// The number of numbers per point of a spread.
    #[must_use]
    pub fn stride(&self, spread: Spread) -> usize {
        self.of(spread).map(|sum| sum.rank().components()).sum()
    }

    /// Where a sum begins among the numbers of its spread.
    #[must_use]
    pub fn offset(&self, sum: Sum) -> Option<usize> {
        let mut offset = 0;
        for other in self.of(sum.spread()) {
            if other == sum {
                return Some(offset);
            }
            offset += other.rank().components();
        }
        None
    }

    /// All sums.
    #[must_use]
    pub fn sums(&self) -> &[Sum] {
        &self.sums
    }
}

/// Sums at all points.
#[derive(Debug, Clone, PartialEq)]
pub struct Sums {
    /// Sums, and their places.
    pub layout: Layout,
    /// The number of points.
    pub points: usize,
    /// Numbers of each spread (in the order of [`SPREADS`]), point by point.
    pub values: [Vec<f64>; 5],
}

impl Sums {
    /// Zeros.
    #[must_use]
    pub fn zeros(layout: Layout, points: usize) -> Self {
        let values = SPREADS.map(|spread| vec![0.0; points * layout.stride(spread)]);
        Self {
            layout,
            points,
            values,
        }
    }

    /// The numbers of a sum at a point; empty if the sum is not there.
    #[must_use]
    pub fn at(&self, sum: Sum, point: usize) -> &[f64] {
        let Some(offset) = self.layout.offset(sum) else {
            return &[];
        };
        let stride = self.layout.stride(sum.spread());
        let begin = point * stride + offset;
        &self.values[sum.spread() as usize][begin..begin + sum.rank().components()]
    }

    /// Adds other sums of the same layout and points, times a weight.
    pub fn add(&mut self, other: &Self, weight: f64) {
        debug_assert!(self.layout == other.layout && self.points == other.points);
        for (mine, theirs) in self.values.iter_mut().zip(&other.values) {
            for (mine, theirs) in mine.iter_mut().zip(theirs) {
                *mine += weight * theirs;
            }
        }
    }

    /// Multiplies everything.
    pub fn scale(&mut self, factor: f64) {
        for value in self.values.iter_mut().flatten() {
            *value *= factor;
        }
    }
}
