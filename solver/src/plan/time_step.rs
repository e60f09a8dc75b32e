//! The time step: durations of contacts, limits of the integrator, and the step of a scene.

use super::pair::PairPlan;
use super::usage::MaterialUse;
use mercury_engine::bodies::Clump;
use mercury_engine::contact::parameter::short;
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{PlannedNormal, SpringAndDashpot};
use mercury_engine::state::{inverse_inertia_factor, volume};

/// Steps per contact of the automatic step.
const STEPS_PER_CONTACT: f64 = 50.0;
/// Automatic steps per critical step, at least.
const STEPS_PER_CRITICAL: f64 = 5.0;
/// A given step is warned about above this part of the shortest contact.
pub(super) const WARNED_PART: f64 = 0.2;
/// A step is refused above this part of the critical one.
pub(super) const REFUSED_PART: f64 = 0.9;

/// The step of a plan and the values that it was compared with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StepPlan {
    /// Whether the plan chose it.
    pub is_automatic: bool,
    /// The automatic step where another one was given and something can touch, s.
    pub automatic: Option<f64>,
    /// Why it is what it is, in a sentence.
    pub reason: String,
    /// Reference speed, m/s.
    pub reference_speed: f64,
    /// Where the reference speed comes from.
    pub reference_speed_reason: String,
    /// The shortest contact, if anything can meet.
    pub contact: Option<Limit>,
    /// The critical step of the stiffest contact, if anything can meet.
    pub critical: Option<Limit>,
    /// Smallest Rayleigh time of the Hertz materials with E and nu, s.
    pub rayleigh: Option<f64>,
}

/// A time and the contact that sets it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Limit {
    /// s
    pub time: f64,
    /// Contact, in words.
    pub of: String,
    /// Part of its law that sets a critical step.
    pub part: &'static str,
}

impl Limit {
    /// How a critical step is made longer.
    pub(super) fn way_out(&self) -> &'static str {
        match self.part {
            LIQUID => {
                "raise `roughness`, the least gap of the viscous force, or lower `viscosity`: a softer contact does not help"
            }
            ADHESION => {
                "soften the adhesion: a larger `separation`, or a smaller `stiffness`; `range` has to stay below the size of a grain"
            }
            _ => "soften the contact",
        }
    }
}

/// The part of a law whose dashpots are films of liquid.
const LIQUID: &str = "liquid";

/// The part of a law that pulls over a gap.
const ADHESION: &str = "adhesion";

/// Wet neighbours of a grain: as many as equal spheres about one can be.
const NEIGHBOURS: f64 = 12.0;

/// Two bodies that meet, at their smallest sizes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meeting {
    /// m*, kg.
    pub effective_mass: f64,
    /// R*, m.
    pub effective_radius: f64,
    /// 1/I_A + 1/I_B, 1/(kg m^2).
    pub inverse_inertia: f64,
    /// I/(m R^2) inverted: 5/2 for spheres, 2 for discs.
    pub inertia_factor: f64,
    /// The lighter of both masses, kg.
    pub lighter: f64,
    /// Whether the other one is a particle, of which a grain may have many around it.
    pub among_particles: bool,
}

impl Meeting {
    /// A body of radius (m) and mass (kg) with another one, which is infinitely heavy if its mass is infinite and flat if
    /// its radius is.
    #[must_use]
    pub fn new(one: (f64, f64), other: (f64, f64), dimensions: u8) -> Self {
        let factor = inverse_inertia_factor(dimensions);
        let inertia = |(radius, mass): (f64, f64)| {
            if mass.is_finite() {
                factor / (mass * radius * radius)
            } else {
                0.0
            }
        };
        Self {
            effective_mass: 1.0 / (1.0 / one.1 + 1.0 / other.1),
            effective_radius: 1.0 / (1.0 / one.0 + 1.0 / other.0),
            inverse_inertia: inertia(one) + inertia(other),
            inertia_factor: factor,
            lighter: one.1.min(other.1),
            among_particles: other.0.is_finite(),
        }
    }

    /// Duration of a head-on contact at `speed` (m/s), s; overdamped: that without damping.
    #[must_use]
    pub fn duration(&self, law: &AnyPairLaw, speed: f64) -> f64 {
        law.normal
            .duration(self.effective_mass, self.effective_radius, speed)
    }

    /// The largest step (s) at which the integrator bears this contact, and which of its springs sets it. `bounded`: springs
    /// count whose instability friction bounds.
    ///
    /// Springs of the contact: along the normal with the mass m*; in the tangent plane with 2/7 m* (discs 1/3), as the bodies
    /// also turn; against rolling and torsion with the lever l and the two inertias; each where it is stiffest in an impact at
    /// `speed` (m/s). Films of liquid hold a grain on all sides for long, so their dashpots count for all neighbours: of N around a
    /// grain of mass m, evenly spread and at rest, those along the normals add up to N/3, those in the tangent planes to 2N/3, and
    /// against its spin to 5/2 times as much (from I = 2/5 m R^2).
    ///
    /// Dry cohesion counts where its force changes most steeply; that of `jkr` is one with the normal force.
    #[must_use]
    pub fn critical_step(
        &self,
        law: &AnyPairLaw,
        speed: f64,
        bounded: bool,
    ) -> (f64, &'static str) {
        let (mass, radius) = (self.effective_mass, self.effective_radius);
        let (normal, contact_radius) = law.normal.stiffest(mass, radius, speed);
        let dry = law.adhesion.dry();
        let cohesion = dry.and_then(|dry| dry.stiffest(&law.normal, mass, radius, speed));
        let (normal, contact_radius) = match cohesion {
            Some(joined) if joined.1 > 0.0 => joined,
            _ => (normal, contact_radius),
        };
        let rates = (normal.stiffness / mass, normal.dissipation / mass);
        let mut least = (bearable(rates.0, rates.1), "normal");
        let mut add = |spring: SpringAndDashpot, inverse_mass: f64, part: &'static str| {
            let rates = (
                spring.stiffness * inverse_mass,
                spring.dissipation * inverse_mass,
            );
            let time = bearable(rates.0, rates.1);
            if time < least.0 {
                least = (time, part);
            }
        };
        // Beside a law without contact radius of its own: at a tenth of the radius.
        let contact_radius = if contact_radius == 0.0 {
            radius * 0.1f64.sqrt()
        } else {
            contact_radius
        };
        let tangential = law.tangential.stiffest(mass, contact_radius);
        if let Some(tangential) = tangential
            && (bounded || !tangential.is_bounded)
        {
            let inverse_mass = (1.0 + self.inertia_factor) / mass;
            add(tangential.spring, inverse_mass, "tangential");
        }
        let tangential_stiffness = tangential.map_or(0.0, |tangential| tangential.full);
        if let Some((spring, 0.0)) = cohesion {
            add(spring, 1.0 / mass, ADHESION);
        }
        if let Some(liquid) = law.adhesion.liquid() {
            let [normal_film, tangential_film] = liquid.most_viscous(radius);
            let mut film = SpringAndDashpot {
                stiffness: 0.0,
                dissipation: normal_film,
            };
            if liquid.lubrication_in_contact {
                film.stiffness = normal.stiffness;
                film.dissipation += normal.dissipation;
            }
            add(film, 1.0 / mass, LIQUID);
            let dashpot = |dissipation: f64| SpringAndDashpot {
                stiffness: 0.0,
                dissipation,
            };
            let film = dashpot(tangential_film);
            add(film, (1.0 + self.inertia_factor) / mass, LIQUID);
            if self.among_particles {
                let along = NEIGHBOURS / 3.0;
                let all = dashpot(along * (normal_film + 2.0 * tangential_film));
                add(all, 1.0 / self.lighter, LIQUID);
                let turning = dashpot(2.0 * along * self.inertia_factor * tangential_film);
                add(turning, 1.0 / self.lighter, LIQUID);
            }
        }
        for (lever, spring, part) in law.rolling.stiffest(radius, tangential_stiffness) {
            add(spring, lever * lever * self.inverse_inertia, part);
        }
        least
    }
}

/// The largest stable step (s) of x'' = -w^2 x - c x', `squared` = w^2 (1/s^2) and `rate` = c (1/s), where forces see the
/// velocity of half a step before.
///
/// With h the step, one step has the characteristic polynomial z^2 - (2 - w^2 h^2 - c h) z + (1 - c h); its roots stay within
/// the unit circle for w^2 h^2 + 2 c h < 4: h = 2/w (sqrt(1 + zeta^2) - zeta), zeta = c/2w; 2/w without damping.
pub(super) fn bearable(squared: f64, rate: f64) -> f64 {
    // In the form that also holds for w = 0 (2/c) and without either (infinite).
    4.0 / (rate + (rate * rate + 4.0 * squared).sqrt())
}

/// Times that bound the step.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Limits {
    /// The shortest contact.
    pub contact: Option<Limit>,
    /// The least critical step.
    pub critical: Option<Limit>,
    /// The least critical step of those whose instability nothing bounds.
    pub unbounded: Option<Limit>,
}

/// The shortest contact and the least critical steps over all planned pairs at their smallest sizes.
#[must_use]
pub(super) fn limits(
    pairs: &[PairPlan],
    uses: &[MaterialUse],
    clumps: &[Clump],
    densities: &[f64],
    dimensions: u8,
    speed: f64,
) -> Limits {
    let mut limits = Limits::default();
    let keep =
        |slot: &mut Option<Limit>, time: f64, part: &'static str, of: &dyn Fn() -> String| {
            if slot.as_ref().is_none_or(|least| time < least.time) {
                let of = of();
                *slot = Some(Limit { time, of, part });
            }
        };
    for pair in pairs {
        for (meeting, kind) in meetings(pair, uses, clumps, densities, dimensions) {
            let [a, b] = &pair.names;
            let words = || match kind {
                LimitKind::Wall => format!("{a}-{b}, at a wall"),
                LimitKind::Vertex => format!("{a}-{b}, at a vertex of a sheet"),
                LimitKind::Particles => format!("{a}-{b}, particles"),
                LimitKind::Fixed => format!("{a}-{b}, at a fixed particle"),
            };
            let time = meeting.duration(&pair.law, speed);
            keep(&mut limits.contact, time, "", &words);
            let (time, part) = meeting.critical_step(&pair.law, speed, true);
            keep(&mut limits.critical, time, part, &|| {
                format!("{}, {part}", words())
            });
            let (time, part) = meeting.critical_step(&pair.law, speed, false);
            keep(&mut limits.unbounded, time, part, &|| {
                format!("{}, {part}", words())
            });
        }
    }
    limits
}

#[derive(Clone, Copy)]
enum LimitKind {
    Particles,
    Fixed,
    Wall,
    Vertex,
}

/// Every way in which the smallest bodies of a pair of materials can meet.
fn meetings(
    pair: &PairPlan,
    uses: &[MaterialUse],
    clumps: &[Clump],
    densities: &[f64],
    dimensions: u8,
) -> Vec<(Meeting, LimitKind)> {
    let [a, b] = pair.materials.map(|material| material.index());
    // Radius and mass of the smallest sphere, and of each clump: its smallest pebble with the mass that its contacts feel.
    let free = |material: usize| {
        let used = &uses[material];
        let radius = used.smallest_sphere;
        let sphere = (radius, densities[material] * volume(radius, dimensions));
        let sphere = radius.is_finite().then_some(sphere);
        let bodies = used.free_clumps.iter().map(|&(index, scale)| {
            let clump = &clumps[index];
            let radius = clump.pebble_radii().0 * scale;
            (radius, clump.contact_mass * (scale * scale * scale))
        });
        sphere.into_iter().chain(bodies).collect::<Vec<_>>()
    };
    let mut found = Vec::new();
    let mut add = |one, other, kind| found.push((Meeting::new(one, other, dimensions), kind));
    let orders: &[[usize; 2]] = if a == b { &[[a, b]] } else { &[[a, b], [b, a]] };
    if (a == b && uses[a].free >= 2) || (a != b && uses[a].free > 0 && uses[b].free > 0) {
        for one in free(a) {
            for other in free(b) {
                add(one, other, LimitKind::Particles);
            }
        }
    }
    for &[one, other] in orders {
        for body in free(one) {
            if uses[other].fixed > 0 {
                let fixed = (uses[other].smallest_fixed, f64::INFINITY);
                add(body, fixed, LimitKind::Fixed);
            }
            if uses[other].walls {
                add(body, (f64::INFINITY, f64::INFINITY), LimitKind::Wall);
            }
            if let Some(mass) = uses[other].lightest_vertex {
                add(body, (f64::INFINITY, mass), LimitKind::Vertex);
            }
        }
    }
    found
}

/// An interval below this part of the step that the contacts allow draws a warning.
const SHORT_INTERVAL: f64 = 0.5;

/// The automatic step where no output needs a shorter one, s.
pub(super) fn bearable_step(contact: &Limit, critical: &Limit) -> f64 {
    let by_stability = critical.time / STEPS_PER_CRITICAL;
    (contact.time / STEPS_PER_CONTACT).min(by_stability)
}

/// The automatic step (s): 1/50 of the shortest contact, rounded down so that it divides `interval` (s); and why. A warning if that makes it much shorter.
///
/// Where a dashpot or a spring beside the normal one is so stiff that this is more than a fifth of the critical step, it is
/// a fifth of the critical step.
#[must_use]
pub(super) fn automatic(
    contact: &Limit,
    critical: &Limit,
    interval: f64,
) -> (f64, String, Option<String>) {
    let by_contact = contact.time / STEPS_PER_CONTACT;
    let by_stability = critical.time / STEPS_PER_CRITICAL;
    let (part, limit, what) = if by_contact <= by_stability {
        (STEPS_PER_CONTACT, contact, "shortest contact")
    } else {
        (STEPS_PER_CRITICAL, critical, "critical step")
    };
    automatic_part(limit, part, what, interval)
}

/// The step that is a part of a limit, rounded down so that it divides `interval` (s); as [`automatic`].
#[must_use]
pub(super) fn automatic_part(
    limit: &Limit,
    part: f64,
    what: &str,
    interval: f64,
) -> (f64, String, Option<String>) {
    let wanted = limit.time / part;
    // A hair of slack, so that a quotient that is whole but for round-off does not cost a step.
    let parts = (interval / wanted - 1e-9).ceil().max(1.0);
    let allowed = format!(
        "1/{part} of the {what}, {} s ({})",
        short(limit.time),
        limit.of
    );
    if parts == 1.0 && interval < wanted * (1.0 - 1e-9) {
        let times = short((wanted / interval * 10.0).round() / 10.0);
        let warning = format!(
            "output.interval = {} s decides the time step: {allowed}, would be {times} times as long, and the run as much shorter",
            short(interval)
        );
        let reason = format!("output.interval, which is shorter than {allowed}");
        return (
            interval,
            reason,
            (interval < SHORT_INTERVAL * wanted).then_some(warning),
        );
    }
    let reason = format!("{allowed}, rounded down to 1/{parts} of output.interval");
    (interval / parts, reason, None)
}

/// Number of steps of `step` (s) that reach `end` (s): ceil(end/step - 1e-6).
#[must_use]
pub(super) fn steps(end: f64, step: f64) -> f64 {
    (end / step - 1e-6).ceil().max(1.0)
}
