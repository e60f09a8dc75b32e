//! Loads on the triangles of meshes, summed from one file to the next.

use super::Engine;
use super::snapshot::MOST_STEPS;
use crate::forces::LoadSums;

/// Sums since each series of files was written last: frames and files for ParaView have intervals of their own.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LoadSeries {
    /// Force evaluations whose loads are still in the blocks.
    pending: u64,
    frames: LoadSums,
    vtk: LoadSums,
}

impl LoadSeries {
    /// Whether a run can have counted so many evaluations.
    ///
    /// # Errors
    /// If not.
    pub(super) fn check(&self) -> Result<(), String> {
        let series = self.frames.evaluations.max(self.vtk.evaluations);
        if series.max(self.pending) > MOST_STEPS {
            return Err("more steps than a run can make".to_owned());
        }
        Ok(())
    }

    /// A force evaluation was made.
    pub(super) fn note_evaluation(&mut self) {
        self.pending += 1;
    }
}

impl Engine {
    /// Loads on the features of mesh walls, summed over the force evaluations since the last reading: for a frame, and for the
    /// files for ParaView. Empty where it is neither read nor planned.
    pub fn take_load_sums(&mut self, frame: bool, vtk: bool) -> [Option<LoadSums>; 2] {
        let output = self.plan.outputs().files();
        if !output.triangle_loads || !(frame || vtk) {
            return [None, None];
        }
        let loads = self.forces.contacts.take_feature_loads();
        let series = &mut self.load_series;
        let evaluations = std::mem::take(&mut series.pending);
        if output.frames {
            series.frames.add(evaluations, &loads);
        }
        if output.vtk {
            series.vtk.add(evaluations, &loads);
        }
        [
            (frame && output.frames).then(|| std::mem::take(&mut series.frames)),
            (vtk && output.vtk).then(|| std::mem::take(&mut series.vtk)),
        ]
    }
}

crate::state::plain!(LoadSeries {
    pending,
    frames,
    vtk
});
