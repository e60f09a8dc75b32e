//! Sinks of energy, by name.

use std::borrow::Cow;

/// Mechanisms by which contact laws take energy.
const MECHANISMS: [&str; 4] = ["normal", "tangential", "rolling", "liquid"];

/// Dry cohesion, in scenes that have it.
pub(super) const ADHESION: &str = "adhesion";

/// Energies by name, J: the mechanisms of the contact laws (`normal`: viscous and plastic normal forces; `tangential`: sliding friction
/// and tangential dashpots; `rolling`: rolling and torsion resistance; `liquid`: viscous liquid, and bridges that form, grow and
/// break), then `adhesion`, dry cohesion as contacts begin and end, where there is any, then the parts of the step that take energy, each by its name.
#[derive(Debug, Clone, PartialEq)]
pub struct Losses(Vec<(Cow<'static, str>, f64)>);

impl Losses {
    /// Of the mechanisms of the contact laws, J, in their order.
    #[must_use]
    pub fn of_laws(energies: [f64; MECHANISMS.len()]) -> Self {
        let names = MECHANISMS.into_iter().map(Cow::from);
        Self(names.zip(energies).collect())
    }

    /// Adds an energy (J) to those of this name; a name that is not there yet comes last.
    pub fn add(&mut self, name: &str, energy: f64) {
        match self.0.iter_mut().find(|(other, _)| other == name) {
            Some((_, sum)) => *sum += energy,
            None => self.0.push((Cow::from(name.to_owned()), energy)),
        }
    }

    /// By name, J; 0 if nothing of this name takes energy.
    #[must_use]
    pub fn of(&self, name: &str) -> f64 {
        let found = self.0.iter().find(|(other, _)| other == name);
        found.map_or(0.0, |(_, energy)| *energy)
    }

    /// All together, J.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.0.iter().map(|(_, energy)| energy).sum()
    }

    /// Name by name, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, f64)> {
        self.0.iter().map(|(name, energy)| (name.as_ref(), *energy))
    }

    /// The losses by name, in order.
    #[must_use]
    pub fn into_list(self) -> Vec<(Cow<'static, str>, f64)> {
        self.0
    }
}

impl Default for Losses {
    fn default() -> Self {
        Self::of_laws([0.0; MECHANISMS.len()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn energies_add_up_by_name() {
        let mut losses = Losses::of_laws([1.0, 2.0, 3.0, 4.0]);
        losses.add("drag", 5.0);
        losses.add("liquid", -1.0);
        losses.add("drag", 0.5);
        let all: Vec<_> = losses.iter().collect();
        let expected = [
            ("normal", 1.0),
            ("tangential", 2.0),
            ("rolling", 3.0),
            ("liquid", 3.0),
            ("drag", 5.5),
        ];
        assert_eq!(all, expected);
        assert_eq!((losses.of("drag"), losses.of("heat")), (5.5, 0.0));
        assert_eq!(losses.total(), 14.5);
    }
}
