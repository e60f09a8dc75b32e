//! A snapshot, and the walls and contacts beside it, as a frame to be drawn.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use glam::DVec3;
use mercury_common::frames::{
    BodyReader, BondReader, ClumpKind, Column, ContactReader, DropletReader, FrameReader, SheetNow,
    WallReader, WearFrame, WearReader, sheets as sheets_of,
};
use mercury_common::particle_properties::{FILM_VOLUME, LIQUID_VOLUME};
use mercury_common::readable::counted;
use mercury_common::surfaces::Placement;
use mercury_pictures::{
    Contact, Frame, Grain, SHEET_OPACITY, Sphere, Surface, wall_surfaces, worn_triangles,
};

use super::super::stl::worn_at;
use super::quantity::{CLUMP, OfRun, Quantity, SheetQuantity};
use super::{BondStress, PictureChoice};
use crate::beside;
use crate::bodies::{self, Shown};
use crate::source::SheetTables;
use crate::{ClumpsAs, ExportError, Selection, Snapshot, Source};

/// Tables of a run beside its particles.
pub(super) struct Scenery<'a> {
    contacts: Option<&'a ContactReader>,
    /// Whether those with a liquid bridge alone are drawn.
    bridges: bool,
    /// Bonds, drawn in place of contacts.
    bonds: Option<(&'a BondReader, BondStress)>,
    droplets: Option<&'a DropletReader>,
    particles: bool,
    walls: Option<&'a WallReader>,
    wear: Option<&'a WearReader>,
    membranes: Option<&'a SheetTables>,
    /// Areas of the triangles in the first frame, m^2.
    first_areas: Option<Vec<f64>>,
    /// Where clumps are shown as surfaces.
    bodies: Option<&'a BodyReader>,
    hide_pebbles: bool,
    /// Where colours show the kind of clump.
    kinds: Option<&'a BodyReader>,
    /// Frames drawn at whose times no contacts, or no bonds, were written.
    without_contacts: usize,
    selection: &'a Selection,
    title: Option<String>,
    /// Fallback title: the name of the input.
    name: String,
}

impl<'a> Scenery<'a> {
    pub(super) fn new(
        source: &'a Source,
        selection: &'a Selection,
        choice: &PictureChoice,
    ) -> Result<Self, ExportError> {
        let run = match source {
            Source::Run(run) => Some(run.as_ref()),
            Source::Data(_) | Source::Lammps(_) => None,
        };
        let contacts = if choice.contacts || choice.bridges {
            let found = run.map(|run| run.contacts("without --contacts the particles are drawn"));
            let found = found.transpose()?.flatten();
            let help = "fstat = true in [output] of the scene writes them; without --contacts the particles are drawn";
            let missing = || beside::missing(source, "contacts", "", help);
            Some(found.ok_or_else(missing)?)
        } else {
            None
        };
        let dry = contacts.filter(|table| {
            choice.bridges && table.frames().schema().index_of("bridge_volume").is_none()
        });
        if let Some(table) = dry {
            return Err(ExportError::Input(format!(
                "{}: these contacts have no liquid bridges\nhelp: --contacts draws all contacts; bridges need a `liquid` law at the materials of the scene",
                table.frames().path().display()
            )));
        }
        let bonds = match choice.bonds {
            Some(stress) => {
                let help = "without --bonds the particles are drawn";
                let found = run.map(|run| run.bonds(help)).transpose()?.flatten();
                let help = format!("{}; {help}", beside::NO_BONDS);
                let missing = || beside::missing(source, "bonds", "", &help);
                Some((found.ok_or_else(missing)?, stress))
            }
            None => None,
        };
        let droplets = if choice.droplets {
            let help = "without --droplets the particles are drawn";
            let found = run.map(|run| run.droplets(help)).transpose()?.flatten();
            let help = "a scene with [[sprays]] and droplets = true in [output] writes them; without --droplets the particles are drawn";
            Some(found.ok_or_else(|| beside::missing(source, "droplets", "", help))?)
        } else {
            None
        };
        let walls = run
            .filter(|_| choice.walls)
            .map(|run| run.walls("--no-walls leaves walls out"))
            .transpose()?
            .flatten();
        let kinds = if choice.quantity == CLUMP {
            let help = "--colour body, material or speed shows what there is";
            let found = bodies::reader(source, help)?;
            Some(found.ok_or_else(|| bodies::missing(source, help))?)
        } else {
            None
        };
        let wear = run
            .filter(|_| choice.walls)
            .map(|run| run.wear("--no-walls leaves walls out"))
            .transpose()?
            .flatten();
        let membranes = run
            .filter(|_| choice.walls)
            .map(|run| run.membranes("--no-walls leaves walls and membranes out"))
            .transpose()?
            .flatten();
        Ok(Self {
            kinds,
            contacts,
            bridges: choice.bridges,
            bonds,
            droplets,
            particles: choice.particles,
            walls,
            wear,
            membranes,
            first_areas: None,
            bodies: bodies::reader_for(source, choice.clumps)?,
            hide_pebbles: choice.clumps == ClumpsAs::Surface,
            without_contacts: 0,
            selection,
            title: choice.title.clone(),
            name: source.prefix().to_owned(),
        })
    }

    /// Names of the kinds of clumps, where colours show them.
    pub(super) fn clumps(&self) -> Vec<String> {
        let kinds = self.kinds.map_or(&[][..], BodyReader::kinds);
        kinds.iter().map(|kind| kind.name.clone()).collect()
    }

    /// The particles, with the kinds of their clumps where colours show them.
    pub(super) fn with_clumps<'s>(
        &self,
        snapshot: &'s Snapshot,
    ) -> Result<Cow<'s, Snapshot>, ExportError> {
        let mut snapshot = Cow::Borrowed(snapshot);
        if let Some(reader) = self.kinds {
            bodies::add_clumps(reader, snapshot.to_mut())?;
        }
        Ok(snapshot)
    }

    /// Tables that the run has beside its particles.
    pub(super) fn of_run(&self) -> OfRun {
        OfRun {
            wears: self.walls.is_some() && self.wear.is_some(),
            has_sheets: self.membranes.is_some(),
        }
    }

    /// Counts from nothing again.
    pub(super) fn begin_again(&mut self) {
        self.without_contacts = 0;
    }

    /// The table whose rows are drawn as lines, and the name of its rows.
    fn lines(&self) -> Option<(&FrameReader, &'static str)> {
        let contacts = self.contacts.map(|table| (table.frames(), "contacts"));
        let bonds = || self.bonds.map(|(table, _)| (table.frames(), "bonds"));
        contacts.or_else(bonds)
    }

    /// Note that contacts or bonds were written at other times than some of the frames drawn.
    pub(super) fn note(&self) -> Option<String> {
        let (table, what) = self.lines()?;
        (self.without_contacts > 0 && table.damage().is_none()).then(|| {
            let path = table.path().display();
            let count = counted(self.without_contacts, "frame");
            format!("{path}: no {what} were written at the times of {count}")
        })
    }

    /// Warnings of tables that end before the time `last` (s).
    pub(super) fn cut(&self, last: Option<f64>) -> Vec<String> {
        let contacts = self.lines().and_then(|(table, what)| {
            let lost = "later pictures are without them";
            beside::cut(table, what, lost, last)
        });
        let walls = self.walls.and_then(|table| {
            let lost = "later pictures are without them";
            beside::cut(table.frames(), "walls", lost, last)
        });
        let bodies = self.bodies.and_then(|table| {
            let lost = if self.hide_pebbles {
                "later clumps are shown by their pebbles"
            } else {
                "surfaces of later clumps are left out"
            };
            beside::cut(table.frames(), "bodies", lost, last)
        });
        let wear = self.wear.and_then(|table| {
            let lost = "later walls are shown as they were at the start";
            beside::cut(table.frames(), "wear", lost, last)
        });
        let all = bodies.into_iter().chain(contacts).chain(walls);
        all.chain(wear).collect()
    }

    /// The frame of a snapshot, coloured by a quantity.
    pub(super) fn frame(
        &mut self,
        snapshot: &Snapshot,
        quantity: &Quantity,
    ) -> Result<Frame, ExportError> {
        let (coloured, sheets) = self.sheets(snapshot, quantity)?;
        let header = &snapshot.header;
        let title = self.title.as_deref().unwrap_or(if header.title.is_empty() {
            &self.name
        } else {
            &header.title
        });
        let (mut spheres, mut grains) = self.spheres_and_grains(snapshot, quantity)?;
        if !self.particles {
            spheres.clear();
            grains.clear();
        }
        let wear = worn_at(self.wear, snapshot.frame.step)?;
        if let (Quantity::Depth, Some(wear)) = (quantity, &wear) {
            grains.extend(self.worn_triangles(snapshot, wear)?);
        }
        grains.extend(coloured);
        let droplets = self.droplets(snapshot, quantity)?;
        let mut surfaces = self.surfaces(snapshot, wear.as_ref())?;
        surfaces.extend(sheets);
        let contacts = match self.bonds {
            Some((reader, stress)) => bonds(snapshot, reader, stress)?,
            None => self.contacts(snapshot)?,
        };
        self.without_contacts += usize::from(self.lines().is_some() && contacts.is_none());
        let contacts = contacts.unwrap_or_default();
        Ok(Frame {
            title: title.to_owned(),
            time: Some(snapshot.frame.time),
            flat: snapshot.dimensions() == 2,
            gravity: header.gravity.unwrap_or_default(),
            domain: header.domain,
            spheres,
            droplets,
            grains,
            surfaces,
            lines: Vec::new(),
            contacts,
        })
    }

    /// The triangles of elastic sheets at this step where they are coloured, else as surfaces.
    fn sheets(
        &mut self,
        snapshot: &Snapshot,
        quantity: &Quantity,
    ) -> Result<(Vec<Grain>, Vec<Surface>), ExportError> {
        let nothing = (Vec::new(), Vec::new());
        let Some(tables) = self.membranes else {
            return Ok(nothing);
        };
        let Some((vertices, triangles)) = tables.at_step(snapshot.frame.step)? else {
            return Ok(nothing);
        };
        let sheets = sheets_of(&vertices, &triangles).map_err(|reason| {
            let path = tables.triangles.frames().path().display();
            ExportError::Input(format!("{path}: {reason}"))
        })?;
        let corners = |sheet: &SheetNow, k: usize| sheet.mesh.corners(k);
        let Quantity::Sheet(quantity) = quantity else {
            let surface = |sheet: &SheetNow| Surface {
                opacity: SHEET_OPACITY,
                ..Surface::wall(
                    (0..sheet.mesh.triangles.len())
                        .map(|k| corners(sheet, k))
                        .collect(),
                )
            };
            return Ok((Vec::new(), sheets.iter().map(surface).collect()));
        };
        if self.first_areas.is_none() {
            let first = tables.triangles.frame(0)?;
            self.first_areas = Some(first.area);
        }
        let first_areas = self.first_areas.as_deref().unwrap_or_default();
        let mut grains = Vec::new();
        for sheet in &sheets {
            for (k, &row) in sheet.triangle_rows.iter().enumerate() {
                let place = corners(sheet, k);
                let [a, b, c] = place;
                let value = match quantity {
                    SheetQuantity::LargerTension => triangles.tensions[0][row],
                    SheetQuantity::SmallerTension => triangles.tensions[1][row],
                    SheetQuantity::Stretch => {
                        let first = first_areas.get(row).copied().unwrap_or(f64::NAN);
                        (triangles.area[row] / first).sqrt()
                    }
                    SheetQuantity::Pressure => {
                        let normal = (b - a).cross(c - a).normalize_or_zero();
                        triangles.load[row].dot(normal).abs() / triangles.area[row]
                    }
                };
                grains.push(Grain {
                    triangles: vec![place],
                    value,
                    fixed: false,
                    of_wall: true,
                });
            }
        }
        Ok((grains, Vec::new()))
    }

    /// Particles, and what stands for some of them.
    fn spheres_and_grains(
        &self,
        snapshot: &Snapshot,
        quantity: &Quantity,
    ) -> Result<(Vec<Sphere>, Vec<Grain>), ExportError> {
        let shown = self.bodies.map(|reader| {
            let found = bodies::at_step(reader, snapshot.frame.step, self.selection)?;
            Ok::<_, ExportError>(found.map(|shown| (reader, shown)))
        });
        let Some((reader, shown)) = shown.transpose()?.flatten() else {
            return Ok((spheres(snapshot, quantity)?, Vec::new()));
        };
        let grains = grains(reader.kinds(), &shown, quantity)?;
        if !self.hide_pebbles {
            return Ok((spheres(snapshot, quantity)?, grains));
        }
        let mut rest = snapshot.clone();
        shown.hide_pebbles(&mut rest);
        Ok((spheres(&rest, quantity)?, grains))
    }

    /// Where the walls stand at this step; none where they are not there, and none at all where that was not written.
    fn standing(&self, snapshot: &Snapshot) -> Result<Vec<Option<Placement>>, ExportError> {
        let Some(reader) = self.walls else {
            return Ok(Vec::new());
        };
        let mut infos = reader.frames().infos();
        let Some(number) = infos.position(|info| info.step == snapshot.frame.step) else {
            return Ok(Vec::new());
        };
        let frame = reader.frame(number)?;
        let both = frame.present.iter().zip(&frame.placement);
        Ok(both
            .map(|(present, placement)| present.then_some(*placement))
            .collect())
    }

    /// The walls of this step where they stand, as they are worn.
    fn surfaces(
        &self,
        snapshot: &Snapshot,
        wear: Option<&WearFrame>,
    ) -> Result<Vec<Surface>, ExportError> {
        let Some(reader) = self.walls else {
            return Ok(Vec::new());
        };
        let standing = self.standing(snapshot)?;
        if standing.is_empty() {
            return Ok(Vec::new());
        }
        let names = &reader.header().walls;
        let domain = snapshot.domain()?;
        Ok(match wear {
            Some(wear) => {
                let shapes = wear.worn_surfaces(reader.surfaces());
                wall_surfaces(names, &shapes, &standing, domain)
            }
            None => wall_surfaces(names, reader.surfaces(), &standing, domain),
        })
    }

    /// The triangles of worn walls, coloured by their mean depth.
    fn worn_triangles(
        &self,
        snapshot: &Snapshot,
        wear: &WearFrame,
    ) -> Result<Vec<Grain>, ExportError> {
        let Some(reader) = self.walls else {
            return Ok(Vec::new());
        };
        let standing = self.standing(snapshot)?;
        // A wall that is worn at the end has its colours from the beginning.
        let last = self.wear.filter(|table| !table.frames().is_empty());
        let later = last.map(|table| table.frame(table.frames().len() - 1));
        let later = later.transpose()?.unwrap_or_default();
        let walls: Vec<u32> = [&wear.wall[..], &later.wall].concat();
        Ok(worn_triangles(wear, &walls, reader.surfaces(), &standing))
    }

    /// The contacts of this step between particles that are shown; none if none were written then.
    fn contacts(&self, snapshot: &Snapshot) -> Result<Option<Vec<Contact>>, ExportError> {
        let Some(reader) = self.contacts else {
            return Ok(None);
        };
        let mut infos = reader.frames().infos();
        let Some(number) = infos.position(|info| info.step == snapshot.frame.step) else {
            return Ok(None);
        };
        let frame = reader.frame(number)?;
        let ids = snapshot
            .column("id")
            .and_then(Column::as_u32)
            .unwrap_or_default();
        let centres: HashMap<u32, DVec3> = ids.iter().copied().zip(centres(snapshot)?).collect();
        let shown = |k: usize| {
            let volumes = frame.bridge_volume.as_ref().filter(|_| self.bridges);
            if volumes.is_some_and(|volumes| volumes[k] <= 0.0) {
                return None;
            }
            let from = *centres.get(&frame.i[k])?;
            if let Some(j) = frame.j[k] {
                centres.get(&j)?;
            }
            Some(Contact {
                from,
                to: from - frame.branch[k],
                strength: match (&frame.bridge_normal, &frame.bridge_shear) {
                    (Some(normal), Some(shear)) if self.bridges => {
                        normal[k].hypot(shear[k].length())
                    }
                    _ => frame.force[k].length(),
                },
            })
        };
        Ok(Some((0..frame.len()).filter_map(shown).collect()))
    }
}

impl Scenery<'_> {
    /// The droplets in flight at this step; where colours show liquid, they show the volumes of droplets, too.
    fn droplets(
        &self,
        snapshot: &Snapshot,
        quantity: &Quantity,
    ) -> Result<Vec<Sphere>, ExportError> {
        let Some(reader) = self.droplets else {
            return Ok(Vec::new());
        };
        let mut infos = reader.frames().infos();
        let Some(number) = infos.position(|info| info.step == snapshot.frame.step) else {
            return Ok(Vec::new());
        };
        let frame = reader.frame(number)?;
        let of_liquid = [FILM_VOLUME.name, LIQUID_VOLUME.name];
        let is_liquid =
            matches!(quantity, Quantity::Column { name, .. } if of_liquid.contains(&name.as_str()));
        let droplets = frame.position.iter().zip(&frame.radius);
        let sphere = |(centre, radius): (&DVec3, &f64)| Sphere {
            centre: *centre,
            radius: *radius,
            value: if is_liquid {
                4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius
            } else {
                f64::NAN
            },
            fixed: false,
        };
        Ok(droplets.map(sphere).collect())
    }
}

/// The bonds of this step between particles that are shown; none if none were written then.
fn bonds(
    snapshot: &Snapshot,
    reader: &BondReader,
    stress: BondStress,
) -> Result<Option<Vec<Contact>>, ExportError> {
    let mut infos = reader.frames().infos();
    let Some(number) = infos.position(|info| info.step == snapshot.frame.step) else {
        return Ok(None);
    };
    let frame = reader.frame(number)?;
    let ids = snapshot.column("id").and_then(Column::as_u32);
    let ids: HashSet<u32> = ids.unwrap_or_default().iter().copied().collect();
    let is_shown = |row: &usize| {
        let partner = frame.j[*row];
        ids.contains(&frame.i[*row]) && partner.is_none_or(|j| ids.contains(&j))
    };
    let line = |row: usize| {
        let [from, to] = frame.ends(row);
        let (tension, shear) = (frame.tension[row], frame.shear[row]);
        let strength = match stress {
            BondStress::Larger => tension.max(shear),
            BondStress::Tension => tension,
            BondStress::Shear => shear,
        };
        Contact {
            from,
            to,
            strength: strength.max(0.0),
        }
    };
    Ok(Some((0..frame.len()).filter(is_shown).map(line).collect()))
}

/// The positions.
pub(super) fn centres(snapshot: &Snapshot) -> Result<Vec<DVec3>, ExportError> {
    snapshot.vectors(["x", "y", "z"]).ok_or_else(|| {
        let path = snapshot.path.display();
        ExportError::Input(format!("{path}: no positions x, y, z"))
    })
}

fn spheres(snapshot: &Snapshot, quantity: &Quantity) -> Result<Vec<Sphere>, ExportError> {
    let centres = centres(snapshot)?;
    let radii = snapshot.numbers("radius")?;
    let values = quantity.values(snapshot)?;
    let flags = match snapshot.column("state") {
        Some(Column::U8(flags)) => flags.as_slice(),
        _ => &[],
    };
    let rows = centres.into_iter().zip(radii).zip(values).enumerate();
    let sphere = |(row, ((centre, radius), value)): (usize, ((DVec3, &f64), f64))| Sphere {
        centre,
        radius: *radius,
        value,
        // Bit 0: fixed, bit 1: prescribed motion.
        fixed: flags.get(row).is_some_and(|flags| flags & 3 != 0),
    };
    Ok(rows.map(sphere).collect())
}

/// Bodies as their own surfaces. A quantity that only spheres have gives no values.
fn grains(
    kinds: &[ClumpKind],
    shown: &Shown,
    quantity: &Quantity,
) -> Result<Vec<Grain>, ExportError> {
    let table = &shown.table;
    let quantity = match quantity {
        // The body of a pebble is the id of a body.
        Quantity::Body => Quantity::Column {
            name: "id".to_owned(),
            unit: String::new(),
        },
        Quantity::Column { name, .. } if name == "body" => Quantity::Column {
            name: "id".to_owned(),
            unit: String::new(),
        },
        other => other.clone(),
    };
    let values = if quantity.is_of(table) {
        quantity.values(table)?
    } else {
        vec![f64::NAN; shown.frame.len()]
    };
    let frame = &shown.frame;
    let grain = |row: usize| {
        let mesh = kinds[frame.clump[row] as usize].surface.as_ref()?;
        let (turn, scale) = (frame.orientation[row], frame.scale[row]);
        Some(Grain {
            value: values[row],
            fixed: frame.flags[row] & 3 != 0,
            ..Grain::of_body(mesh, frame.position[row], turn, scale)
        })
    };
    Ok((0..frame.len()).filter_map(grain).collect())
}
