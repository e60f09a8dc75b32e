//! Materials to pair laws: one mixing rule for particle pairs and walls.
//!
//! Like-like parameters mix by the harmonic mean 2/(1/a + 1/b), which is 0 if either is 0; for E* and G* that is what
//! the elasticity of the two bodies gives. Restitutions are not mixed, the damping that belongs to them is (a mean of
//! restitutions has no meaning for the mixed pair). `[[contacts]]` then replaces key by key. A material that lacks a law
//! that `[[contacts]]` names for the pair leaves the other one to decide.

mod normal;
mod rolling;
mod tangential;

use mercury_common::scene::{
    ContactOverride, Conventions, Material, MaterialIndex, Place, RollingLever, Scene, SceneError,
    TangentialHistory,
};

pub(super) use normal::youngs;

use super::parameter::{Origin, Parameter, Value};
use crate::contact::registry::AnyPairLaw;
use crate::contact::{PairLaw, SpringRotation};

/// The law of two materials with all its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct PairPlan {
    /// Rows of the two materials, ascending.
    pub materials: [u32; 2],
    /// Their names.
    pub names: [String; 2],
    /// Whether particles of the two can meet.
    pub between_particles: bool,
    /// Whether particles of one can meet walls of the other.
    pub at_walls: bool,
    /// The law.
    pub law: AnyPairLaw,
    /// Every resolved number.
    pub parameters: Vec<Parameter>,
}

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
pub(super) fn resolve_pair(
    scene: &Scene,
    materials: [usize; 2],
    errors: &mut Vec<SceneError>,
) -> Option<(AnyPairLaw, Vec<Parameter>)> {
    let [a, b] = [
        materials[0].min(materials[1]),
        materials[0].max(materials[1]),
    ];
    let is_this = |contact: &ContactOverride| {
        let [first, second] = &contact.between;
        let pair = [first.value, second.value];
        pair == [MaterialIndex(a), MaterialIndex(b)] || pair == [MaterialIndex(b), MaterialIndex(a)]
    };
    let mut pair = Pair {
        sides: [scene.materials.get(a)?, scene.materials.get(b)?],
        same: a == b,
        contact: scene.contacts.iter().enumerate().find(|(_, c)| is_this(c)),
        conventions: &scene.contact,
        parameters: Vec::new(),
        errors,
    };
    let normal = normal::resolve(&mut pair)?;
    let needs_stiffness = rolling::needs_tangential_stiffness(&pair);
    let tangential = tangential::resolve(&mut pair, &normal, needs_stiffness);
    let rolling = rolling::resolve(&mut pair, tangential.as_ref()?);
    let law = PairLaw {
        normal: normal.law,
        tangential: tangential?,
        rolling: rolling?,
    };
    Some((law, pair.parameters))
}

/// Two materials on the way to their law.
struct Pair<'a> {
    sides: [&'a Material; 2],
    /// Both are the same material.
    same: bool,
    /// What replaces mixed values, and its number in the file.
    contact: Option<(usize, &'a ContactOverride)>,
    conventions: &'a Conventions,
    parameters: Vec<Parameter>,
    errors: &'a mut Vec<SceneError>,
}

impl Pair<'_> {
    /// The pair in words.
    fn name(&self) -> String {
        let [a, b] = self.sides;
        format!("`{}` and `{}`", a.name.value, b.name.value)
    }

    /// The entry that would give the missing keys.
    fn entry(&self, keys: &str) -> String {
        let [a, b] = self.sides;
        format!(
            "[[contacts]] between = [{:?}, {:?}] {keys}",
            a.name.value, b.name.value
        )
    }

    /// Where to complain if the pair as a whole is wrong.
    fn place(&self) -> Place {
        match self.contact {
            Some((_, contact)) => contact.place.clone(),
            None => self.sides[1].normal.place.clone(),
        }
    }

    fn error(&mut self, message: String, help: String) {
        let error = self.place().error(message).with_help(help);
        self.errors.push(error);
    }

    fn contact_origin(&self) -> Origin {
        match self.contact {
            Some((index, _)) => Origin::Contact(index),
            None => Origin::Default,
        }
    }

    /// Where a value that was mixed from these sides came from.
    fn mixed_origin(&self, has: [bool; 2]) -> Origin {
        match has {
            _ if self.same => Origin::Material(self.sides[0].name.value.clone()),
            [true, false] => Origin::Material(self.sides[0].name.value.clone()),
            [false, true] => Origin::Material(self.sides[1].name.value.clone()),
            _ => Origin::Mixed,
        }
    }

    /// The value of the entry of `[[contacts]]`, else the mean of the sides, else that of the only side that has one.
    fn mix(&self, replaced: Option<f64>, sides: [Option<f64>; 2]) -> Option<(f64, Origin)> {
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

    /// As [`Pair::mix`]; complains where the value is missing.
    fn need(
        &mut self,
        key: &str,
        replaced: Option<f64>,
        sides: [Option<f64>; 2],
    ) -> Option<(f64, Origin)> {
        let mixed = self.mix(replaced, sides);
        if mixed.is_none() {
            let (table, key) = key.split_once('.').unwrap_or((key, ""));
            let message = format!("no {table}.{key} for the contacts of {}", self.name());
            let help = self.entry(&format!("{table} = {{ {key} = ... }}"));
            self.error(message, help);
        }
        mixed
    }

    fn record(&mut self, name: &'static str, unit: &'static str, value: f64, origin: Origin) {
        self.parameters.push(Parameter {
            name,
            value: Value::Number(value),
            unit,
            origin,
        });
    }

    fn record_word(&mut self, name: &'static str, word: &'static str, origin: Origin) {
        self.parameters.push(Parameter {
            name,
            value: Value::Word(word),
            unit: "",
            origin,
        });
    }

    fn rotation(&self) -> SpringRotation {
        match self.conventions.tangential_history {
            TangentialHistory::Project => SpringRotation::Project,
            TangentialHistory::Incremental => SpringRotation::Incremental,
        }
    }

    fn lever(&self) -> f64 {
        match self.conventions.rolling_lever {
            RollingLever::ReducedRadius => 1.0,
            RollingLever::TwiceReducedRadius => 2.0,
        }
    }
}
