//! Forces and couples between two touching bodies.
//!
//! A contact law has up to five parts, evaluated in this order: the normal force; dry cohesion; sliding
//! friction, which is limited by the normal force; rolling and torsion resistance, which are couples.
//! Each part is a pure function of the geometry, the relative motion and what the contact remembers.

mod cohesion;
mod normal;
mod resistance;
mod tangential;

use glam::DVec3;

pub use cohesion::{Branch, Cohesion};
pub use normal::{LinearDamping, Normal};
pub use resistance::{Resistance, ResistanceStiffness};
pub use tangential::{LoadHistory, Tangential};

/// The five parts of a contact law, with the parameters of one pair of materials.
#[derive(Debug, Clone, Copy)]
pub struct ContactLaw {
    /// Repulsion along the normal.
    pub normal: Normal,
    /// Sliding friction.
    pub tangential: Tangential,
    /// Resistance against rolling over each other.
    pub rolling: Option<Resistance>,
    /// Resistance against spinning about the normal.
    pub torsion: Option<Resistance>,
    /// Attraction without liquid.
    pub cohesion: Cohesion,
}

impl ContactLaw {
    /// A law without friction.
    pub fn frictionless(normal: Normal) -> Self {
        Self {
            normal,
            tangential: Tangential::None,
            rolling: None,
            torsion: None,
            cohesion: Cohesion::None,
        }
    }
}

/// How a tangential spring follows the contact as it turns in space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TangentialHistory {
    /// Project it on the new tangent plane, give it back its length, then let it grow.
    #[default]
    Project,
    /// MercuryDPM's linear law: turn it by an infinitesimal rotation with the pair; not at all at a
    /// wall. The Mindlin law and its rolling always project.
    Incremental,
}

/// The time of the normal against which sliding, rolling and torsion are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SlidingNormal {
    /// The middle of the step, as of the velocities. Springs are turned from the last normal to the present one by the
    /// rotation that the normal of the middle halves.
    #[default]
    HalfStep,
    /// The end of the step.
    Step,
}

/// The lever that turns relative rotation into a rolling or torsion displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RollingLever {
    /// The effective radius R* (Luding 2008).
    #[default]
    EffectiveRadius,
    /// 2 R*, as MercuryDPM's `Friction`.
    EffectiveDiameter,
}

/// How friction is kept within Coulomb's limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CoulombLimits {
    /// The elastic force decides whether it slides; then there is no viscous one. While it sticks the
    /// sum of both is bounded. Only a force that presses, F_n > 0, makes friction.
    #[default]
    Bounded,
    /// Mindlin: the elastic force; damping comes on top while the contact sticks, and vanishes in
    /// sliding. The linear law limits the sum. |F_n| makes friction.
    Elastic,
    /// Elastic plus viscous force, in both laws. |F_n| makes friction.
    Total,
}

/// Choices among published variants; the defaults are the physically right ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Conventions {
    /// How tangential springs turn with the contact.
    pub tangential_history: TangentialHistory,
    /// Lever of rolling and torsion.
    pub rolling_lever: RollingLever,
    /// True: damping may not make a contact pull. Cohesion of the plastic law still pulls.
    pub clamp_tension: bool,
    /// Force that Coulomb's limit applies to.
    pub coulomb_limits: CoulombLimits,
    /// The normal against which sliding is measured.
    pub sliding_normal: SlidingNormal,
    /// True: springs grow by one step in the force evaluation before the first step.
    pub startup_increment: bool,
}

/// Geometry and relative motion of a contact (A, B).
#[derive(Debug, Clone, Copy)]
pub struct Kinematics {
    /// Unit normal n, from B to A.
    pub normal: DVec3,
    /// Overlap δ \[m\]; negative across a gap.
    pub overlap: f64,
    /// From the centre of A to the contact point: −(R_A − δ/2) n \[m\].
    pub arm_a: DVec3,
    /// From the centre of B to the contact point: (R_B − δ/2) n; zero for a wall \[m\].
    pub arm_b: DVec3,
    /// Velocity u of A relative to B at the contact point \[m/s\].
    pub relative_velocity: DVec3,
    /// ω_A − ω_B \[rad/s\].
    pub relative_spin: DVec3,
    /// The normal at the time of the velocities; the same as `normal` by [`SlidingNormal::Step`].
    pub sliding_normal: DVec3,
    /// Velocity of A relative to B at the contact point as it was at that time \[m/s\].
    pub sliding_velocity: DVec3,
    /// For two particles: distance of the centres at that time \[m\].
    pub sliding_distance: f64,
    /// For two particles: velocity of centre A relative to centre B \[m/s\].
    pub pair: Option<DVec3>,
    /// m* = 1/(1/m_A + 1/m_B), with 1/m = 0 for walls and fixed particles \[kg\].
    pub effective_mass: f64,
    /// R* = 1/(1/R_A + 1/R_B), with 1/R = 0 for walls \[m\].
    pub effective_radius: f64,
}

impl Kinematics {
    /// u_n = u·n, positive when the bodies separate \[m/s\].
    pub fn normal_velocity(&self) -> f64 {
        self.relative_velocity.dot(self.normal)
    }

    /// u_t = u − u_n n \[m/s\], with the velocity and the normal against which sliding is measured, then laid into the present
    /// tangent plane.
    pub fn tangential_velocity(&self) -> DVec3 {
        let half = self.sliding_normal;
        let sliding = self.sliding_velocity - self.sliding_velocity.dot(half) * half;
        self.laid_into_plane(sliding)
    }

    /// A vector without its part along the normal.
    pub fn laid_into_plane(&self, vector: DVec3) -> DVec3 {
        vector - vector.dot(self.normal) * self.normal
    }

    /// Radius a = √(R* δ) of the Hertzian contact area \[m\].
    pub fn contact_radius(&self) -> f64 {
        (self.effective_radius * self.overlap).sqrt()
    }
}

/// Memory of a contact. It begins with zeros when two bodies touch and is lost when they part.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct History {
    /// Sliding spring ξ \[m\]; with [`LoadHistory::Rescale`] the elastic force on A \[N\] instead.
    pub sliding: DVec3,
    /// Contact radius of the last evaluation \[m\]; only with [`LoadHistory::Rescale`].
    pub contact_radius: f64,
    /// Rolling spring \[m\].
    pub rolling: DVec3,
    /// Torsion spring, along the normal \[m\].
    pub torsion: DVec3,
    /// Largest overlap δ_m so far \[m\]; only with [`Normal::Plastic`].
    pub largest_overlap: f64,
    /// Whether a touch holds the two together across a gap; only with [`Cohesion`].
    pub touched: bool,
}

/// Result of a contact law.
#[derive(Debug, Clone, Copy, Default)]
pub struct ContactForce {
    /// Force on A, B feels the opposite \[N\].
    pub force: DVec3,
    /// Couple on A besides the moment of the force, B feels the opposite \[N m\].
    pub couple: DVec3,
    /// Elastic plus viscous normal force F_n, positive when it repels \[N\].
    pub normal_force: f64,
    /// Tangential part of `force` \[N\].
    pub tangential_force: DVec3,
    /// Energy that the springs store \[J\].
    pub elastic_energy: f64,
}

/// Evaluates a contact law; the springs in `history` grow over `spring_time` \[s\].
pub fn contact_force(
    law: &ContactLaw,
    conventions: &Conventions,
    kinematics: &Kinematics,
    history: &mut History,
    spring_time: f64,
) -> ContactForce {
    let neck = law.cohesion.neck_radius(kinematics);
    if kinematics.overlap <= 0.0 && neck.is_none() {
        // Springs end with the touch.
        let (pull, energy) = law.cohesion.pull(kinematics);
        *history = History {
            touched: history.touched,
            ..History::default()
        };
        return ContactForce {
            force: -pull * kinematics.normal,
            elastic_energy: energy,
            ..ContactForce::default()
        };
    }
    history.touched = true;
    let mut kinematics = *kinematics;
    let (normal_force, load, normal_energy) = match neck {
        // Friction and rolling act on the area of the neck, a = √(R* δ) of Hertz' contact.
        Some(a) => {
            let joined = law.cohesion.joined(a, &law.normal, &kinematics);
            kinematics.overlap = a * a / kinematics.effective_radius;
            joined
        }
        None => {
            let (force, energy) = law.normal.evaluate(
                &kinematics,
                conventions.clamp_tension,
                &mut history.largest_overlap,
            );
            let (pull, of_pull) = law.cohesion.pull(&kinematics);
            (force - pull, force, energy + of_pull)
        }
    };
    let kinematics = &kinematics;
    let mut response = ContactForce {
        force: normal_force * kinematics.normal,
        normal_force,
        elastic_energy: normal_energy,
        ..ContactForce::default()
    };
    let (tangential_force, energy) =
        law.tangential
            .evaluate(kinematics, conventions, load, history, spring_time);
    response.tangential_force = tangential_force;
    response.force += tangential_force;
    response.elastic_energy += energy;

    // Rolling takes the magnitude of the normal force, also where damping makes it pull.
    let pressure = load.abs();
    if pressure == 0.0 {
        return response;
    }

    let lever = match conventions.rolling_lever {
        RollingLever::EffectiveRadius => kinematics.effective_radius,
        RollingLever::EffectiveDiameter => 2.0 * kinematics.effective_radius,
    };
    let sliding_stiffness = law.tangential.stiffness(kinematics);
    if let Some(rolling) = &law.rolling {
        let follows = law.tangential.history_of_springs(conventions);
        let (couple, energy) = rolling.rolling_couple(
            kinematics,
            follows,
            lever,
            sliding_stiffness,
            pressure,
            &mut history.rolling,
            spring_time,
        );
        response.couple += couple;
        response.elastic_energy += energy;
    }
    if let Some(torsion) = &law.torsion {
        let (couple, energy) = torsion.torsion_couple(
            kinematics,
            lever,
            sliding_stiffness,
            pressure,
            &mut history.torsion,
            spring_time,
        );
        response.couple += couple;
        response.elastic_energy += energy;
    }
    response
}
