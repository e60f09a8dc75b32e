//! Data files, which `read_data` reads: a title, counts and bounds, then sections.

use std::collections::HashMap;
use std::io::BufRead;

use glam::DVec3;
use mercury_common::error::FormatError;
use mercury_common::formats::lines::{LineReader, Tokens};

use super::{Grains, MOST_IDS, MOST_TYPES};

/// Where the columns of `Atoms` stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Style {
    /// `id type diameter density x y z`: sphere of LAMMPS, granular and sphere of LIGGGHTS.
    Sphere,
    /// `id type x y z diameter density`: hybrid with one of these first.
    Hybrid,
}

/// Counts of other codes than these: none of them may be there.
const FOREIGN: [&str; 4] = ["ellipsoids", "lines", "triangles", "bodies"];

/// Reads the whole file.
pub(super) fn read<R: BufRead>(mut lines: LineReader<R>) -> Result<Grains, FormatError> {
    let mut grains = Grains::default();
    let mut header = Header::default();
    let mut more = lines.advance()?;
    // The first line is the title, whatever its text; an empty one was passed over.
    if more && lines.line_number() == 1 {
        grains.title = lines.line().trim().to_owned();
        more = lines.advance()?;
    }
    let mut velocities = None;
    let mut has_atoms = false;
    while more {
        if lines.is_comment() {
            more = lines.advance()?;
            continue;
        }
        let line = lines.line().trim().to_owned();
        let (text, remark) = line.split_once('#').unwrap_or((&line, ""));
        let begins_with_letter = text.starts_with(|c: char| c.is_ascii_alphabetic());
        if !begins_with_letter {
            header.line(&lines)?;
            more = lines.advance()?;
            continue;
        }
        match text.trim() {
            "Atoms" if has_atoms => return Err(wrong(&lines, "a second section Atoms", "one")),
            "Atoms" => {
                let style = style(&lines, remark.trim())?;
                atoms(&mut lines, &header, style, &mut grains)?;
                grains.sort().map_err(|id| {
                    FormatError::of_file(
                        lines.path(),
                        format!("the atom {id} occurs twice in Atoms"),
                    )
                })?;
                has_atoms = true;
                more = lines.advance()?;
            }
            "Velocities" if !has_atoms => {
                return Err(wrong(
                    &lines,
                    "Velocities before Atoms",
                    "the section Atoms first",
                ));
            }
            "Velocities" => {
                velocities = Some(read_velocities(&mut lines, &header, &grains)?);
                more = lines.advance()?;
            }
            _ => more = pass_over(&mut lines)?,
        }
    }
    if !has_atoms {
        let error = FormatError::of_file(lines.path(), "no section Atoms");
        return Err(error.with_help("a data file as read_data reads it has a line `Atoms`, an empty one, and a line for each sphere"));
    }
    if let Some((velocity, spin)) = velocities {
        grains.velocity = Some(velocity);
        grains.angular_velocity = Some(spin);
    }
    grains.domain = header.domain(&lines)?;
    Ok(grains)
}

fn wrong<R: BufRead>(lines: &LineReader<R>, found: &str, expected: &str) -> FormatError {
    FormatError::at(lines.path(), lines.line_number(), None, found, expected)
}

/// Counts and bounds.
#[derive(Debug, Default)]
struct Header {
    atoms: Option<u64>,
    bounds: [Option<[f64; 2]>; 3],
}

impl Header {
    fn line<R: BufRead>(&mut self, lines: &LineReader<R>) -> Result<(), FormatError> {
        let words: Vec<&str> = lines
            .line()
            .split('#')
            .next()
            .unwrap_or("")
            .split_whitespace()
            .collect();
        let mut tokens = lines.tokens();
        match words[..] {
            [_, "atoms"] => {
                let count = tokens.integer("the number of atoms")?;
                let count = u64::try_from(count)
                    .ok()
                    .filter(|count| *count < MOST_IDS as u64);
                self.atoms = Some(count.ok_or_else(|| {
                    wrong(
                        lines,
                        lines.line().trim(),
                        "a number of atoms from 0 to 4e9",
                    )
                })?);
            }
            [_, _, low, high] if low.ends_with("lo") && high.ends_with("hi") => {
                let axis = ["xlo", "ylo", "zlo"].iter().position(|name| *name == low);
                let axis = axis.ok_or_else(|| wrong(lines, low, "xlo, ylo or zlo"))?;
                let mut bounds = [0.0; 2];
                tokens.numbers(&mut bounds, &[low, high])?;
                if !(bounds[0] < bounds[1] && bounds.iter().all(|bound| bound.is_finite())) {
                    return Err(wrong(
                        lines,
                        lines.line().trim(),
                        "two bounds, the lower one first",
                    ));
                }
                self.bounds[axis] = Some(bounds);
            }
            [_, _, _, "xy", "xz", "yz"] => {
                let mut tilt = [0.0; 3];
                tokens.numbers(&mut tilt, &["xy", "xz", "yz"])?;
                if tilt != [0.0; 3] {
                    return Err(wrong(lines, "a box that is not upright", "tilt factors 0"));
                }
            }
            [count, what] if FOREIGN.contains(&what) && count != "0" => {
                let error = wrong(lines, lines.line().trim(), "spheres only");
                return Err(error.with_help(
                    "particles of other shapes become clumps: mclump makes them of surfaces",
                ));
            }
            // Numbers of types, bonds, angles: nothing of spheres.
            _ => {}
        }
        Ok(())
    }

    fn domain<R: BufRead>(
        &self,
        lines: &LineReader<R>,
    ) -> Result<Option<(DVec3, DVec3)>, FormatError> {
        match self.bounds {
            [Some(x), Some(y), Some(z)] => Ok(Some((
                DVec3::new(x[0], y[0], z[0]),
                DVec3::new(x[1], y[1], z[1]),
            ))),
            [None, None, None] => Ok(None),
            _ => Err(
                FormatError::of_file(lines.path(), "bounds of some axes, not of all")
                    .with_help("xlo xhi, ylo yhi and zlo zhi belong above the sections"),
            ),
        }
    }
}

/// The order of the columns, by the remark behind `Atoms`.
fn style<R: BufRead>(lines: &LineReader<R>, remark: &str) -> Result<Style, FormatError> {
    let mut words = remark.split_whitespace();
    match (words.next(), words.next()) {
        (None | Some("sphere" | "granular"), _) => Ok(Style::Sphere),
        (Some("hybrid"), Some("sphere" | "granular")) => Ok(Style::Hybrid),
        _ => {
            let error = wrong(
                lines,
                &format!("Atoms of the style {remark:?}"),
                "sphere, granular, or hybrid with one of these first",
            );
            Err(error.with_help("other styles have no diameters and densities; write the file with atom_style sphere (LIGGGHTS: granular)"))
        }
    }
}

fn atoms<R: BufRead>(
    lines: &mut LineReader<R>,
    header: &Header,
    style: Style,
    grains: &mut Grains,
) -> Result<(), FormatError> {
    let Some(count) = header.atoms else {
        return Err(wrong(
            lines,
            "Atoms before their number",
            "a line like `1000 atoms` above",
        ));
    };
    let mut masses = Vec::new();
    for _ in 0..count {
        next_row(lines, "Atoms", count)?;
        let mut tokens = lines.tokens();
        grains.ids.push(id(&mut tokens, lines)?);
        grains.types.push(kind(&mut tokens, lines)?);
        let mut position = [0.0; 3];
        let mut size = [0.0; 2];
        let axes = ["x", "y", "z"];
        let sizes = ["the diameter", "the density"];
        match style {
            Style::Sphere => {
                tokens.numbers(&mut size, &sizes)?;
                tokens.numbers(&mut position, &axes)?;
            }
            Style::Hybrid => {
                tokens.numbers(&mut position, &axes)?;
                tokens.numbers(&mut size, &sizes)?;
            }
        }
        let [diameter, density] = size;
        if !(diameter > 0.0 && diameter.is_finite()) {
            let error = wrong(
                lines,
                &format!("the diameter {diameter}"),
                "a diameter above 0, in m",
            );
            return Err(error.with_help("columns are id type diameter density x y z; behind `Atoms # hybrid sphere` id type x y z diameter density"));
        }
        if !(density > 0.0 && density.is_finite()) {
            return Err(wrong(
                lines,
                &format!("the density {density}"),
                "a density above 0, in kg/m^3",
            ));
        }
        let position = DVec3::from_array(position);
        if !position.is_finite() {
            return Err(wrong(
                lines,
                "a position that is no number",
                "finite numbers",
            ));
        }
        let radius = 0.5 * diameter;
        grains.radius.push(radius);
        grains.position.push(position);
        masses.push(density * 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius);
    }
    grains.mass = Some(masses);
    Ok(())
}

/// Goes to the next row of a section.
fn next_row<R: BufRead>(
    lines: &mut LineReader<R>,
    section: &str,
    count: u64,
) -> Result<(), FormatError> {
    let is_row = lines.advance()?
        && !lines
            .line()
            .trim_start()
            .starts_with(|c: char| c.is_ascii_alphabetic());
    if is_row {
        return Ok(());
    }
    let error = wrong(
        lines,
        &format!("the end of {section}"),
        &format!("{count} lines, one for each atom"),
    );
    Err(error.with_help("the file is cut, or its number of atoms is wrong"))
}

fn id<R: BufRead>(tokens: &mut Tokens<'_>, lines: &LineReader<R>) -> Result<u64, FormatError> {
    let id = tokens.integer("the id")?;
    let id = (1..=MOST_IDS).contains(&id).then_some(id.unsigned_abs());
    id.ok_or_else(|| wrong(lines, "an id out of range", "ids from 1 to 2^32"))
}

fn kind<R: BufRead>(tokens: &mut Tokens<'_>, lines: &LineReader<R>) -> Result<u32, FormatError> {
    let kind = tokens.integer("the type")?;
    let kind = (1..=MOST_TYPES).contains(&kind).then_some(kind as u32);
    kind.ok_or_else(|| {
        wrong(
            lines,
            "a type out of range",
            &format!("types from 1 to {MOST_TYPES}"),
        )
    })
}

/// Velocities and angular velocities in the order of the atoms.
fn read_velocities<R: BufRead>(
    lines: &mut LineReader<R>,
    header: &Header,
    grains: &Grains,
) -> Result<(Vec<DVec3>, Vec<DVec3>), FormatError> {
    let count = header.atoms.unwrap_or(0);
    let rows: HashMap<u64, usize> = grains
        .ids
        .iter()
        .enumerate()
        .map(|(row, id)| (*id, row))
        .collect();
    let none = || vec![DVec3::NAN; grains.ids.len()];
    let (mut velocity, mut spin) = (none(), none());
    for _ in 0..count {
        next_row(lines, "Velocities", count)?;
        let mut tokens = lines.tokens();
        let id = id(&mut tokens, lines)?;
        let Some(&row) = rows.get(&id) else {
            return Err(wrong(
                lines,
                &format!("the velocity of atom {id}"),
                "atoms that are listed in Atoms",
            ));
        };
        if !velocity[row].is_nan() {
            return Err(wrong(
                lines,
                &format!("the velocity of atom {id} a second time"),
                "each atom once",
            ));
        }
        let mut values = [0.0; 6];
        let names = ["vx", "vy", "vz", "omegax", "omegay", "omegaz"];
        tokens.numbers(&mut values[..3], &names[..3])?;
        // Without angular velocities the spheres do not turn.
        if tokens.clone().next().is_some() {
            tokens.numbers(&mut values[3..], &names[3..])?;
        }
        if !values.iter().all(|value| value.is_finite()) {
            return Err(wrong(
                lines,
                "a velocity that is no number",
                "finite numbers",
            ));
        }
        velocity[row] = DVec3::new(values[0], values[1], values[2]);
        spin[row] = DVec3::new(values[3], values[4], values[5]);
    }
    Ok((velocity, spin))
}

/// Passes over a section about other things than spheres; false at the end of the file.
fn pass_over<R: BufRead>(lines: &mut LineReader<R>) -> Result<bool, FormatError> {
    while lines.advance()? {
        let line = lines.line().trim_start();
        if line.starts_with("Atoms") || line.starts_with("Velocities") {
            return Ok(true);
        }
    }
    Ok(false)
}
