//! Reports of force evaluations: notes that blocks of contacts take for parts of the step.

use super::{
    Alarms, ContactForces, ContactRecord, FeatureKey, FeatureLoad, FeatureLoads, Observation, Rub,
    SavedLoads, StepContext,
};
use crate::state::Load;
use crate::sums::{Exact, exact};
use crate::surface::SurfaceLoad;
use crate::walls::WallStiffness;

/// Reports of one block of contacts.
#[derive(Debug, Default)]
pub struct Reports {
    /// Sums and records of the last evaluation that was observed.
    pub observation: Observation,
    /// Contacts beyond a limit, since they were taken last.
    pub alarms: Alarms,
    /// Loads on features of mesh walls, since they were taken last.
    pub feature_loads: FeatureLoads,
    /// Loads on walls about their reference points in the last evaluation that summed them up; empty without contacts.
    pub wall_loads: Vec<Load>,
    /// Contacts with walls that wear, since they were taken last.
    pub rubs: Vec<Rub>,
    /// Loads of contacts on sheets in the last evaluation.
    pub surface_loads: Vec<SurfaceLoad>,
}

impl Reports {
    /// Begins the sums of loads on walls anew, if they are wanted.
    pub(super) fn begin_wall_loads(&mut self, context: &StepContext<'_>) {
        self.wall_loads.clear();
        if context.wall_loads {
            self.wall_loads.resize(context.walls.len(), Load::default());
        }
    }
}

impl dyn ContactForces + '_ {
    /// The last observation, of so many walls; `records`: with those of the contacts, of which there are more than particles.
    #[must_use]
    pub fn observation(&self, walls: usize, records: bool) -> Observation {
        let mut sum = Observation::empty(walls);
        for reports in self.reports() {
            if records {
                sum.merge(&reports.observation);
            } else {
                sum.merge_sums(&reports.observation);
            }
        }
        sum
    }

    /// Force on a wall (N), stiffness (N/m) and damping (N s/m) of its contacts in the last observation: the exact sums over the blocks of this rank;
    /// `vertices`: and over those of the vertices of sheets.
    #[must_use]
    pub fn exact_load(&self, wall: usize, vertices: bool) -> [Exact; 5] {
        let blocks = self
            .own_reports(vertices)
            .into_iter()
            .filter_map(|reports| {
                let Observation {
                    walls,
                    wall_stiffness,
                    ..
                } = &reports.observation;
                let [x, y, z] = walls.get(wall)?.0.force.to_array();
                let WallStiffness { stiffness, damping } = *wall_stiffness.get(wall)?;
                Some([x, y, z, stiffness, damping])
            });
        exact(blocks)
    }

    /// The records of contacts of the last observation; they are removed from here.
    pub fn take_records(&mut self) -> Vec<ContactRecord> {
        let records = self.reports_mut().into_iter();
        let mut taken: Vec<_> = records
            .map(|reports| std::mem::take(&mut reports.observation.records))
            .filter(|records| !records.is_empty())
            .collect();
        if taken.len() == 1 {
            return taken.remove(0);
        }
        taken.concat()
    }

    /// The contacts that are beyond a limit; they are removed from here.
    pub fn take_alarms(&mut self) -> Alarms {
        let mut all = Alarms::default();
        for reports in self.reports_mut() {
            all.take_from(&mut reports.alarms);
        }
        all
    }

    /// The loads on features of mesh walls, in order; they are removed from here.
    pub fn take_feature_loads(&mut self) -> Vec<(FeatureKey, FeatureLoad)> {
        let mut all = FeatureLoads::default();
        for reports in self.reports_mut() {
            all.merge(&std::mem::take(&mut reports.feature_loads));
        }
        all.sorted()
    }

    /// Appends the contacts with walls that wear, block by block; they are removed from here.
    pub fn take_rubs(&mut self, all: &mut Vec<Rub>) {
        for reports in self.reports_mut() {
            all.append(&mut reports.rubs);
        }
    }

    /// Loads on walls in the last evaluation that summed them up, about their reference points, in the order of the plan.
    #[must_use]
    pub fn wall_loads(&self, walls: usize) -> Vec<Load> {
        let mut sums = vec![Load::default(); walls];
        for reports in self.reports() {
            for (sum, load) in sums.iter_mut().zip(&reports.wall_loads) {
                sum.add(load.force, load.torque);
            }
        }
        sums
    }

    /// Shows the loads of the contacts of the last evaluation on sheets, block by block, in the order of the rows.
    pub fn visit_surface_loads(&self, visit: &mut dyn FnMut(&SurfaceLoad)) {
        let reports = self.reports().into_iter();
        reports
            .flat_map(|reports| &reports.surface_loads)
            .for_each(visit);
    }

    /// The loads on features of mesh walls as they lie in the blocks.
    #[must_use]
    pub fn feature_loads(&self) -> Vec<SavedLoads> {
        let all = (0u32..).zip(self.reports());
        all.map(|(place, reports)| (place.checked_sub(1), reports.feature_loads.sorted()))
            .filter(|(_, loads)| !loads.is_empty())
            .collect()
    }

    /// Restores what `feature_loads` returned; called when pairs are restored.
    pub fn restore_feature_loads(&mut self, saved: &[SavedLoads]) {
        let mut reports = self.reports_mut();
        for (block, loads) in saved {
            let place = block.map_or(0, |block| block as usize + 1);
            if let Some(reports) = reports.get_mut(place) {
                let sums = &mut reports.feature_loads;
                loads.iter().for_each(|(key, load)| sums.add(*key, load));
            }
        }
    }
}
