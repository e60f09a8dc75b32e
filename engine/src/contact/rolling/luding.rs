//! Luding's virtual springs against rolling and torsion.

use mercury_common::scene::{Key, LawKeys, LawPart, Range};

use super::super::{Contact, History, HistoryNumber, SpringRotation, follow};
use super::RollingLaw;
use crate::contact::mixing::Pair;
use crate::contact::parameter::Origin;
use crate::contact::tangential::{FRICTION, STATIC_FRICTION};
use crate::contact::{AnyTangential, PlannedRolling, SpringAndDashpot};
use crate::lanes::{Mask, Real, Vector};

/// One spring of the law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionSpring {
    /// Stiffness, N/m; `None` takes k_t of the contact.
    pub stiffness: Option<f64>,
    /// Dissipation, kg/s.
    pub dissipation: f64,
    /// mu while it yields; 0 switches the spring off.
    pub friction: f64,
    /// mu while it holds.
    pub static_friction: f64,
}

/// Rolling velocity u_r = -l n x dw and torsion velocity u_o = l (n.dw) n stretch springs whose force, cut at mu N, acts as a
/// couple through the lever l (Luding 2008, eqs. 29-34): tau = l n x f_r + l f_o. l = R* (or 2R* for comparisons with older codes).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Luding {
    /// Against rolling.
    pub rolling: FrictionSpring,
    /// Against torsion (twisting about the normal).
    pub torsion: FrictionSpring,
    /// l / R*: 1 or 2.
    pub lever: f64,
    /// How the rolling spring turns with the contact.
    pub rotation: SpringRotation,
}

/// The two springs, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RollingSprings<L = f64> {
    /// In the tangent plane.
    pub rolling: Vector<L>,
    /// Along the normal.
    pub torsion: Vector<L>,
}

impl<L: Real> History<L> for RollingSprings<L> {
    type One = RollingSprings;
    const LENGTH: usize = 6;

    fn columns() -> Vec<HistoryNumber> {
        vec![
            ("m", "rolling spring x"),
            ("m", "rolling spring y"),
            ("m", "rolling spring z"),
            ("m", "torsion spring x"),
            ("m", "torsion spring y"),
            ("m", "torsion spring z"),
        ]
    }

    /// u_r keeps its sign under the swap (both n and dw turn round), u_o changes it.
    fn swapped(self) -> Self {
        Self {
            rolling: self.rolling,
            torsion: -self.torsion,
        }
    }

    fn write(&self, numbers: &mut Vec<L>) {
        numbers.extend(self.rolling.to_array());
        numbers.extend(self.torsion.to_array());
    }

    fn read(numbers: &[L]) -> Self {
        Self {
            rolling: Vector::from_slice(numbers),
            torsion: Vector::from_slice(&numbers[3..]),
        }
    }

    #[inline(always)]
    fn gather(one: impl Fn(usize) -> RollingSprings) -> Self {
        Self {
            rolling: Vector::gather(|k| one(k).rolling),
            torsion: Vector::gather(|k| one(k).torsion),
        }
    }

    #[inline(always)]
    fn lane(&self, k: usize) -> RollingSprings {
        RollingSprings {
            rolling: self.rolling.lane(k),
            torsion: self.torsion.lane(k),
        }
    }
}

impl FrictionSpring {
    /// Force of the spring and its new length, from the length after this step's motion and its velocity.
    #[inline(always)]
    fn force<L: Real>(
        &self,
        spring: Vector<L>,
        velocity: Vector<L>,
        normal_force: L,
        stiffness: L,
    ) -> (Vector<L>, Vector<L>) {
        let damping = velocity * L::splat(self.dissipation);
        let trial = -(spring * stiffness) - damping;
        let limit = normal_force * self.static_friction;
        let squared = trial.length_squared();
        let slides = !squared.at_most(limit * limit);
        if !slides.any() {
            return (trial, spring);
        }
        let force = trial * (normal_force * self.friction / squared.sqrt());
        // Without stiffness there is no spring to set back, only the dashpot.
        let set_back = Vector::select(
            L::ZERO.below(stiffness),
            -(force + damping) / stiffness,
            Vector::ZERO,
        );
        (
            Vector::select(slides, force, trial),
            Vector::select(slides, set_back, spring),
        )
    }
}

impl RollingLaw for Luding {
    type History<L: Real> = RollingSprings<L>;
    const ACTIVE: bool = true;

    fn name(&self) -> &'static str {
        "luding"
    }

    #[inline(always)]
    fn couple<L: Real>(
        &self,
        contact: &Contact<L>,
        normal_force: L,
        tangential_stiffness: L,
        dt: f64,
        history: &mut RollingSprings<L>,
    ) -> Vector<L> {
        let mut couple = Vector::ZERO;
        let idle = normal_force.equals(L::ZERO);
        if idle.all() {
            return couple;
        }
        let before = *history;
        let stiffness_of =
            |spring: &FrictionSpring| spring.stiffness.map_or(tangential_stiffness, L::splat);
        let lever = contact.effective_radius * self.lever;
        let way = L::splat(dt);
        let normal = contact.normal;
        if self.rolling.friction > 0.0 {
            let velocity = contact.in_plane(contact.sliding_normal.cross(contact.spin) * -lever);
            let spring = follow(self.rotation, before.rolling, contact, dt) + velocity * way;
            let stiffness = stiffness_of(&self.rolling);
            let (force, spring) = self
                .rolling
                .force(spring, velocity, normal_force, stiffness);
            history.rolling = spring;
            couple += normal.cross(force) * lever;
        }
        if self.torsion.friction > 0.0 {
            let half = contact.sliding_normal;
            let speed = lever * half.dot(contact.spin);
            let velocity = normal * speed;
            // The half turn about the normal of the half step takes the last normal to the present one.
            let twist = half * (before.torsion.dot(half) * 2.0) - before.torsion;
            let spring = normal * (twist.dot(normal) + speed * dt);
            let stiffness = stiffness_of(&self.torsion);
            let (force, spring) = self
                .torsion
                .force(spring, velocity, normal_force, stiffness);
            history.torsion = spring;
            couple += force * lever;
        }
        if idle.any() {
            couple = Vector::select(idle, Vector::ZERO, couple);
            history.rolling = Vector::select(idle, before.rolling, history.rolling);
            history.torsion = Vector::select(idle, before.torsion, history.torsion);
        }
        couple
    }

    fn energy<L: Real>(&self, tangential_stiffness: L, history: &RollingSprings<L>) -> L {
        let part = |spring: &FrictionSpring, length: Vector<L>| {
            let stiffness = spring.stiffness.map_or(tangential_stiffness, L::splat);
            stiffness * 0.5 * length.length_squared()
        };
        part(&self.rolling, history.rolling) + part(&self.torsion, history.torsion)
    }
}

impl PlannedRolling for Luding {
    const KEYS: &'static LawKeys = &LawKeys {
        parts: &[LawPart::Rolling, LawPart::Torsion],
        name: "luding",
        text: "spring, dashpot and limit as for sliding: Luding (2008)",
        keys: &[
            FRICTION,
            STATIC_FRICTION,
            Key::new("stiffness", "N/m", Range::NonNegative, "k")
                .or_word("default", "k_t of the contact"),
            Key::new("dissipation", "kg/s", Range::NonNegative, "gamma").or(0.0),
        ],
        choices: &[],
    };

    fn needs_tangential_stiffness(pair: &mut Pair<'_>) -> bool {
        [LawPart::Rolling, LawPart::Torsion]
            .into_iter()
            .any(|part| {
                pair.ask(part, Self::KEYS);
                friction(pair).0 > 0.0 && stiffness(pair).is_none()
            })
    }

    fn of_scene(pair: &mut Pair<'_>, tangential: &AnyTangential) -> Option<Option<Self>> {
        let rolling = spring(pair, LawPart::Rolling, tangential);
        let torsion = spring(pair, LawPart::Torsion, tangential);
        let (rolling, torsion) = (rolling?, torsion?);
        if rolling.friction == 0.0 && torsion.friction == 0.0 {
            return Some(None);
        }
        let is_mindlin = matches!(
            tangential,
            AnyTangential::Mindlin(_) | AnyTangential::MindlinRescaled(_)
        );
        let lever = pair.lever();
        pair.ask(LawPart::Rolling, Self::KEYS);
        let origin = Origin::Derived("contact.rolling_lever");
        pair.record_derived("lever", "R*", lever, origin);
        Some(Some(Self {
            rolling,
            torsion,
            lever,
            // Beside Mindlin's law, whose springs are always projected, these are too.
            rotation: if is_mindlin {
                SpringRotation::Project
            } else {
                pair.rotation()
            },
        }))
    }

    fn stiffest(
        &self,
        effective_radius: f64,
        tangential_stiffness: f64,
    ) -> Vec<(f64, SpringAndDashpot, &'static str)> {
        let lever = self.lever * effective_radius;
        let springs = [(&self.rolling, "rolling"), (&self.torsion, "torsion")];
        let active = springs
            .into_iter()
            .filter(|(spring, _)| spring.friction > 0.0);
        active
            .map(|(spring, name)| {
                let stiffest = SpringAndDashpot {
                    stiffness: spring.stiffness.unwrap_or(tangential_stiffness),
                    dissipation: spring.dissipation,
                };
                (lever, stiffest, name)
            })
            .collect()
    }
}

/// The coefficient of the part that is being read: a material without the law has none.
fn friction(pair: &Pair<'_>) -> (f64, Origin) {
    let sides = pair.sides("friction").map(|side| Some(side.unwrap_or(0.0)));
    pair.mix(pair.over("friction"), sides)
        .unwrap_or((0.0, Origin::Default))
}

/// The stiffness of the part that is being read; `None`: k_t of the contact. If one side does not give it, the value of the other
/// side counts.
fn stiffness(pair: &Pair<'_>) -> Option<(f64, Origin)> {
    let replaced = pair.replaced(pair.part());
    if replaced.is_some_and(|values| values.word("stiffness").is_some()) {
        return None;
    }
    pair.mix(pair.over("stiffness"), pair.sides("stiffness"))
}

fn spring(
    pair: &mut Pair<'_>,
    part: LawPart,
    tangential: &AnyTangential,
) -> Option<FrictionSpring> {
    pair.ask(part, Luding::KEYS);
    let (friction, origin) = friction(pair);
    if friction == 0.0 {
        return Some(FrictionSpring {
            stiffness: None,
            dissipation: 0.0,
            friction: 0.0,
            static_friction: 0.0,
        });
    }
    pair.record("friction", friction, origin);
    let static_friction = pair.static_friction(friction)?;
    let stiffness = stiffness(pair);
    let is_absent = match (&stiffness, tangential) {
        (Some((k, _)), _) => *k == 0.0,
        (None, AnyTangential::None) => true,
        (None, AnyTangential::Linear(law)) => law.stiffness == 0.0,
        (None, _) => false,
    };
    if is_absent {
        let table = part.word();
        let message = format!(
            "{table}.stiffness of the contacts of {} is missing: the pair has no tangential stiffness to take it from",
            pair.name()
        );
        let help = format!("give {table} = {{ stiffness = ... }} in N/m, or a tangential law");
        pair.error(message, help);
        return None;
    }
    match &stiffness {
        Some((k, origin)) => pair.record("stiffness", *k, origin.clone()),
        None => pair.record_word("stiffness", "k_t of the contact", Origin::Default),
    }
    let dissipation = pair.number("dissipation")?;
    Some(FrictionSpring {
        stiffness: stiffness.map(|(k, _)| k),
        dissipation,
        friction,
        static_friction,
    })
}
