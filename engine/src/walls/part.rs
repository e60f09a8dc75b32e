//! Loads on the triangles of meshes, summed from one file to the next.

use super::Mesh;
use crate::forces::{FeatureKey, FeatureLoad, LoadSums, Observation};
use crate::memory::GROWTH;
use crate::physics::Setup;
use crate::state::{Pieces, Plain};
use crate::step::{Core, Engine, MOST_STEPS, Part, RunError, SizeEstimate};

/// Sums since each series of files was written last: frames and files for ParaView have intervals of their own.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct LoadSeries {
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
    fn check(&self) -> Result<(), String> {
        let series = self.frames.evaluations.max(self.vtk.evaluations);
        if series.max(self.pending) > MOST_STEPS {
            return Err("more steps than a run can make".to_owned());
        }
        Ok(())
    }
}

impl Part for LoadSeries {
    fn name(&self) -> &str {
        "feature loads"
    }

    fn of(core: &mut Core) -> Option<Self> {
        let is_wanted = core.watched().triangle_loads;
        is_wanted.then(Self::default)
    }

    /// Sums of the contact loop and of each series, for as many features as particles may touch at once.
    fn bytes(setup: &Setup, crowd: &SizeEstimate) -> f64 {
        let watched = &setup.watched;
        if !watched.triangle_loads {
            return 0.0;
        }
        let meshes = setup.physics.walls.iter();
        let triangles: usize = meshes
            .filter_map(|wall| wall.shape.mesh())
            .map(Mesh::len)
            .sum();
        let series = watched.load_sums.iter().filter(|is_read| **is_read).count();
        let each = (1 + series) * size_of::<(FeatureKey, FeatureLoad)>();
        crowd.rows.min(triangles as f64) * GROWTH * each as f64
    }

    /// The new list begins with empty blocks: their loads go to those of earlier lists, which the first rank has.
    fn before_list(&mut self, core: &mut Core) -> Result<(), RunError> {
        core.move_feature_loads();
        Ok(())
    }

    fn after_forces(&mut self, _: &mut Core, _: Option<&Observation>) {
        self.pending += 1;
    }

    fn works_on_ranks(&self) -> bool {
        true
    }

    fn collect_from_ranks(&mut self, core: &mut Core) {
        core.collect_feature_loads();
    }

    fn put(&self, core: &Core, pieces: &mut Pieces) {
        // Those that still lie in the blocks, and those taken from there.
        core.contacts.feature_loads().put(pieces.end());
        Plain::put(self, pieces.end());
    }

    fn take(&mut self, core: &mut Core, bytes: &mut &[u8]) -> Result<(), String> {
        let in_blocks: Vec<_> = Plain::take(bytes)?;
        core.contacts.restore_feature_loads(&in_blocks);
        *self = Plain::take(bytes)?;
        self.check()
    }
}

impl Engine {
    /// Loads on the features of mesh walls, summed over the force evaluations since the last reading: for a frame, and for the
    /// files for ParaView. Empty where it is neither read nor planned.
    pub fn take_load_sums(&mut self, frame: bool, vtk: bool) -> [Option<LoadSums>; 2] {
        if !(frame || vtk) {
            return [None, None];
        }
        if self.part::<LoadSeries>().is_none() {
            return [None, None];
        }
        let loads = self.take_feature_loads();
        let Some((series, core)) = self.part_and_core::<LoadSeries>() else {
            return [None, None];
        };
        let [for_frames, for_vtk] = core.watched().load_sums;
        let evaluations = std::mem::take(&mut series.pending);
        if for_frames {
            series.frames.add(evaluations, &loads);
        }
        if for_vtk {
            series.vtk.add(evaluations, &loads);
        }
        [
            (frame && for_frames).then(|| std::mem::take(&mut series.frames)),
            (vtk && for_vtk).then(|| std::mem::take(&mut series.vtk)),
        ]
    }
}

crate::state::plain!(LoadSeries {
    pending,
    frames,
    vtk
});
