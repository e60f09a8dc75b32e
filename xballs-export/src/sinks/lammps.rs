//! For people with data from or for LAMMPS and LIGGGHTS: a text dump of all frames, and one frame as a data file.

use glam::DVec3;
use mercury_common::formats::number::{NumberStyle, push_number, push_numbers};
use mercury_common::frames::Column;
use mercury_common::readable::rounded;

use super::density::Digits;
use super::{Encode, FilePerFrame, OneFile};
use crate::output::Output;
use crate::{ExportError, Snapshot};

/// Columns of a frame that every writer of this module needs.
struct Rows<'a> {
    ids: &'a [u32],
    /// Types count from 1.
    types: Vec<u32>,
    radius: &'a [f64],
    position: Vec<DVec3>,
    velocity: Vec<DVec3>,
    angular_velocity: Vec<DVec3>,
}

impl<'a> Rows<'a> {
    fn of(snapshot: &'a Snapshot) -> Result<Self, ExportError> {
        let missing = |name: &str| {
            let path = snapshot.path.display();
            ExportError::Input(format!("{path}: no column `{name}`"))
        };
        let ids = snapshot.column("id").and_then(Column::as_u32);
        let ids = ids.ok_or_else(|| missing("id"))?;
        let vectors = |names: [&str; 3]| snapshot.vectors(names);
        let none = || vec![DVec3::ZERO; ids.len()];
        let material = snapshot.column("material").and_then(Column::as_u32);
        Ok(Self {
            ids,
            types: material.map_or_else(
                || vec![1; ids.len()],
                |all| all.iter().map(|k| k.saturating_add(1)).collect(),
            ),
            radius: snapshot.numbers("radius")?,
            position: vectors(["x", "y", "z"]).ok_or_else(|| missing("x"))?,
            velocity: vectors(["vx", "vy", "vz"]).unwrap_or_else(none),
            angular_velocity: vectors(["wx", "wy", "wz"]).unwrap_or_else(none),
        })
    }

    /// Names of atoms count from 1 there.
    fn id(&self, row: usize) -> f64 {
        f64::from(self.ids[row]) + 1.0
    }
}

/// Beyond these there is round-off of a quotient or a sum.
const DIGITS: usize = 12;

fn push_line(out: &mut Vec<u8>, values: &[f64]) {
    push_numbers(out, values, NumberStyle::Shortest);
    out.push(b'\n');
}

/// Appends a frame in LAMMPS' text dump format: `id type x y z vx vy vz radius omegax omegay omegaz` and, where the frame has
/// them, `mass`, `fx fy fz` and `mol`: the body of a pebble, 0 for a sphere of its own. Ids, types and bodies count from 1.
///
/// # Errors
/// When the frame has no ids, radii or positions.
pub fn push_dump(snapshot: &Snapshot, out: &mut Vec<u8>) -> Result<(), ExportError> {
    let rows = Rows::of(snapshot)?;
    let (min, max) = snapshot.domain()?;
    let periodic = snapshot.header.periodic;
    let bounds = periodic.map(|p| if p { "pp" } else { "ff" }).join(" ");
    let mut put = |text: &str| out.extend_from_slice(text.as_bytes());
    put("ITEM: TIMESTEP\n");
    put(&format!("{}\n", snapshot.frame.step));
    put(&format!("ITEM: NUMBER OF ATOMS\n{}\n", rows.ids.len()));
    put(&format!("ITEM: BOX BOUNDS {bounds}\n"));
    for axis in 0..3 {
        push_line(out, &[min[axis], max[axis]]);
    }
    let mass = snapshot.numbers("mass").ok();
    let force = snapshot.vectors(["fx", "fy", "fz"]);
    out.extend_from_slice(b"ITEM: ATOMS id type x y z vx vy vz radius omegax omegay omegaz");
    if mass.is_some() {
        out.extend_from_slice(b" mass");
    }
    if force.is_some() {
        out.extend_from_slice(b" fx fy fz");
    }
    let body = match snapshot.column("body") {
        Some(Column::OptionalU32(body)) => Some(body),
        _ => None,
    };
    if body.is_some() {
        out.extend_from_slice(b" mol");
    }
    out.push(b'\n');
    let mut values = Vec::new();
    for row in 0..rows.ids.len() {
        values.clear();
        values.extend([rows.id(row), f64::from(rows.types[row])]);
        values.extend(rows.position[row].to_array());
        values.extend(rows.velocity[row].to_array());
        values.push(rows.radius[row]);
        values.extend(rows.angular_velocity[row].to_array());
        values.extend(mass.map(|mass| mass[row]));
        values.extend(force.iter().flat_map(|force| force[row].to_array()));
        values.extend(body.map(|body| body[row].map_or(0.0, |body| f64::from(body) + 1.0)));
        push_line(out, &values);
    }
    Ok(())
}

/// `<prefix>.lammpstrj` with all selected frames, as [`push_dump`] writes them.
///
/// # Errors
/// When the file is there already and may not be replaced, or cannot be made.
pub fn dump(output: &Output) -> Result<OneFile<impl Encode>, ExportError> {
    OneFile::begin(output, "lammpstrj", push_dump)
}

/// Appends a frame as a data file for `read_data` with `atom_style sphere` (LAMMPS) or `granular` (LIGGGHTS): atoms as `id type diameter
/// density x y z`, and velocities as `id vx vy vz omegax omegay omegaz`. The density is mass over volume; `density`
/// replaces it where the input has no masses.
///
/// # Errors
/// When the frame has no ids, radii or positions, or neither masses nor a density is known.
pub fn push_data_file(
    snapshot: &Snapshot,
    density: Option<Density>,
    out: &mut Vec<u8>,
) -> Result<(), ExportError> {
    let rows = Rows::of(snapshot)?;
    let (min, max) = snapshot.domain()?;
    let pair = (snapshot.numbers("mass"), snapshot.numbers("volume"));
    let densities: Vec<f64> = match (density, pair) {
        (Some(Density(density)), _) => vec![density; rows.ids.len()],
        (None, (Ok(mass), Ok(volume))) => {
            // A density that was given with few digits gets them back.
            let digits = Digits::of(snapshot);
            let pairs = mass.iter().zip(volume.iter());
            pairs.map(|(&m, &v)| digits.density(m, v)).collect()
        }
        (None, _) => {
            let path = snapshot.path.display();
            return Err(ExportError::Input(format!(
                "{path}: the input has no masses\nhelp: give the density of the particles with --density, in kg/m^3"
            )));
        }
    };
    let types = rows.types.iter().copied().max().unwrap_or(1);
    let title = snapshot.header.title.replace(['\n', '\r'], " ");
    let mut put = |text: String| out.extend_from_slice(text.as_bytes());
    put(format!(
        "{title} (t = {} s, SI units)\n\n",
        rounded(snapshot.frame.time, DIGITS)
    ));
    put(format!("{} atoms\n{types} atom types\n\n", rows.ids.len()));
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        push_numbers(out, &[min[axis], max[axis]], NumberStyle::Shortest);
        out.extend_from_slice(format!(" {name}lo {name}hi\n").as_bytes());
    }
    out.extend_from_slice(b"\nAtoms\n\n");
    for (row, density) in densities.into_iter().enumerate() {
        let [x, y, z] = rows.position[row].to_array();
        let diameter = 2.0 * rows.radius[row];
        let kind = f64::from(rows.types[row]);
        push_line(out, &[rows.id(row), kind, diameter, density, x, y, z]);
    }
    out.extend_from_slice(b"\nVelocities\n\n");
    for row in 0..rows.ids.len() {
        push_number(out, rows.id(row), NumberStyle::Shortest);
        out.push(b' ');
        push_numbers(out, &rows.velocity[row].to_array(), NumberStyle::Shortest);
        out.push(b' ');
        push_line(out, &rows.angular_velocity[row].to_array());
    }
    Ok(())
}

/// A density for inputs without masses, kg/m^3: positive and finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Density(f64);

impl Density {
    /// From a number in kg/m^3.
    ///
    /// # Errors
    /// When it is not positive and finite.
    pub fn new(density: f64) -> Result<Self, ExportError> {
        if density > 0.0 && density.is_finite() {
            return Ok(Self(density));
        }
        let message = format!("--density {density}: expected a positive number, in kg/m^3");
        Err(ExportError::Input(message))
    }
}

/// `<prefix>.0000.lmp`, ...: every selected frame as [`push_data_file`] writes it.
pub fn data_files(output: &Output, density: Option<Density>) -> FilePerFrame<'_, impl Encode> {
    let encode =
        move |snapshot: &Snapshot, out: &mut Vec<u8>| push_data_file(snapshot, density, out);
    FilePerFrame::new(output, "lmp", encode)
}
