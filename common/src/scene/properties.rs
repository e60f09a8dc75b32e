//! The [properties](crate::particle_properties) that entries give their particles.

use super::cursor::Fields;
use super::keys::{Kind, SceneKey, key};
use super::source::Located;
use crate::particle_properties::{PARTICLE_PROPERTIES, ParticleProperty, PropertyValue};

const fn count() -> usize {
    let (mut count, mut place) = (0, 0);
    while place < PARTICLE_PROPERTIES.len() {
        if PARTICLE_PROPERTIES[place].given.is_some() {
            count += 1;
        }
        place += 1;
    }
    count
}

const fn keys(in_mixture: bool) -> [SceneKey; count()] {
    let mut keys = [key("", Kind::Flag, "", ""); count()];
    let (mut count, mut place) = (0, 0);
    while place < PARTICLE_PROPERTIES.len() {
        let property = &PARTICLE_PROPERTIES[place];
        if let Some(given) = property.given {
            let kind = Kind::Number(property.unit, given.range);
            let key = key(property.name, kind, given.example, given.text);
            keys[count] = match in_mixture {
                true => key.or_open("that of the insertion"),
                false => key.or(property.default),
            };
            count += 1;
        }
        place += 1;
    }
    keys
}

/// Their keys.
pub(super) const PROPERTIES: &[SceneKey] = &keys(false);
/// Their keys in an ingredient of a mixture.
pub(super) const PROPERTIES_IN_MIXTURE: &[SceneKey] = &keys(true);

/// The values of the keys that are there.
pub(super) fn read(fields: &Fields<'_>) -> Vec<PropertyValue> {
    let value = |property: &'static ParticleProperty| {
        let given: Option<Located<f64>> = fields.read(property.name);
        // A wrong value is NaN, and is already reported.
        Some((property, given.filter(|value| !value.is_nan())?.value))
    };
    ParticleProperty::given().filter_map(value).collect()
}

/// Properties that have to be kept: those that differ from the default.
pub(super) fn not_default(mut properties: Vec<PropertyValue>) -> Vec<PropertyValue> {
    properties.retain(|(property, value)| property.differs(*value));
    properties
}
