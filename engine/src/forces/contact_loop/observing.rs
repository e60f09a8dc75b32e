//! Observation of the contacts of a loop, and its collection from the blocks.

use super::ContactLoop;
use super::slots::WITH_HISTORY;
use crate::contact::{AdhesionLaw, NormalLaw, RollingLaw, TangentialLaw};
use crate::forces::{
    Alarms, Bond, ContactEvent, ContactRecord, FeatureKey, FeatureLoad, Observation,
    ObservesContacts, Rub,
};
use crate::surface::SurfaceLoad;

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> ObservesContacts
    for ContactLoop<N, T, R, A>
{
    fn listed(&self) -> usize {
        self.blocks.iter().map(|block| block.slots.len()).sum()
    }

    fn touching(&self) -> usize {
        let slots = self.blocks.iter().flat_map(|block| &block.slots);
        slots.filter(|slot| slot.state & WITH_HISTORY != 0).count()
    }

    fn observation(&self, walls: usize, records: bool) -> Observation {
        let mut sum = Observation::empty(walls);
        for block in self.blocks.iter().chain(self.of_sheets.iter().flatten()) {
            if records {
                sum.merge(&block.observation);
            } else {
                sum.merge_sums(&block.observation);
            }
        }
        sum
    }

    fn take_records(&mut self) -> Vec<ContactRecord> {
        let of_sheets = self.of_sheets.iter_mut().flatten();
        let blocks = self.blocks.iter_mut().chain(of_sheets);
        let mut taken: Vec<_> = blocks
            .map(|block| std::mem::take(&mut block.observation.records))
            .collect();
        if taken.len() == 1 {
            return taken.remove(0);
        }
        taken.concat()
    }

    fn take_events(&mut self) -> Vec<ContactEvent> {
        let mut all = Vec::new();
        if A::HAS_EVENTS {
            for (number, block) in (0..).zip(&mut self.blocks) {
                block.take_events(number, &mut all);
            }
        }
        all
    }

    fn bonds(&self, wanted: &dyn Fn(usize) -> bool) -> Vec<Bond> {
        let mut all = Vec::new();
        if A::HAS_EVENTS {
            for (number, block) in (0..).zip(&self.blocks) {
                block.add_bonds(number, wanted, &mut all);
            }
        }
        all
    }

    fn take_alarms(&mut self) -> Alarms {
        let mut all = Alarms::default();
        for block in self
            .blocks
            .iter_mut()
            .chain(self.of_sheets.iter_mut().flatten())
        {
            all.take_from(&mut block.alarms);
        }
        all
    }

    fn take_feature_loads(&mut self) -> Vec<(FeatureKey, FeatureLoad)> {
        let mut all = std::mem::take(&mut self.feature_loads);
        for block in &mut self.blocks {
            all.merge(&std::mem::take(&mut block.feature_loads));
        }
        all.sorted()
    }

    fn take_rubs(&mut self, all: &mut Vec<Rub>) {
        for block in &mut self.blocks {
            all.append(&mut block.rubs);
        }
    }

    fn visit_surface_loads(&self, visit: &mut dyn FnMut(&SurfaceLoad)) {
        let loads = self.blocks.iter().flat_map(|block| &block.surface_loads);
        loads.for_each(visit);
    }
}
