//! Plans of features, each found by its type.

use std::any::Any;
use std::fmt;

use mercury_common::particle_properties::ParticleProperty;

use super::{InputError, Inputs};

/// A plan of a feature: what decides how its [`Part`](crate::step::Part) of the step acts.
///
/// It is declared in the folder of the feature; this trait is implemented beside the part, in `FEATURE/part.rs`.
pub trait FeaturePlan: Any + Clone + fmt::Debug + Send + Sync {
    /// Checks all plans of this type, at least one, in their order, against each other and the other inputs.
    ///
    /// # Errors
    /// If a number is not valid, or something that they name does not exist.
    fn check(plans: &[Self], inputs: &Inputs) -> Result<(), InputError> {
        let _ = (plans, inputs);
        Ok(())
    }

    /// Properties that all particles have with it.
    fn properties(&self) -> Vec<&'static ParticleProperty> {
        Vec::new()
    }
}

/// Plans of the features of a simulation: of each type none, one or several in an order.
#[derive(Debug, Clone, Default)]
pub struct Plans(Vec<Box<dyn PlanList>>);

impl Plans {
    /// Adds a plan behind those of its type.
    pub fn insert<P: FeaturePlan>(&mut self, plan: P) {
        self.all_mut().push(plan);
    }

    /// The plan of this type, the first one if there are several.
    #[must_use]
    pub fn get<P: FeaturePlan>(&self) -> Option<&P> {
        self.all().first()
    }

    /// All plans of this type, in their order.
    #[must_use]
    pub fn all<P: FeaturePlan>(&self) -> &[P] {
        let mut lists = self.0.iter().map(|list| list.as_ref() as &dyn Any);
        let list: Option<&Vec<P>> = lists.find_map(|list| list.downcast_ref());
        list.map_or(&[], Vec::as_slice)
    }

    /// All plans of this type, to be changed.
    pub fn all_mut<P: FeaturePlan>(&mut self) -> &mut Vec<P> {
        let mut lists = self.0.iter().map(|list| list.as_ref() as &dyn Any);
        let place = lists.position(|list| list.is::<Vec<P>>());
        let place = place.unwrap_or_else(|| {
            self.0.push(Box::new(Vec::<P>::new()));
            self.0.len() - 1
        });
        let list = self.0[place].as_mut() as &mut dyn Any;
        list.downcast_mut().expect("it is of this type")
    }

    /// Checks all plans against the other inputs.
    pub(super) fn check(&self, inputs: &Inputs) -> Result<(), InputError> {
        let mut used = self.0.iter().filter(|list| !list.is_empty());
        used.try_for_each(|list| list.check(inputs))
    }

    /// Properties that all particles have with these plans.
    pub(super) fn properties(&self) -> impl Iterator<Item = &'static ParticleProperty> {
        self.0.iter().flat_map(|list| list.properties())
    }
}

/// All plans of one type.
trait PlanList: Any + fmt::Debug + Send + Sync {
    fn is_empty(&self) -> bool;
    fn check(&self, inputs: &Inputs) -> Result<(), InputError>;
    fn properties(&self) -> Vec<&'static ParticleProperty>;
    fn copy(&self) -> Box<dyn PlanList>;
}

impl<P: FeaturePlan> PlanList for Vec<P> {
    fn is_empty(&self) -> bool {
        self.is_empty()
    }

    fn check(&self, inputs: &Inputs) -> Result<(), InputError> {
        P::check(self, inputs)
    }

    fn properties(&self) -> Vec<&'static ParticleProperty> {
        self.iter().flat_map(P::properties).collect()
    }

    fn copy(&self) -> Box<dyn PlanList> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn PlanList> {
    fn clone(&self) -> Self {
        self.as_ref().copy()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use mercury_common::particle_properties::FILM_VOLUME;

    use super::*;
    use crate::contact::registry::AnyPairLaw;
    use crate::contact::{AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Linear};

    #[derive(Debug, Clone, PartialEq)]
    struct Drag(f64);

    #[derive(Debug, Clone, PartialEq)]
    struct Lift(u32);

    impl FeaturePlan for Drag {
        fn check(plans: &[Self], _: &Inputs) -> Result<(), InputError> {
            let total: f64 = plans.iter().map(|Drag(one)| one).sum();
            crate::physics::positive("the drag", total - 1.0)
        }
    }

    impl FeaturePlan for Lift {
        fn properties(&self) -> Vec<&'static ParticleProperty> {
            vec![&FILM_VOLUME]
        }
    }

    fn inputs() -> Inputs {
        let law = AnyPairLaw {
            normal: AnyNormal::Linear(Linear::new(1e4, 0.0)),
            tangential: AnyTangential::None,
            rolling: AnyRolling::None,
            adhesion: AnyAdhesion::None,
        };
        Inputs::new(1e-3, (DVec3::ZERO, DVec3::ONE), 1000.0, law)
    }

    #[test]
    fn plans_are_checked_together_and_give_their_properties() {
        let plain = inputs().physics().unwrap();
        assert!(!plain.has_property(&FILM_VOLUME));
        let error = inputs().with_plan(Drag(0.5)).physics().unwrap_err();
        assert_eq!(
            error.to_string(),
            "the drag must be a number above 0, got -0.5"
        );
        let both = inputs().with_plan(Drag(0.5)).with_plan(Drag(1.0));
        assert!(
            both.with_plan(Lift(1))
                .physics()
                .unwrap()
                .has_property(&FILM_VOLUME)
        );
        // A list from which the last plan was taken is none.
        let mut emptied = inputs();
        emptied.plans.all_mut::<Drag>().clear();
        emptied.physics().unwrap();
    }

    #[test]
    fn plans_are_found_by_their_types_in_their_order() {
        let mut plans = Plans::default();
        assert_eq!(plans.get::<Drag>(), None);
        plans.insert(Drag(1.0));
        plans.insert(Lift(2));
        plans.insert(Drag(3.0));
        assert_eq!(plans.get::<Drag>(), Some(&Drag(1.0)));
        assert_eq!(plans.all::<Drag>(), [Drag(1.0), Drag(3.0)]);
        assert_eq!(plans.all::<Lift>(), [Lift(2)]);
        let before = plans.clone();
        plans.all_mut::<Drag>().clear();
        assert_eq!(plans.all::<Drag>(), []);
        assert_eq!(before.all::<Drag>().len(), 2);
    }
}
