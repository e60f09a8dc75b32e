//! `<prefix>.triangle_loads.arrow`: mean loads on the triangles of mesh walls.

use std::sync::Arc;

use glam::DVec3;
use mercury_common::frames::{TriangleLoadFrame, TriangleLoadWriter};

use super::stream::{Beginning, Sink, Stream, StreamKind};
use super::{FrameCopy, OutputError};
use crate::plan::Plan;
use mercury_engine::forces::{FeatureLoad, LoadSums};
use mercury_engine::walls::{Mesh, Shape};

pub(super) struct TriangleLoads {
    writer: TriangleLoadWriter,
    table: TriangleTable,
}

impl StreamKind for TriangleLoads {
    const NAME: &'static str = "triangle_loads.arrow";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().frames && plan.outputs().files().triangle_loads
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let plan = run.plan;
        Ok(Self {
            writer: run.frames(Self::NAME, &())?,
            table: TriangleTable::new(plan),
        })
    }
}

impl Stream for TriangleLoads {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
        if let ([Some(sums), _], true) = (&state.load_sums, state.due.frame) {
            self.writer.append(self.table.frame(state, sums))?;
        }
        Ok(())
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Frames(self.writer.frames())
    }
}

/// The meshes among the walls with the areas of their triangles.
pub(super) struct TriangleTable {
    meshes: Vec<Option<(Arc<Mesh>, Vec<f64>)>>,
    time_step: f64,
}

impl TriangleTable {
    pub(super) fn new(plan: &Plan) -> Self {
        let mesh = |shape: &Shape| match shape {
            Shape::Mesh(mesh) => Some((Arc::clone(mesh), mesh.areas())),
            _ => None,
        };
        Self {
            meshes: plan
                .physics()
                .walls
                .iter()
                .map(|wall| mesh(&wall.shape))
                .collect(),
            time_step: plan.physics().time_step,
        }
    }

    /// Means over the force evaluations of `sums`, directions as the walls stand now. Loads through an edge or corner are shared
    /// out evenly to the triangles that meet there.
    pub(super) fn frame(&self, state: &FrameCopy, sums: &LoadSums) -> TriangleLoadFrame {
        let mut frame = TriangleLoadFrame {
            time: state.time,
            step: state.step,
            ..TriangleLoadFrame::default()
        };
        let each = 1.0 / sums.evaluations.max(1) as f64;
        let mut around = Vec::new();
        for (wall, mesh) in self.meshes.iter().enumerate() {
            let Some((mesh, areas)) = mesh else {
                continue;
            };
            let mut loads: Vec<Option<FeatureLoad>> = vec![None; areas.len()];
            let of_wall = (wall as u16, 0)..=(wall as u16, u32::MAX);
            for (&(_, feature), load) in sums.loads.range(of_wall) {
                mesh.triangles_of(feature, &mut around);
                let share = load.times(each / around.len().max(1) as f64);
                for &triangle in &around {
                    loads[triangle as usize].get_or_insert_default().add(&share);
                }
            }
            let pose = state.walls.get(wall).map(|wall| wall.pose.rotation);
            let turned = |x: DVec3| pose.map_or(x, |turn| turn * x);
            for (triangle, load) in (0u32..).zip(&loads) {
                let Some(load) = load else {
                    continue;
                };
                let area = areas[triangle as usize];
                frame.wall.push(wall as u32);
                frame.triangle.push(triangle);
                frame.pressure.push(load.normal / area);
                frame.shear.push(turned(load.shear) / area);
                frame.force.push(turned(load.force));
                frame.slip_power.push(load.slip / (self.time_step * area));
            }
        }
        frame
    }
}
