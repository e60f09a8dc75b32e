//! `vtk/`: particles, contacts, bonds, walls and bodies as series of `.vtu` files with their `.pvd`, for ParaView while the run goes on.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::DVec3;
use mercury_common::formats::vtu::{VtuError, VtuOptions};
use mercury_common::frames::{
    BodyFrame, ColumnSpec, ContactColumns, ContactFrame, ParticleFrame, Table,
};
use mercury_common::paraview::{self, ScriptParts, Series, WallScene};
use mercury_common::surfaces::Surface;
use mercury_common::whole_file::{FileError, write_whole};

use super::body_frames::BodyTable;
use super::contact_frames::{contact_columns, contact_frame};
use super::folder::VTK;
use super::particle_frames::ParticleTable;
use super::stream::{Beginning, Sink, Stream, StreamKind};
use super::triangle_loads::TriangleTable;
use super::wall_frames::{surfaces, wall_frame};
use super::{FrameCopy, OutputError};
use crate::bonds::output::bond_frame;
use crate::plan::Plan;
use mercury_engine::bonds::BondPlan;
use mercury_engine::membrane::MembranePlan;

/// One thread writes: the others are busy with stepping.
const OPTIONS: VtuOptions = VtuOptions {
    parallel: false,
    ..VtuOptions::DEFAULT
};

pub(super) struct VtkFiles {
    folder: PathBuf,
    frames: usize,
    /// Since the last call.
    made: Vec<PathBuf>,
    particles: Series,
    table: ParticleTable,
    particle_columns: Vec<ColumnSpec>,
    contacts: Series,
    contact_columns: ContactColumns,
    walls: Option<Walls>,
    membranes: Option<Series>,
    bodies: Option<Bodies>,
    bonds: Option<Series>,
}

struct Walls {
    series: Series,
    names: Vec<String>,
    surfaces: Vec<Surface>,
    domain: (DVec3, DVec3),
    triangles: TriangleTable,
}

/// Centres of mass; the surfaces of bodies are made from the frames afterwards (`mercury-export vtu --clumps surface`).
struct Bodies {
    series: Series,
    table: BodyTable,
}

impl StreamKind for VtkFiles {
    const NAME: &'static str = VTK;

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().vtk
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let plan = run.plan;
        let folder = run.folder.join(VTK);
        let made = std::fs::create_dir_all(&folder);
        made.map_err(FileError::of(&folder, "the folder cannot be made"))?;
        let series = |kind: &str| -> Result<Series, VtuError> {
            let name = format!("{}.{kind}", plan.outputs().prefix());
            match run.at {
                None => Series::create(&folder, &name, OPTIONS),
                Some(frames) => Series::resume(&folder, &name, OPTIONS, frames as usize),
            }
        };
        let walls = (!plan.physics().walls.is_empty()).then(|| {
            Ok::<_, VtuError>(Walls {
                series: series("walls")?,
                names: plan
                    .physics()
                    .walls
                    .iter()
                    .map(|wall| wall.name.clone())
                    .collect(),
                surfaces: surfaces(plan),
                domain: plan.physics().cell.corners(),
                triangles: TriangleTable::new(plan),
            })
        });
        let bodies = plan.physics().has_bodies().then(|| {
            Ok::<_, VtuError>(Bodies {
                series: series("bodies")?,
                table: BodyTable::new(plan),
            })
        });
        let bonds = plan.physics().plans.get::<BondPlan>();
        let bonds = bonds.map(|_| series("bonds")).transpose()?;
        let parts = ScriptParts {
            bridges: false,
            bonds: bonds.is_some(),
            droplets: false,
            particles: true,
            contacts: true,
            walls: walls.is_some(),
            bodies: plan.physics().has_bodies(),
            clumps: false,
            membranes: plan.physics().plans.get::<MembranePlan>().is_some(),
        };
        let script = folder.join(format!("{}.paraview.py", plan.outputs().prefix()));
        write_whole(
            &script,
            paraview::script(plan.outputs().prefix(), parts).as_bytes(),
        )?;
        let table = ParticleTable::new(plan);
        let mut particle_columns = ParticleFrame::specs(&table.columns);
        if plan.physics().has_bodies() {
            particle_columns.push(paraview::clump_spec());
        }
        Ok(Self {
            frames: run.at.unwrap_or(0) as usize,
            made: Vec::new(),
            particles: series("particles")?,
            particle_columns,
            table,
            contacts: series("contacts")?,
            contact_columns: contact_columns(plan, run.history),
            walls: walls.transpose()?,
            membranes: (plan.physics().plans.get::<MembranePlan>())
                .map(|_| series("membranes"))
                .transpose()?,
            bodies: bodies.transpose()?,
            bonds,
            folder,
        })
    }
}

fn unfit(folder: &Path, reason: String) -> VtuError {
    VtuError::Grid {
        path: folder.to_owned(),
        reason,
    }
}

impl Stream for VtkFiles {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
        if !state.due.vtk {
            return Ok(());
        }
        let number = self.frames;
        self.frames += 1;
        if let Some(walls) = &mut self.walls {
            let scene = WallScene {
                names: &walls.names,
                surfaces: &walls.surfaces,
                domain: walls.domain,
            };
            let [_, sums] = &state.load_sums;
            let loads = sums.as_ref().map(|sums| walls.triangles.frame(state, sums));
            let wear = state.wear.as_ref().map(|wear| &wear.vertices);
            let grid = paraview::walls(&scene, &wall_frame(state), loads.as_ref(), wear);
            let grid = grid.map_err(|reason| VtuError::Grid {
                path: self.folder.clone(),
                reason,
            })?;
            walls.series.write(number, &grid)?;
        }
        if let (Some(series), Some(sheets)) = (&mut self.membranes, &state.membranes) {
            let grid = paraview::membranes(&sheets.vertices, &sheets.triangles);
            let grid = grid.map_err(|reason| VtuError::Grid {
                path: self.folder.clone(),
                reason,
            })?;
            series.write(number, &grid)?;
        }
        if let Some(series) = &mut self.bonds {
            series.write(number, &paraview::bonds(&bond_frame(state)))?;
        }
        let centres: HashMap<u32, DVec3> = state
            .ids
            .iter()
            .zip(&state.particles)
            .map(|(&id, particle)| (id, particle.position))
            .collect();
        let frame = contact_frame(state, &self.contact_columns).into_frame();
        let grid = paraview::contacts(&ContactFrame::specs(&self.contact_columns), frame, &centres)
            .map_err(|reason| unfit(&self.folder, reason))?;
        self.contacts.write(number, &grid)?;
        let particles = self.table.frame(state);
        let mut clumps = None;
        if let Some(bodies) = &mut self.bodies {
            let frame = bodies.table.frame(state);
            let body = particles.body.as_deref().unwrap_or_default();
            clumps = Some(paraview::clump_column(body, &frame.id, &frame.clump));
            let frame = frame.into_frame();
            let grid = paraview::particles(&BodyFrame::specs(&Vec::new()), frame);
            let grid = grid.map_err(|reason| unfit(&self.folder, reason))?;
            bodies.series.write(number, &grid)?;
        }
        let mut frame = particles.into_frame();
        frame.columns.extend(clumps);
        let grid = paraview::particles(&self.particle_columns, frame)
            .map_err(|reason| unfit(&self.folder, reason))?;
        self.particles.write(number, &grid)?;
        let walls = self.walls.iter().map(|walls| &walls.series);
        let bodies = self.bodies.iter().map(|bodies| &bodies.series);
        let series = [&self.particles, &self.contacts].into_iter();
        let names = series
            .chain(&self.bonds)
            .chain(walls)
            .chain(bodies)
            .map(|series| series.file_name(number));
        self.made.extend(names.map(|name| self.folder.join(name)));
        Ok(())
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Whole(self.frames as u64)
    }

    fn made(&mut self) -> Vec<PathBuf> {
        std::mem::take(&mut self.made)
    }
}
