//! `<prefix>.membranes.csv`, `.holds.csv`, `.membranes.arrow` and `.membrane_triangles.arrow`: elastic sheets in all, by holds, by vertices and by
//! triangles.

use glam::DVec3;
use mercury_common::frames::{
    MembraneFrame, MembraneTriangleFrame, MembraneTriangleWriter, MembraneWriter, VERTEX_HELD,
};
use mercury_common::run_tables::{HOLDS, MEMBRANES, TableSpec};
use mercury_pictures::SheetEnergies;

use crate::output::stream::{Beginning, Sink, Stream, StreamKind};
use crate::output::table_file::{Rows, RunTable};
use crate::output::{FrameCopy, OutputError};
use crate::plan::Plan;
use mercury_engine::membrane::{HoldLoad, MembraneNow, MembranePlan};
use mercury_engine::step::Engine;
use mercury_engine::surface::Surface;

/// Elastic sheets at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct MembraneState {
    /// The numbers of each sheet behind its name, in the order of the file.
    pub rows: Vec<[f64; 30]>,
    /// Loads of each sheet on its holds.
    pub holds: Vec<Vec<HoldLoad>>,
    /// Vertices.
    pub vertices: MembraneFrame,
    /// Triangles.
    pub triangles: MembraneTriangleFrame,
}

/// Energies of one sheet, J.
fn energies(
    (plan, surface, membrane): (&MembranePlan, &Surface, &MembraneNow),
    gravity: DVec3,
) -> SheetEnergies {
    let mut sum = SheetEnergies {
        stretching: plan.sheet.stretching_energy(&surface.positions),
        bending: plan.sheet.bending_energy(&surface.positions),
        dissipated: membrane.works.dissipated,
        pressure_work: membrane.works.pressure,
        hold_work: membrane.works.holds,
        ..SheetEnergies::default()
    };
    let vertices = surface.positions.iter().zip(&surface.velocities);
    for ((position, velocity), mass) in vertices.zip(plan.sheet.masses()) {
        sum.kinetic += 0.5 * mass * velocity.length_squared();
        sum.gravitational -= mass * gravity.dot(*position);
    }
    sum
}

fn all(engine: &Engine) -> impl Iterator<Item = (&MembranePlan, &Surface, &MembraneNow)> {
    let plans = engine.physics().plans.all().iter();
    let sheets = plans.zip(engine.surfaces()).zip(engine.membranes());
    sheets.map(|((plan, surface), membrane)| (plan, surface, membrane))
}

/// Energies of all sheets, J.
pub(crate) fn sheet_energies(engine: &Engine) -> SheetEnergies {
    let gravity = engine.physics().gravity;
    let mut sum = SheetEnergies::default();
    for sheet in all(engine) {
        let of_one = energies(sheet, gravity);
        sum.kinetic += of_one.kinetic;
        sum.gravitational += of_one.gravitational;
        sum.stretching += of_one.stretching;
        sum.bending += of_one.bending;
        sum.dissipated += of_one.dissipated;
        sum.pressure_work += of_one.pressure_work;
        sum.hold_work += of_one.hold_work;
    }
    sum
}

impl MembraneState {
    /// Of an engine whose step is complete; `None` where there are no sheets.
    #[must_use]
    pub fn of(engine: &Engine) -> Option<Self> {
        if engine.membranes().is_empty() {
            return None;
        }
        let (time, step) = (engine.time(), engine.steps());
        let mut new = Self {
            rows: Vec::new(),
            holds: Vec::new(),
            vertices: MembraneFrame {
                time,
                step,
                ..MembraneFrame::default()
            },
            triangles: MembraneTriangleFrame {
                time,
                step,
                ..MembraneTriangleFrame::default()
            },
        };
        let gravity = engine.physics().gravity;
        for (number, sheet) in all(engine).enumerate() {
            new.rows.push(row(sheet, gravity));
            new.holds.push(sheet.2.hold_loads.clone());
            new.add_tables(number as u32, sheet, gravity);
        }
        Some(new)
    }

    fn add_tables(
        &mut self,
        number: u32,
        (plan, surface, membrane): (&MembranePlan, &Surface, &MembraneNow),
        gravity: DVec3,
    ) {
        let vertices = &mut self.vertices;
        for (k, &mass) in plan.sheet.masses().iter().enumerate() {
            vertices.membrane.push(number);
            vertices.vertex.push(k as u32);
            vertices
                .state
                .push(if membrane.is_held(k) { VERTEX_HELD } else { 0 });
            vertices.mass.push(mass);
            vertices.position.push(surface.positions[k]);
            vertices.velocity.push(surface.velocities[k]);
            vertices.force.push(surface.forces[k] + mass * gravity);
        }
        let triangles = &mut self.triangles;
        for (k, corners) in plan.sheet.topology().triangles().iter().enumerate() {
            let seen = plan.sheet.triangle(k, &surface.positions);
            triangles.membrane.push(number);
            triangles.triangle.push(k as u32);
            for (list, &corner) in triangles.corners.iter_mut().zip(corners) {
                list.push(corner);
            }
            triangles.area.push(seen.area);
            for (list, tension) in triangles.tensions.iter_mut().zip(seen.principal) {
                list.push(tension);
            }
            triangles.load.push(surface.triangle_loads[k]);
        }
    }
}

/// The numbers of a sheet in the order of the file.
fn row(sheet: (&MembranePlan, &Surface, &MembraneNow), gravity: DVec3) -> [f64; 30] {
    let (plan, surface, membrane) = sheet;
    let seen = plan.sheet.seen(&surface.positions);
    let volume = plan.sheet.enclosed(&surface.positions).volume;
    let (mut mass, mut centre, mut momentum) = (0.0, DVec3::ZERO, DVec3::ZERO);
    let (mut force, mut torque) = (DVec3::ZERO, DVec3::ZERO);
    for (k, &of_vertex) in plan.sheet.masses().iter().enumerate() {
        mass += of_vertex;
        centre += of_vertex * surface.positions[k];
        momentum += of_vertex * surface.velocities[k];
        force += surface.loads[k];
        torque += surface.positions[k].cross(surface.loads[k]);
    }
    let energies = energies(sheet, gravity);
    let [x, y, z] = (centre / mass).to_array();
    let [vx, vy, vz] = (momentum / mass).to_array();
    let ([fx, fy, fz], [tx, ty, tz]) = (force.to_array(), torque.to_array());
    let [nxx, nyy, nzz, nxy, nxz, nyz] = seen.tension.0;
    [
        seen.area,
        volume,
        membrane.pressure,
        x,
        y,
        z,
        vx,
        vy,
        vz,
        fx,
        fy,
        fz,
        tx,
        ty,
        tz,
        nxx,
        nyy,
        nzz,
        nxy,
        nxz,
        nyz,
        energies.kinetic,
        energies.gravitational,
        energies.stretching,
        energies.bending,
        energies.dissipated,
        energies.pressure_work,
        energies.hold_work,
        seen.least_stretch,
        seen.largest_stretch,
    ]
}

/// A row for each sheet and each output interval.
pub(crate) struct MembraneCsv {
    names: Vec<String>,
}

/// Numbers without the sign of zeros.
fn unsigned_zeros(numbers: impl IntoIterator<Item = f64>) -> impl Iterator<Item = f64> {
    numbers.into_iter().map(|number| number + 0.0)
}

impl RunTable for MembraneCsv {
    const SPEC: &'static TableSpec = &MEMBRANES;

    fn is_wanted(plan: &Plan) -> bool {
        plan.physics().plans.get::<MembranePlan>().is_some()
    }

    fn new(plan: &Plan) -> Self {
        let sheets = plan.physics().plans.all::<MembranePlan>().iter();
        Self {
            names: sheets.map(|sheet| sheet.surface.name.clone()).collect(),
        }
    }

    fn push_rows(&self, state: &FrameCopy, rows: &mut Rows<'_>) {
        let Some(membranes) = &state.membranes else {
            return;
        };
        for (name, row) in self.names.iter().zip(&membranes.rows) {
            rows.number(state.time).text(name);
            rows.numbers(unsigned_zeros(*row)).end();
        }
    }
}

/// A row for each hold and each output interval.
pub(crate) struct HoldCsv {
    /// Name of each sheet, and those of its holds.
    names: Vec<(String, Vec<String>)>,
}

impl RunTable for HoldCsv {
    const SPEC: &'static TableSpec = &HOLDS;

    fn is_wanted(plan: &Plan) -> bool {
        let mut membranes = plan.physics().plans.all::<MembranePlan>().iter();
        membranes.any(|membrane| !membrane.holds.is_empty())
    }

    fn new(plan: &Plan) -> Self {
        let sheets = plan.physics().plans.all::<MembranePlan>().iter();
        let names = sheets.map(|membrane| {
            let holds = membrane.holds.iter().map(|hold| hold.name.clone());
            (membrane.surface.name.clone(), holds.collect())
        });
        Self {
            names: names.collect(),
        }
    }

    fn push_rows(&self, state: &FrameCopy, rows: &mut Rows<'_>) {
        let Some(membranes) = &state.membranes else {
            return;
        };
        for ((membrane, names), loads) in self.names.iter().zip(&membranes.holds) {
            for (name, load) in names.iter().zip(loads) {
                rows.number(state.time).text(membrane).text(name);
                rows.numbers(unsigned_zeros(load.force.to_array()));
                rows.numbers(unsigned_zeros(load.torque.to_array()));
                rows.numbers(unsigned_zeros([load.power])).end();
            }
        }
    }
}

pub(crate) struct MembraneFrames {
    writer: MembraneWriter,
}

impl StreamKind for MembraneFrames {
    const NAME: &'static str = "membranes.arrow";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().frames && plan.physics().plans.get::<MembranePlan>().is_some()
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let writer = run.frames(Self::NAME, &())?;
        Ok(Self { writer })
    }
}

impl Stream for MembraneFrames {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
        if let (Some(membranes), true) = (&state.membranes, state.due.frame) {
            self.writer.append(membranes.vertices.clone())?;
        }
        Ok(())
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Frames(self.writer.frames())
    }
}

pub(crate) struct MembraneTriangles {
    writer: MembraneTriangleWriter,
}

impl StreamKind for MembraneTriangles {
    const NAME: &'static str = "membrane_triangles.arrow";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().frames && plan.physics().plans.get::<MembranePlan>().is_some()
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let writer = run.frames(Self::NAME, &())?;
        Ok(Self { writer })
    }
}

impl Stream for MembraneTriangles {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
        if let (Some(membranes), true) = (&state.membranes, state.due.frame) {
            self.writer.append(membranes.triangles.clone())?;
        }
        Ok(())
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Frames(self.writer.frames())
    }
}
