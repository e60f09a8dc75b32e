//! The fields: names, units, definitions, and how each is computed from sums.
//!
//! This table is the only list of them: help, documentation, tables and pictures follow from it.

mod compute;

use crate::sums::{Spread, Sum};
use compute::Point;

/// Components of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Components {
    /// A number.
    Scalar,
    /// Powers 0 to 5.
    Powers,
    /// A vector.
    Vector,
    /// A symmetric tensor: xx, xy, xz, yy, yz, zz.
    Symmetric,
    /// A tensor: xx, xy, xz, yx, ..., zz.
    Tensor,
}

impl Components {
    /// The number of components.
    #[must_use]
    pub fn count(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Powers | Self::Symmetric => 6,
            Self::Vector => 3,
            Self::Tensor => 9,
        }
    }

    /// Suffixes of the name of the field, for axes of these names.
    #[must_use]
    pub fn suffixes(self, axes: [&str; 3]) -> Vec<String> {
        let pair = |a: usize, b: usize| format!("_{}{}", axes[a], axes[b]);
        match self {
            Self::Scalar => vec![String::new()],
            Self::Powers => (0..6).map(|q| format!("_{q}")).collect(),
            Self::Vector => axes.iter().map(|axis| format!("_{axis}")).collect(),
            Self::Symmetric => crate::sums::SYMMETRIC
                .iter()
                .map(|&(a, b)| pair(a, b))
                .collect(),
            Self::Tensor => (0..9).map(|k| pair(k / 3, k % 3)).collect(),
        }
    }
}

/// A field.
#[derive(Debug, Clone, Copy)]
pub struct Field {
    /// The name in options, tables and files.
    pub name: &'static str,
    /// The SI unit; the definition gives that of powers.
    pub unit: &'static str,
    /// Components of the field.
    pub components: Components,
    /// Definition of the field.
    pub definition: &'static str,
    /// The sums that it needs.
    pub sums: &'static [Sum],
    /// The sum that it is divided by, if it is a quotient.
    per: &'static [Sum],
    compute: fn(&Point, &mut [f64]),
}

impl PartialEq for Field {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Field {
    /// A field by its name.
    #[must_use]
    pub fn by_name(name: &str) -> Option<&'static Self> {
        FIELDS.iter().find(|field| field.name == name)
    }

    /// The sum that it is divided by, if it is a quotient: where that sum is next to nothing, the field is that of single particles.
    #[must_use]
    pub fn divisor(&self) -> Option<Sum> {
        self.per.first().copied()
    }

    /// Whether a component may be of either sign by its nature: those of vectors, and of tensors the ones beside the diagonal; on the diagonal those
    /// of rates of strain. All others are zero or above it where nothing pulls.
    #[must_use]
    pub fn is_signed(&self, component: usize) -> bool {
        let diagonal = match self.components {
            Components::Scalar | Components::Powers => return self.name == "radius_skewness",
            Components::Vector => return true,
            Components::Symmetric => [0, 3, 5].contains(&component),
            Components::Tensor => component.is_multiple_of(4),
        };
        const SQUARES_AND_PRESSURES: [&str; 5] = [
            "momentum_flux",
            "kinetic_stress",
            "contact_stress",
            "stress",
            "fabric",
        ];
        !(diagonal && SQUARES_AND_PRESSURES.contains(&self.name))
    }

    /// Whether it cannot be known without contacts.
    #[must_use]
    pub fn needs_contacts(&self) -> bool {
        let of_contacts = |sum: &Sum| {
            matches!(
                sum.spread(),
                Spread::Lines | Spread::Moments | Spread::Boundary
            ) || *sum == Sum::Touching
        };
        self.sums.iter().any(of_contacts)
    }

    /// Whether it cannot be known without couples of contacts.
    #[must_use]
    pub fn needs_couples(&self) -> bool {
        self.sums.iter().any(|sum| {
            matches!(
                sum,
                Sum::CoupleDifference | Sum::CoupleSum | Sum::BoundaryCouple
            )
        })
    }

    /// Whether it cannot be known without masses.
    #[must_use]
    pub fn needs_mass(&self) -> bool {
        let free = |sum: &Sum| {
            matches!(
                sum,
                Sum::Sizes | Sum::Volume | Sum::Touching | Sum::AngularVelocity | Sum::Liquid
            ) || matches!(
                sum.spread(),
                Spread::Lines | Spread::Moments | Spread::Boundary
            )
        };
        !self.sums.iter().all(free)
    }

    /// Whether it cannot be known without angular velocities.
    #[must_use]
    pub fn needs_rotation(&self) -> bool {
        self.sums.iter().any(|sum| {
            matches!(
                sum,
                Sum::AngularVelocity | Sum::Spin | Sum::SpinFlux | Sum::SpinEnergy
            )
        })
    }

    /// Whether it cannot be known without the liquid of particles.
    #[must_use]
    pub fn needs_liquid(&self) -> bool {
        self.sums.contains(&Sum::Liquid)
    }

    /// Whether it compares a frame with an earlier one.
    #[must_use]
    pub fn needs_displacement(&self) -> bool {
        self.sums
            .iter()
            .any(|sum| matches!(sum, Sum::DisplacedMass | Sum::DisplacedMassGradient))
    }

    /// Whether it needs the gradient of the kernel.
    #[must_use]
    pub fn needs_gradient(&self) -> bool {
        self.sums
            .iter()
            .any(|sum| sum.spread() == Spread::Gradients)
    }

    /// Computes the components at a point of the sums.
    pub fn compute(&self, sums: &crate::sums::Sums, point: usize, dimensions: u8, out: &mut [f64]) {
        (self.compute)(
            &Point {
                sums,
                point,
                dimensions: f64::from(dimensions),
            },
            out,
        );
    }
}

/// The names of the fields that are written by default, those of contacts only where contacts are known.
pub const STANDARD: [&str; 10] = [
    "volume_fraction",
    "density",
    "momentum",
    "velocity",
    "kinetic_stress",
    "contact_stress",
    "stress",
    "pressure",
    "granular_temperature",
    "boundary_force",
];

/// The sums of MercuryCG's standard fields, in the order of its files.
pub const MERCURY_SUMS: [Sum; 7] = [
    Sum::Volume,
    Sum::Mass,
    Sum::Momentum,
    Sum::MomentumFlux,
    Sum::Stress,
    Sum::BoundaryForce,
    Sum::Sizes,
];

use Components::{Powers, Scalar, Symmetric, Tensor, Vector};

macro_rules! fields {
    ($($name:ident $unit:literal $components:ident [$($sum:ident)*] $(per $by:ident)? $definition:literal;)*) => {
        /// All fields.
        pub const FIELDS: &[Field] = &[$(Field {
            name: stringify!($name),
            unit: $unit,
            components: $components,
            definition: $definition,
            sums: &[$(Sum::$sum),*],
            per: &[$(Sum::$by)?],
            compute: compute::$name,
        }),*];
    };
}

fields! {
    number_density "1/m^3" Scalar [Sizes] "sum phi: particles per volume";
    size_moments "m^(q-3)" Powers [Sizes] "sum R^q phi for q = 0 to 5";
    mean_radius "m" Scalar [Sizes] per Sizes "M1 with Mq = sum R^q phi / sum phi";
    radius_variance "m^2" Scalar [Sizes] per Sizes "M2 - M1^2";
    radius_skewness "1" Scalar [Sizes] per Sizes "third central moment of the radii over the 3/2 power of the variance";
    radius_kurtosis "1" Scalar [Sizes] per Sizes "fourth central moment of the radii over the square of the variance";
    volume_fraction "1" Scalar [Volume] "sum V phi: solid volume per volume";
    liquid_fraction "1" Scalar [Liquid] "sum L phi: volume of liquid per volume, L = liquid_volume of a particle: its film, half of each bridge to a particle, all of each to a wall";
    density "kg/m^3" Scalar [Mass] "rho = sum m phi";
    momentum "kg/(m^2 s)" Vector [Momentum] "j = sum m v phi";
    velocity "m/s" Vector [Mass Momentum] per Mass "V = j / rho";
    momentum_flux "Pa" Symmetric [MomentumFlux] "k = sum m v (x) v phi";
    kinetic_stress "Pa" Symmetric [Mass Momentum MomentumFlux] "sigma_k = k - rho V (x) V";
    contact_stress "Pa" Tensor [Stress] "sigma_c = sum F (x) l psi over contacts: F the force on a particle, l from its partner (at a boundary: from the contact point) to it; compression positive";
    stress "Pa" Tensor [Mass Momentum MomentumFlux Stress] "sigma = sigma_c + sigma_k";
    pressure "Pa" Scalar [Mass Momentum MomentumFlux Stress] "p = tr sigma / 3 (2D: / 2)";
    contact_pressure "Pa" Scalar [Stress] "tr sigma_c / 3 (2D: / 2)";
    kinetic_pressure "Pa" Scalar [Mass Momentum MomentumFlux] "tr sigma_k / 3 (2D: / 2)";
    deviatoric_stress "Pa" Scalar [Mass Momentum MomentumFlux Stress] "sqrt(s:s / 2) of s, the symmetric part of sigma without its trace";
    stress_ratio "1" Scalar [Mass Momentum MomentumFlux Stress] per Mass "deviatoric_stress / pressure";
    granular_temperature "m^2/s^2" Scalar [Mass Momentum MomentumFlux] per Mass "T = tr sigma_k / (3 rho) (2D: / (2 rho))";
    kinetic_energy "J/m^3" Scalar [MomentumFlux] "tr k / 2: translational energy per volume";
    fluctuation_energy "J/m^3" Scalar [Mass Momentum MomentumFlux] "tr sigma_k / 2: its part beyond that of the velocity field";
    rotational_energy "J/m^3" Scalar [SpinEnergy] "sum w.I w phi / 2";
    boundary_force "N/m^3" Vector [BoundaryForce] "sum F phi at the contact points with walls and fixed particles: F the force on the flowing particle";
    drag "N/m^3" Vector [Drag] "sum F phi at the contact points with flowing particles of other materials (0 for the mixture)";
    coordination "1" Scalar [Sizes Touching] per Sizes "sum z phi / sum phi, z the number of contacts of a particle with particles";
    contact_density "1/m^3" Scalar [ContactCount] "sum psi: contacts per volume";
    fabric "1" Symmetric [ContactCount Fabric] per ContactCount "sum n (x) n psi / sum psi";
    velocity_gradient "1/s" Tensor [Mass Momentum MassGradient MomentumGradient] per Mass "dV_a/dx_b = (dj_a/dx_b - V_a drho/dx_b) / rho";
    strain_rate "1/s" Symmetric [Mass Momentum MassGradient MomentumGradient] per Mass "D, the symmetric part of the velocity gradient";
    vorticity "1/s" Vector [Mass Momentum MassGradient MomentumGradient] per Mass "curl V";
    shear_rate "1/s" Scalar [Mass Momentum MassGradient MomentumGradient] per Mass "sqrt(2 D':D') of D', the strain rate without its trace";
    inertial_number "1" Scalar [Sizes Volume Mass Momentum MomentumFlux Stress MassGradient MomentumGradient] per Mass "I = shear_rate d sqrt(rho_s / p), d the mean diameter, rho_s = rho / volume fraction";
    angular_velocity "rad/s" Vector [Sizes AngularVelocity] per Sizes "sum w phi / sum phi";
    spin "kg/(m s)" Vector [Spin] "s = sum I w phi: angular momentum about the particles' centres per volume";
    spin_flux "N/m" Tensor [SpinFlux] "sum (I w) (x) v phi";
    couple_stress "N/m" Tensor [CoupleDifference CoupleSum] "mu = sum ((M_P - M_I)/2 psi + (M_P + M_I) psi_1) (x) l, M the torques on both particles";
    boundary_couple "N/m^2" Vector [BoundaryCouple] "sum of the couples of walls and fixed particles phi at the contact points";
    displacement "m" Vector [DisplacedMass Displacement] per DisplacedMass "U = sum m u phi / sum m phi, u the displacement since the reference frame";
    strain "1" Symmetric [DisplacedMass Displacement DisplacedMassGradient DisplacementGradient] per DisplacedMass "symmetric part of dU_a/dx_b";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_defaults_exist() {
        for (k, field) in FIELDS.iter().enumerate() {
            assert!(
                !FIELDS[..k].iter().any(|other| other.name == field.name),
                "{}",
                field.name
            );
            assert!(
                !field.definition.is_empty() && !field.unit.is_empty() && !field.sums.is_empty()
            );
        }
        for name in STANDARD {
            assert!(Field::by_name(name).is_some(), "{name}");
        }
    }

    #[test]
    fn quotients_are_divided_by_a_sum_that_they_need() {
        for field in FIELDS {
            let by = field.divisor();
            assert!(
                by.is_none_or(|sum| field.sums.contains(&sum)),
                "{}",
                field.name
            );
        }
        let divisor = |name| Field::by_name(name).unwrap().divisor();
        assert_eq!(divisor("velocity"), Some(Sum::Mass));
        assert_eq!((divisor("density"), divisor("stress")), (None, None));
    }

    #[test]
    fn signs_follow_from_what_a_component_is() {
        let signed = |name: &str| -> Vec<usize> {
            let field = Field::by_name(name).unwrap();
            (0..field.components.count())
                .filter(|&component| field.is_signed(component))
                .collect()
        };
        assert_eq!(signed("velocity"), [0, 1, 2]);
        // xx, xy, xz, yx, yy, yz, zx, zy, zz.
        assert_eq!(signed("stress"), [1, 2, 3, 5, 6, 7]);
        // xx, xy, xz, yy, yz, zz.
        assert_eq!(signed("fabric"), [1, 2, 4]);
        assert_eq!(signed("strain_rate"), [0, 1, 2, 3, 4, 5]);
        for name in ["density", "pressure", "size_moments", "shear_rate"] {
            assert!(signed(name).is_empty(), "{name}");
        }
    }

    #[test]
    fn needs_follow_from_sums() {
        let field = |name| Field::by_name(name).unwrap();
        assert!(
            !field("volume_fraction").needs_mass() && !field("volume_fraction").needs_contacts()
        );
        assert!(
            field("density").needs_mass()
                && field("contact_stress").needs_contacts()
                && !field("contact_stress").needs_mass()
        );
        assert!(field("coordination").needs_contacts() && field("couple_stress").needs_couples());
        assert!(field("inertial_number").needs_gradient() && field("strain").needs_displacement());
        assert!(field("spin").needs_rotation() && !field("velocity").needs_rotation());
        let wet = field("liquid_fraction");
        assert!(wet.needs_liquid() && !wet.needs_contacts() && !wet.needs_mass());
    }
}
