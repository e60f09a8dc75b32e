//! Every law gives in each lane the bits that it gives alone, rare cases beside common ones included.

use std::collections::HashSet;

use proptest::prelude::*;
use proptest::strategy::ValueTree;

use super::rolling::FrictionSpring;
use super::{
    Action, AdhesionForce, AdhesionLaw, AnyNormal, AnyRolling, AnyTangential, Contact,
    CoulombLimits, Hertz, Histories, History, HistoryNumber, Linear, LinearFriction, Luding,
    Mindlin, MindlinRescaled, NoAdhesion, NoEvents, NoFriction, NoRolling, NormalForce, NormalLaw,
    PairLaw, PlannedNormal as _, RollingLaw, Scale, SpringRotation, TangentialLaw,
};
use crate::lanes::{Lanes, Mask, Real, Vector};

const STEP: f64 = 1e-5;

/// One contact alone with the numbers of its history.
#[derive(Debug, Clone)]
struct Alone {
    contact: Contact,
    /// Numbers of springs along three directions and beside them, enough for every law; each law takes what it needs.
    memory: Memory,
}

/// State before the step, from which the history of any law is made.
#[derive(Debug, Clone)]
struct Memory {
    /// Over the present overlap.
    largest_overlap: f64,
    /// Sliding, rolling and torsion spring, m.
    springs: [Vector; 3],
    /// Over the present contact radius.
    contact_radius: f64,
}

impl Memory {
    /// The numbers of the history of a contact with this law.
    fn numbers<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw>(
        &self,
        law: &PairLaw<N, T, R, A>,
        contact: &Contact,
    ) -> Vec<f64> {
        // Where the law is chosen at run time, its history names the law after the first evaluation.
        let mut history = Histories::<N, T, R, A>::default();
        law.act(contact, STEP, &mut history);
        [
            self.of_part(&history.0, law.normal.columns(), contact),
            self.of_part(&history.1, law.tangential.columns(), contact),
            self.of_part(&history.2, law.rolling.columns(), contact),
            self.of_part(&history.3, law.adhesion.columns(), contact),
        ]
        .concat()
    }

    /// The numbers of one part's history, whose columns are known by their text.
    fn of_part<H: History>(
        &self,
        history: &H,
        columns: Vec<HistoryNumber>,
        contact: &Contact,
    ) -> Vec<f64> {
        let component = |text: &str, vector: Vector| match text.as_bytes()[text.len() - 1] {
            b'x' => vector.x,
            b'y' => vector.y,
            _ => vector.z,
        };
        let number = |(unit, text): (&str, &str)| match text {
            // Every second contact is bonded.
            "bond" => f64::from(u8::from(self.largest_overlap >= 1.0)),
            "largest overlap so far" => self.largest_overlap * contact.overlap,
            "contact radius it belongs to" => self.contact_radius * contact.contact_radius(),
            _ if text.starts_with("tangential") => component(text, self.springs[0]),
            // At the stiffness of a softer moment.
            _ if unit == "N" => -1e4 * component(text, self.springs[0]),
            _ if text.starts_with("rolling") => component(text, self.springs[1]),
            _ => component(text, self.springs[2]),
        };
        let own: Vec<f64> = columns.into_iter().map(number).collect();
        let mut numbers = Vec::new();
        history.write(&mut numbers);
        let first = usize::from(numbers.len() > own.len());
        numbers[first..first + own.len()].copy_from_slice(&own);
        numbers
    }
}

/// Bits that may be compared: the bits of a NaN are not specified.
fn bits(number: f64) -> u64 {
    if number.is_nan() {
        u64::MAX
    } else {
        number.to_bits()
    }
}

/// Everything that a law answers, number by number: force, tangential force, couple, normal force, history, energies.
fn answers<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw, L: Real>(
    law: &PairLaw<N, T, R, A>,
    contact: &Contact<L>,
    numbers: &[L],
) -> Vec<L> {
    let mut history = <Histories<N, T, R, A, L> as History<L>>::read(numbers);
    let Action {
        force,
        tangential,
        couple,
        normal,
        adhesion,
    } = law.act(contact, STEP, &mut history);
    let mut answers = [force, tangential, couple].map(Vector::to_array).concat();
    answers.extend([normal.elastic, normal.viscous]);
    history.write(&mut answers);
    answers.push(law.energy(contact, &history));
    answers.push(law.friction_energy(contact, &history));
    answers.extend([adhesion.normal.elastic, adhesion.normal.viscous]);
    let swapped = history.swapped();
    swapped.write(&mut answers);
    // The pair again, as far apart as it overlapped.
    let mut apart = *contact;
    apart.overlap = -contact.overlap;
    let mut history = <Histories<N, T, R, A, L> as History<L>>::read(numbers);
    let Action {
        force,
        couple,
        adhesion,
        ..
    } = law.act_apart(&apart, STEP, &mut history);
    answers.extend([force, couple].map(Vector::to_array).concat());
    answers.extend([adhesion.normal.elastic, adhesion.normal.viscous]);
    answers.push(law.adhesion.energy(&apart, &history.3));
    history.write(&mut answers);
    answers
}

/// The contacts side by side.
fn in_lanes<const N: usize>(alone: &[Alone; N]) -> Contact<Lanes<N>> {
    let number = |of: fn(&Contact) -> f64| Lanes::from_lanes(|k| of(&alone[k].contact));
    let vector = |of: fn(&Contact) -> Vector| {
        let [x, y, z] =
            [0, 1, 2].map(|axis| Lanes::from_lanes(|k| of(&alone[k].contact).to_array()[axis]));
        Vector::new(x, y, z)
    };
    Contact {
        normal: vector(|contact| contact.normal),
        distance: number(|contact| contact.distance),
        overlap: number(|contact| contact.overlap),
        effective_radius: number(|contact| contact.effective_radius),
        effective_mass: number(|contact| contact.effective_mass),
        normal_velocity: number(|contact| contact.normal_velocity),
        tangential_velocity: vector(|contact| contact.tangential_velocity),
        sliding_normal: vector(|contact| contact.sliding_normal),
        sliding_distance: number(|contact| contact.sliding_distance),
        centre_velocity: vector(|contact| contact.centre_velocity),
        spin: vector(|contact| contact.spin),
    }
}

/// Compares the law in `N` lanes with the law alone.
fn compare<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw, const W: usize>(
    law: &PairLaw<N, T, R, A>,
    alone: &[Alone; W],
) -> Result<(), TestCaseError> {
    let numbers = alone
        .each_ref()
        .map(|one| one.memory.numbers(law, &one.contact));
    let side_by_side: Vec<Lanes<W>> = (0..numbers[0].len())
        .map(|number| Lanes::from_lanes(|k| numbers[k][number]))
        .collect();
    let together = answers(law, &in_lanes(alone), &side_by_side);
    for (k, one) in alone.iter().enumerate() {
        let expected = answers(law, &one.contact, &numbers[k]);
        prop_assert_eq!(expected.len(), together.len());
        for (place, (expected, lanes)) in expected.iter().zip(&together).enumerate() {
            prop_assert_eq!(
                bits(*expected),
                bits(lanes.lane(k)),
                "answer {} in lane {} of {}: {} alone, {} in lanes, {:?} {:?}",
                place,
                k,
                W,
                expected,
                lanes.lane(k),
                law,
                one
            );
        }
    }
    Ok(())
}

/// Compares 2, 4 and 8 lanes.
fn compare_all<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw>(
    law: PairLaw<N, T, R, A>,
    alone: &[Alone; 8],
) -> Result<(), TestCaseError> {
    compare(&law, &alone.clone())?;
    for four in alone.chunks_exact(4) {
        let four: &[Alone; 4] = four.try_into().expect("a chunk of four");
        compare(&law, four)?;
    }
    for two in alone.chunks_exact(2) {
        let two: &[Alone; 2] = two.try_into().expect("a chunk of two");
        compare(&law, two)?;
    }
    Ok(())
}

/// A bridge that forms on contact: it pulls with one force while the two touch, with less the wider the gap, and
/// presses the surfaces together by as much; it resists their spin.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bridge {
    /// N.
    pull: f64,
    /// m.
    range: f64,
    /// kg/s.
    viscosity: f64,
    /// kg m^2/s.
    twist: f64,
}

/// 1 once they have touched.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Bond<L>(L);

impl<L: Real> History<L> for Bond<L> {
    type One = Bond<f64>;
    const LENGTH: usize = 1;
    fn columns() -> Vec<HistoryNumber> {
        vec![("1", "bond")]
    }
    fn swapped(self) -> Self {
        self
    }
    fn write(&self, numbers: &mut Vec<L>) {
        numbers.push(self.0);
    }
    fn read(numbers: &[L]) -> Self {
        Self(numbers[0])
    }
    fn gather(one: impl Fn(usize) -> Bond<f64>) -> Self {
        Self(L::from_lanes(|k| one(k).0))
    }
    fn lane(&self, k: usize) -> Bond<f64> {
        Bond(self.0.lane(k))
    }
}

impl Bridge {
    /// 1 while they touch, 0 where the bridge ends or where there is none.
    fn part<L: Real>(&self, contact: &Contact<L>, bond: &Bond<L>) -> L {
        let part = (contact.overlap / self.range + L::ONE).min(L::ONE);
        let holds = L::ZERO.below(part) & !bond.0.equals(L::ZERO);
        L::select(holds, part, L::ZERO)
    }
}

impl AdhesionLaw for Bridge {
    type History<L: Real> = Bond<L>;
    type Events = NoEvents;
    const ACTIVE: bool = true;
    const TWISTS: bool = true;
    const PRESSES: bool = true;

    fn name(&self) -> &'static str {
        "bridge"
    }

    fn forms_on_contact(&self) -> bool {
        true
    }

    fn range(&self) -> f64 {
        self.range
    }

    fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        _: f64,
        history: &mut Bond<L>,
    ) -> AdhesionForce<L> {
        let touches = L::ZERO.below(contact.overlap);
        if touches.any() {
            history.0 = L::select(touches, L::ONE, history.0);
        }
        let part = self.part(contact, history);
        let along = AdhesionForce::along(NormalForce {
            elastic: part * -self.pull,
            viscous: part * -self.viscosity * contact.normal_velocity,
        });
        AdhesionForce {
            couple: contact.spin * (part * -self.twist),
            friction_load: part * self.pull,
            ..along
        }
    }

    fn energy<L: Real>(&self, contact: &Contact<L>, history: &Bond<L>) -> L {
        let part = self.part(contact, history);
        part * part * (-0.5 * self.pull * self.range) - contact.overlap.max(L::ZERO) * self.pull
    }
}

fn normal_laws() -> Vec<AnyNormal> {
    AnyNormal::examples(&Scale {
        stiffness: 1e4,
        radius: 5e-3,
        mass: 1e-4,
    })
}

/// A law that is left out of the lists here is not compared in lanes.
#[test]
fn every_law_is_in_the_lists() {
    fn kinds<T>(laws: &[T]) -> usize {
        let kinds: HashSet<_> = laws.iter().map(std::mem::discriminant).collect();
        kinds.len()
    }
    assert_eq!(kinds(&normal_laws()), AnyNormal::COUNT);
    assert_eq!(kinds(&tangential_laws()), AnyTangential::COUNT);
    assert_eq!(kinds(&rolling_laws()), AnyRolling::COUNT);
}

#[test]
fn every_normal_law_has_examples() {
    let examples = normal_laws();
    for keys in AnyNormal::KEYS {
        let of_law = examples.iter().filter(|law| law.name() == keys.name);
        assert!(of_law.count() > 0, "{} has no examples", keys.name);
    }
}

fn tangential_laws() -> Vec<AnyTangential> {
    let linear = LinearFriction {
        stiffness: 3e3,
        dissipation: 0.1,
        friction: 0.4,
        static_friction: 0.6,
        rotation: SpringRotation::Project,
        limits: CoulombLimits::Bounded,
    };
    let mindlin = Mindlin::new(1.1e6, 2.0 / 3.0, 0.3, 0.4, 0.5);
    let mut laws = vec![
        AnyTangential::None,
        AnyTangential::Linear(LinearFriction {
            rotation: SpringRotation::Incremental,
            ..linear
        }),
        AnyTangential::Linear(LinearFriction {
            friction: 0.0,
            ..linear
        }),
    ];
    for limits in [
        CoulombLimits::Bounded,
        CoulombLimits::Elastic,
        CoulombLimits::Total,
    ] {
        let linear = LinearFriction { limits, ..linear };
        let plain = mindlin.with_limits(limits);
        laws.extend([
            AnyTangential::Linear(linear),
            AnyTangential::Linear(LinearFriction {
                stiffness: 0.0,
                ..linear
            }),
            AnyTangential::Mindlin(plain),
            AnyTangential::MindlinRescaled(MindlinRescaled { plain }),
        ]);
    }
    laws
}

fn rolling_laws() -> Vec<AnyRolling> {
    let spring = FrictionSpring {
        stiffness: None,
        dissipation: 0.05,
        friction: 0.1,
        static_friction: 0.15,
    };
    let stiff = |stiffness| FrictionSpring {
        stiffness: Some(stiffness),
        ..spring
    };
    let luding = |rolling, torsion, rotation| {
        AnyRolling::Luding(Luding {
            rolling,
            torsion,
            lever: 1.0,
            rotation,
        })
    };
    let off = FrictionSpring {
        friction: 0.0,
        ..spring
    };
    vec![
        AnyRolling::None,
        luding(spring, spring, SpringRotation::Project),
        luding(stiff(2e3), stiff(0.0), SpringRotation::Incremental),
        luding(off, stiff(2e3), SpringRotation::Project),
        luding(stiff(0.0), off, SpringRotation::Project),
    ]
}

/// Directions, all lengths between 0 and 1.
fn arrows() -> impl Strategy<Value = Vector> {
    let part = || -0.57..0.57f64;
    (part(), part(), part()).prop_map(|(x, y, z)| Vector::new(x, y, z))
}

/// A spring of some kind: none, too short to have a direction, in the tangent plane, nearly so, far from it, along the normal.
fn spring(kind: u8, direction: Vector, normal: Vector, length: f64) -> Vector {
    let along = normal * direction.dot(normal);
    let flat = direction - along;
    match kind {
        0 => Vector::ZERO,
        1 => direction * 1e-16,
        2 => flat * length,
        3 => (flat + along * 1e-3) * length,
        4 => direction * length,
        _ => normal * length,
    }
}

/// Contacts of every kind: beginning, sticking, sliding, rolling, let go, pulled, at a place where the force is cut to zero.
fn contacts() -> impl Strategy<Value = Alone> {
    let kinds = (0u8..6, 0u8..6, 0u8..6, 0u8..8);
    let lengths = || prop_oneof![Just(1e-9), 1e-8..1e-6f64, 1e-5..1e-3f64];
    let shares = || prop_oneof![Just(0.0), Just(1.0), 0.5..2.0f64, 1.0..20.0f64];
    (
        (arrows(), arrows(), arrows(), arrows(), arrows()),
        (1e-9..1e-4f64, 1e-3..1e-2f64, 1e-6..1e-3f64, 1e-3..1e0f64),
        (kinds, lengths(), shares(), shares()),
    )
        .prop_map(|(vectors, (overlap, radius, mass, speed), memory)| {
            let (direction, u, v, w, along) = vectors;
            let normal = if direction.length() > 0.0 {
                direction / direction.length()
            } else {
                Vector::X
            };
            let ((first, second, third, motion), length, largest_overlap, contact_radius) = memory;
            let mut velocity = u * speed;
            match motion {
                // at rest; parting so fast that the dashpot would pull
                0 => velocity = Vector::ZERO,
                1 => velocity += normal * 1e4,
                _ => {}
            }
            let normal_velocity = velocity.dot(normal);
            let half = normal + w * 1e-2;
            let contact = Contact {
                normal,
                distance: 4.0 * radius - overlap,
                overlap,
                effective_radius: radius,
                effective_mass: mass,
                normal_velocity,
                tangential_velocity: velocity - normal * normal_velocity,
                sliding_normal: half * (1.0 / half.length()),
                sliding_distance: 4.0 * radius,
                centre_velocity: velocity + v * speed,
                spin: w * (speed / radius),
            };
            let memory = Memory {
                largest_overlap,
                springs: [(first, along), (second, u), (third, v)]
                    .map(|(kind, arrow)| spring(kind, arrow, normal, length)),
                contact_radius,
            };
            Alone { contact, memory }
        })
}

fn eight() -> impl Strategy<Value = [Alone; 8]> {
    proptest::collection::vec(contacts(), 8)
        .prop_map(|alone| alone.try_into().expect("eight of them"))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Each normal law with each tangential law, rolling laws in turn, through the choice at run time.
    #[test]
    fn laws_in_lanes_give_the_bits_of_laws_alone(alone in eight(), turn in 0usize..5) {
        let rolling_laws = rolling_laws();
        for (i, normal) in normal_laws().into_iter().enumerate() {
            for (j, tangential) in tangential_laws().into_iter().enumerate() {
                let rolling = rolling_laws[(turn + i + j) % rolling_laws.len()];
                compare_all(PairLaw { normal, tangential, rolling, adhesion: NoAdhesion }, &alone)?;
            }
        }
    }

    /// As they are compiled for scenes with one kind of law, where parts are of size zero.
    #[test]
    fn compiled_combinations_do_too(alone in eight()) {
        let (normal, tangential) = (Hertz::new(5e6, 0.4), Mindlin::new(1.1e6, 1.0, 0.3, 0.4, 0.5));
        compare_all(PairLaw { normal, tangential, rolling: NoRolling, adhesion: NoAdhesion }, &alone)?;
        let normal = Linear::with_damping_ratio(1e4, 0.3);
        let bridge = Bridge { pull: 0.3, range: 3e-5, viscosity: 0.02, twist: 1e-9 };
        compare_all(PairLaw { normal, tangential, rolling: NoRolling, adhesion: bridge }, &alone)?;
        compare_all(PairLaw { normal, tangential: NoFriction, rolling: NoRolling, adhesion: NoAdhesion }, &alone)?;
    }
}

/// F_t = mu (F_n + load) where both slide, and the couple acts beside friction.
#[test]
fn adhesion_that_presses_raises_the_limit_of_friction() {
    let (stiffness, overlap, pull, mu) = (1e4, 1e-6, 0.3, 0.4);
    let contact = Contact {
        normal: Vector::X,
        distance: 2e-3 - overlap,
        overlap,
        effective_radius: 5e-4,
        effective_mass: 1e-6,
        normal_velocity: 0.0,
        tangential_velocity: Vector::new(0.0, 1.0, 0.0),
        sliding_normal: Vector::X,
        sliding_distance: 2e-3 - overlap,
        centre_velocity: Vector::new(0.0, 1.0, 0.0),
        spin: Vector::new(3.0, 0.0, 0.0),
    };
    let law = PairLaw {
        normal: Linear::new(stiffness, 0.0),
        // One step stretches the spring far beyond the limit.
        tangential: LinearFriction {
            stiffness: 1e6,
            dissipation: 0.0,
            friction: mu,
            static_friction: mu,
            rotation: SpringRotation::Project,
            limits: CoulombLimits::Bounded,
        },
        rolling: NoRolling,
        adhesion: Bridge {
            pull,
            range: 3e-5,
            viscosity: 0.0,
            twist: 2e-9,
        },
    };
    let mut history = Default::default();
    let action = law.act(&contact, 1.0, &mut history);
    let limit = mu * (stiffness * overlap + pull);
    let sliding: f64 = action.tangential.length();
    assert!(
        (sliding - limit).abs() < 1e-14,
        "{sliding} N, not {limit} N"
    );
    let along = stiffness * overlap - pull;
    assert!((action.force.x - along).abs() < 1e-14);
    assert_eq!(action.couple, Vector::new(-2e-9 * 3.0, 0.0, 0.0));
    let now = law.friction_now(&contact, &action, &history);
    assert!((now.load - (stiffness * overlap + pull)).abs() < 1e-14);
}

/// Most lanes of one group are in different branches: the property above would say little if they never were.
#[test]
fn lanes_of_a_group_take_different_branches() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let mut mixed = [0; 4];
    let mut clamped = Linear::new(1e4, 0.3);
    clamped.clamp_tension = true;
    for _ in 0..100 {
        let alone = eight().new_tree(&mut runner).expect("a value").current();
        let law = PairLaw {
            normal: clamped,
            tangential: Mindlin::new(1.1e6, 2.0 / 3.0, 0.0, 0.4, 0.5),
            rolling: NoRolling,
            adhesion: NoAdhesion,
        };
        let mut seen = [[false; 2]; 4];
        for one in &alone {
            let numbers = one.memory.numbers(&law, &one.contact);
            let spring = Vector::from_slice(&numbers);
            let force = answers(&law, &one.contact, &numbers);
            let tangential = Vector::from_slice(&force[3..]).length();
            let limit = 0.4 * (force[9] + force[10]);
            let along = spring.dot(one.contact.normal);
            let far = along * along > 1e-5 * spring.length_squared();
            let cut = (tangential / limit - 1.0).abs() < 1e-12;
            let no_spring = spring == Vector::ZERO;
            for (seen, is) in seen.iter_mut().zip([limit == 0.0, cut, far, no_spring]) {
                seen[usize::from(is)] = true;
            }
        }
        for (mixed, seen) in mixed.iter_mut().zip(seen) {
            *mixed += usize::from(seen == [true, true]);
        }
    }
    assert!(mixed.iter().all(|&groups| groups > 20), "{mixed:?}");
}
