//! From two materials as typed to the law of their contacts: one mixing rule for particle pairs and walls.
//!
//! Like-like parameters mix by the harmonic mean 2/(1/a + 1/b), which is 0 if either is 0; for E* and G* that is what
//! the elasticity of the two bodies gives. Restitutions are not mixed, the damping that belongs to them is (a mean of
//! restitutions has no meaning for the mixed pair). `[[contacts]]` then replaces key by key. A material that lacks a law
//! that `[[contacts]]` names for the pair leaves the other one to decide.
//!
//! Rules in a law's table of keys are applied here ([`Pair::number`]); further rules stand in the law's own file.

mod adhesion;
mod damping;
mod liquid;
mod normal;
mod rolling;
mod tangential;

pub use damping::{damping_ratio_of, restitution_of};
pub use tangential::Friction;

use mercury_common::scene::{
    ContactOverride, Conventions, KeyDefault, Law, LawKeys, LawPart, LawValues, Material,
    MaterialIndex, Mixing, Range, RollingLever, Scene, SceneError, SourceSpan, TangentialHistory,
};

use super::parameter::{Origin, Parameter, Value, short};
use super::registry::AnyPairLaw;
use super::{AnyAdhesion, AnyNormal, PairLaw, SpringRotation};

/// The harmonic mean 2/(1/a + 1/b) of two numbers >= 0; 0 if either is 0.
#[must_use]
pub fn harmonic_mean(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 {
        0.0
    } else if a == b {
        a
    } else {
        2.0 / (1.0 / a + 1.0 / b)
    }
}

/// Resolves the law between two materials. Problems go to `errors`; the result is then `None`.
pub fn resolve_pair(
    scene: &Scene,
    materials: [usize; 2],
    errors: &mut Vec<SceneError>,
) -> Option<(AnyPairLaw, Vec<Parameter>)> {
    let mut pair = Pair::new(scene, materials, errors)?;
    let normal = normal::resolve(&mut pair)?;
    let needs_stiffness = rolling::needs_tangential_stiffness(&mut pair);
    let tangential = tangential::resolve(&mut pair, &normal, needs_stiffness);
    let rolling = rolling::resolve(&mut pair, tangential.as_ref()?);
    let liquid = liquid::resolve(&mut pair, &scene.liquid);
    let dry = adhesion::resolve(&mut pair, &normal);
    let adhesion = pair.one_of(liquid?, dry?);
    let law = PairLaw {
        normal,
        tangential: tangential?,
        rolling: rolling?,
        adhesion: adhesion?,
    };
    Some((law, pair.parameters))
}

/// Elastic constants (E, nu) of a material whose normal law gives them.
#[must_use]
pub fn elastic_constants(material: &Material) -> Option<(f64, f64)> {
    let values = &material.normal.values;
    Some((
        values.number("youngs_modulus")?,
        values.number("poisson_ratio")?,
    ))
}

/// The properties of two materials, from which their law is made. A law's own function reads the values of the keys in the law's
/// table from it: as typed at either side, replaced by `[[contacts]]`, or mixed; and it records the results there, for `--check`.
pub struct Pair<'a> {
    sides: [&'a Material; 2],
    /// Both are the same material.
    same: bool,
    /// Override of mixed values, and its number in the file.
    contact: Option<(usize, &'a ContactOverride)>,
    conventions: &'a Conventions,
    /// The law whose keys are being read, and its part.
    law: &'static LawKeys,
    part: LawPart,
    parameters: Vec<Parameter>,
    errors: &'a mut Vec<SceneError>,
}

impl<'a> Pair<'a> {
    /// Two materials of a scene by their numbers; `None` if there are no such materials. Problems will go to `errors`.
    pub fn new(
        scene: &'a Scene,
        materials: [usize; 2],
        errors: &'a mut Vec<SceneError>,
    ) -> Option<Self> {
        let [a, b] = [
            materials[0].min(materials[1]),
            materials[0].max(materials[1]),
        ];
        let is_this = |contact: &ContactOverride| {
            let [first, second] = &contact.between;
            let pair = [first.value, second.value];
            pair == [MaterialIndex(a), MaterialIndex(b)]
                || pair == [MaterialIndex(b), MaterialIndex(a)]
        };
        Some(Self {
            sides: [scene.materials.get(a)?, scene.materials.get(b)?],
            same: a == b,
            contact: scene.contacts.iter().enumerate().find(|(_, c)| is_this(c)),
            conventions: &scene.contact,
            law: &LawKeys::NONE,
            part: LawPart::Normal,
            parameters: Vec::new(),
            errors,
        })
    }

    /// Selects the law whose keys are read from now on.
    pub fn ask(&mut self, part: LawPart, law: &'static LawKeys) {
        (self.part, self.law) = (part, law);
    }

    /// Whether the keys of this law are being read.
    #[must_use]
    pub fn requests(&self, law: &LawKeys) -> bool {
        self.law.name == law.name
    }

    /// The part whose law is being read.
    #[must_use]
    pub fn part(&self) -> LawPart {
        self.part
    }

    /// The conventions of the scene.
    #[must_use]
    pub fn conventions(&self) -> &'a Conventions {
        self.conventions
    }

    /// Parameters that were resolved so far.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// The pair in words.
    #[must_use]
    pub fn name(&self) -> String {
        let [a, b] = self.sides;
        format!("`{}` and `{}`", a.name.value, b.name.value)
    }

    /// The entry that would give the missing keys.
    #[must_use]
    pub fn entry(&self, keys: &str) -> String {
        let [a, b] = self.sides;
        format!(
            "[[contacts]] between = [{:?}, {:?}] {keys}",
            a.name.value, b.name.value
        )
    }

    /// Place of the error if the pair as a whole is wrong.
    fn place(&self) -> SourceSpan {
        match self.contact {
            Some((_, contact)) => contact.place.clone(),
            None => {
                let law = self.sides[1].law(self.part);
                law.unwrap_or(&self.sides[1].normal).place.clone()
            }
        }
    }

    /// Reports an error of the pair; `help` is the advice.
    pub fn error(&mut self, message: String, help: String) {
        let error = self.place().error(message).with_help(help);
        self.errors.push(error);
    }

    /// The origin of what `[[contacts]]` replaces.
    #[must_use]
    pub fn contact_origin(&self) -> Origin {
        match self.contact {
            Some((index, _)) => Origin::Contact(index),
            None => Origin::Default,
        }
    }

    /// Where a value that was mixed from these sides came from.
    #[must_use]
    pub fn mixed_origin(&self, has: [bool; 2]) -> Origin {
        match has {
            _ if self.same => Origin::Material(self.sides[0].name.value.clone()),
            [true, false] => Origin::Material(self.sides[0].name.value.clone()),
            [false, true] => Origin::Material(self.sides[1].name.value.clone()),
            _ => Origin::Mixed,
        }
    }

    /// The laws of a part that the two materials name, whichever they are.
    fn laws(&self, part: LawPart) -> [Option<&'a Law>; 2] {
        self.sides.map(|side| side.law(part))
    }

    /// The keys that each material gives for the law that is being read; `None` where it names another law, or none.
    #[must_use]
    pub fn typed(&self) -> [Option<&'a LawValues>; 2] {
        self.laws(self.part).map(|law| {
            law.filter(|law| law.name.value == self.law.name)
                .map(|law| &law.values)
        })
    }

    /// Values of a part that `[[contacts]]` replaces.
    #[must_use]
    pub fn replaced(&self, part: LawPart) -> Option<&'a LawValues> {
        let (_, contact) = self.contact?;
        contact.law(part).map(|law| &law.values)
    }

    /// The number that each material gives at a key of the law that is being read.
    #[must_use]
    pub fn sides(&self, key: &str) -> [Option<f64>; 2] {
        self.typed().map(|values| values?.number(key))
    }

    /// The number that `[[contacts]]` sets at a key of the law that is being read.
    #[must_use]
    pub fn over(&self, key: &str) -> Option<f64> {
        self.replaced(self.part)?.number(key)
    }

    /// Elastic constants (E, nu) of both materials, where their normal laws give them.
    #[must_use]
    pub fn elastic_constants(&self) -> [Option<(f64, f64)>; 2] {
        self.sides.map(elastic_constants)
    }

    /// The normal law of each of the two materials with itself, as if the other one and `[[contacts]]` were not there.
    fn own_normals(&self) -> [Option<AnyNormal>; 2] {
        self.sides.map(|material| {
            let mut errors = Vec::new();
            normal::resolve(&mut Pair {
                sides: [material; 2],
                same: true,
                contact: None,
                conventions: self.conventions,
                law: &LawKeys::NONE,
                part: LawPart::Normal,
                parameters: Vec::new(),
                errors: &mut errors,
            })
        })
    }

    /// The constant stiffness of each of the two materials with itself, N/m; `None` where it has none.
    #[must_use]
    pub fn own_stiffnesses(&self) -> [Option<f64>; 2] {
        use super::PlannedNormal;
        self.own_normals().map(|law| law?.spring())
    }

    /// The value of the entry of `[[contacts]]`, else the mean of the sides, else that of the only side that has one.
    #[must_use]
    pub fn mix(&self, replaced: Option<f64>, sides: [Option<f64>; 2]) -> Option<(f64, Origin)> {
        if let Some(value) = replaced {
            return Some((value, self.contact_origin()));
        }
        let value = match sides {
            [Some(a), Some(b)] => harmonic_mean(a, b),
            [Some(only), None] | [None, Some(only)] => only,
            [None, None] => return None,
        };
        Some((value, self.mixed_origin(sides.map(|side| side.is_some()))))
    }

    /// As [`Pair::mix`]; reports an error where the value is missing.
    pub fn need(
        &mut self,
        key: &str,
        replaced: Option<f64>,
        sides: [Option<f64>; 2],
    ) -> Option<(f64, Origin)> {
        let mixed = self.mix(replaced, sides);
        if mixed.is_none() {
            let table = self.part.word();
            let message = format!("no {table}.{key} for the contacts of {}", self.name());
            let help = self.entry(&format!("{table} = {{ {key} = ... }}"));
            self.error(message, help);
        }
        mixed
    }

    /// The number at a key by the law's table: replaced, mixed, or its default; else an error is reported. It is recorded.
    pub fn number(&mut self, key: &str) -> Option<f64> {
        let (over, sides) = (self.over(key), self.sides(key));
        let default = self.law.key(key).map(|key| key.default);
        let (value, origin) = match (self.mix(over, sides), default) {
            (Some(mixed), _) => mixed,
            (None, Some(KeyDefault::Number(number))) => (number, Origin::Default),
            (None, _) => self.need(key, over, sides)?,
        };
        self.record(key, value, origin);
        Some(value)
    }

    /// The numbers at these keys, each as [`Pair::number`] gives it.
    pub fn numbers<const N: usize>(&mut self, keys: [&str; N]) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        for (number, key) in numbers.iter_mut().zip(keys) {
            *number = self.number(key)?;
        }
        Some(numbers)
    }

    /// The word at a key by the law's table: replaced, equal on both sides, or its default; else an error. It is not
    /// recorded yet.
    pub fn word(&mut self, key: &str) -> Option<(&'static str, Origin)> {
        let known = self.law.key(key)?;
        debug_assert_eq!(known.mixing, Mixing::Same);
        let Range::Words(words) = known.range else {
            return None;
        };
        let default = match known.default {
            KeyDefault::Word(word, _) => Some(word),
            _ => None,
        };
        let find = |typed: &str| words.iter().copied().find(|word| *word == typed);
        let over = self.replaced(self.part).and_then(|values| values.word(key));
        if let Some(word) = over.and_then(find) {
            return Some((word, self.contact_origin()));
        }
        let sides = self.typed().map(|values| match values?.word(key) {
            Some(typed) => find(typed),
            None => default,
        });
        let has = sides.map(|side| side.is_some());
        match (sides, default) {
            ([Some(a), Some(b)], _) if a != b => {
                let message = format!(
                    "the {key} of the contacts of {} is ambiguous: one material has {a:?}, the other {b:?}",
                    self.name()
                );
                let table = self.part.word();
                let help = self.entry(&format!("{table} = {{ {key} = \"...\" }}"));
                self.error(message, help);
                None
            }
            ([Some(word), _] | [_, Some(word)], _) => Some((word, self.mixed_origin(has))),
            ([None, None], Some(word)) => Some((word, Origin::Default)),
            ([None, None], None) => None,
        }
    }

    /// The coefficient at which sliding (or rolling, or twisting) starts: where it is not given, the one at which it goes on,
    /// `friction`. A side that gives none counts with its friction. It is recorded.
    pub fn static_friction(&mut self, friction: f64) -> Option<f64> {
        let part = self.part;
        let typed = |key: &str| self.laws(part).map(|law| law?.values.number(key));
        let (over, own) = (self.over("static_friction"), typed("static_friction"));
        let (value, origin) = if over.is_none() && own == [None, None] {
            (friction, Origin::Derived("= friction"))
        } else {
            let frictions = typed("friction");
            let sides = [0, 1].map(|i| Some(own[i].or(frictions[i]).unwrap_or(0.0)));
            self.mix(over, sides)?
        };
        // A mean of equal numbers may differ in the last digits.
        if value < friction * (1.0 - 1e-12) {
            let table = part.word();
            let message = format!(
                "{table}.static_friction = {} of the contacts of {} lies below {table}.friction = {}",
                short(value),
                self.name(),
                short(friction)
            );
            let help = "what holds before it slides needs at least the friction of sliding; give both coefficients";
            self.error(message, help.to_owned());
            return None;
        }
        let value = value.max(friction);
        self.record("static_friction", value, origin);
        Some(value)
    }

    /// Records the number at a key of the law's table.
    pub fn record(&mut self, key: &str, value: f64, origin: Origin) {
        let unit = self.law.key(key).map_or("", |key| key.unit);
        self.record_derived(key, unit, value, origin);
    }

    /// Records a number that is no key of a scene.
    pub fn record_derived(&mut self, name: &str, unit: &'static str, value: f64, origin: Origin) {
        self.parameters.push(Parameter {
            name: format!("{}.{name}", self.part.word()),
            value: Value::Number(value),
            unit,
            origin,
        });
    }

    /// Records a word.
    pub fn record_word(&mut self, key: &str, word: &'static str, origin: Origin) {
        self.parameters.push(Parameter {
            name: format!("{}.{key}", self.part.word()),
            value: Value::Word(word),
            unit: "",
            origin,
        });
    }

    /// How springs follow the contact, by the scene's conventions.
    #[must_use]
    pub fn rotation(&self) -> SpringRotation {
        match self.conventions.tangential_history {
            TangentialHistory::Project => SpringRotation::Project,
            TangentialHistory::Incremental => SpringRotation::Incremental,
        }
    }

    /// The lever of rolling over R*, by the scene's conventions.
    #[must_use]
    pub fn lever(&self) -> f64 {
        match self.conventions.rolling_lever {
            RollingLever::ReducedRadius => 1.0,
            RollingLever::TwiceReducedRadius => 2.0,
        }
    }
}

impl Pair<'_> {
    /// Liquid bridges or dry cohesion; reports an error where a pair has both.
    fn one_of(&mut self, liquid: AnyAdhesion, dry: AnyAdhesion) -> Option<AnyAdhesion> {
        if liquid != AnyAdhesion::None && dry != AnyAdhesion::None {
            let message = format!(
                "the contacts of {} have both liquid and adhesion: a pair has one of the two",
                self.name()
            );
            let help = "leave out `liquid` or `adhesion` at one of the two materials";
            self.error(message, help.to_owned());
            return None;
        }
        Some(if dry == AnyAdhesion::None {
            liquid
        } else {
            dry
        })
    }

    /// The law of the part that is being read: named by `[[contacts]]`, by both materials, or by the only one that has one.
    fn common_law(&mut self, laws: &[&'static LawKeys]) -> Option<(&'static LawKeys, Origin)> {
        let part = self.part;
        let over = (self.contact).and_then(|(_, contact)| contact.law(part)?.name.as_ref());
        let own = self
            .laws(part)
            .map(|law| law.map(|law| law.name.value.as_str()));
        let (name, origin) = match (over, own) {
            (Some(name), _) => (name.value.as_str(), self.contact_origin()),
            (None, [Some(a), Some(b)]) if a == b => (a, self.mixed_origin([true; 2])),
            (None, [Some(only), None]) => (only, self.mixed_origin([true, false])),
            (None, [None, Some(only)]) => (only, self.mixed_origin([false, true])),
            (None, names) => {
                let [a, b] = names.map(|law| law.unwrap_or("none"));
                let word = part.word();
                let message = format!(
                    "the contacts of {} have no {word} law in common: `{}` has {a}, `{}` has {b}",
                    self.name(),
                    self.sides[0].name.value,
                    self.sides[1].name.value,
                );
                let entry = self.entry(&format!("{word} = {{ law = \"...\" }}"));
                self.error(message, format!("name it: {entry}"));
                return None;
            }
        };
        Some((self.known(laws, name)?, origin))
    }

    /// The law of this name; reports an error where there is none, which the reader has excluded unless it was given no laws.
    fn known(&mut self, laws: &[&'static LawKeys], name: &str) -> Option<&'static LawKeys> {
        let law = laws.iter().copied().find(|law| law.name == name);
        if law.is_none() {
            let message = format!("there is no {} law {name:?}", self.part.word());
            let names: Vec<&str> = laws.iter().map(|law| law.name).collect();
            self.error(message, format!("there are: {}", names.join(", ")));
        }
        law
    }
}
