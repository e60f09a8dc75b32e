//! Text files of LAMMPS and LIGGGHTS, as frames with named columns: dumps (`dump custom`) and data files (`read_data`).
//!
//! Numbers are taken as SI (`units si`). Types become materials, named `type-1` and so on as the files know no names; ids count from 0.

mod data_file;
mod dump;

use std::fs::File;
use std::io::{BufReader, Read as _};
use std::path::{Path, PathBuf};

use glam::DVec3;
use mercury_common::error::FormatError;
use mercury_common::formats::lines::LineReader;
use mercury_common::frames::{Column, ColumnKind, ColumnSpec, Frame, FramesHeader};

use super::{Item, Snapshot};
use crate::FrameChoice;

/// Bytes of a file by which its format is recognised.
const HEAD: u64 = 1 << 14;

/// A dump, or a data file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Dump,
    DataFile,
}

/// A text file of LAMMPS or LIGGGHTS.
#[derive(Debug)]
pub struct LammpsSource {
    path: PathBuf,
    prefix: String,
    kind: Kind,
}

impl LammpsSource {
    /// The file, if it looks like one of these; its name does not decide, as `.data` is a common name of both kinds of data.
    pub(super) fn recognise(path: &Path) -> Option<Self> {
        let mut head = Vec::new();
        // A stream that can be read only once is left to its reader.
        std::fs::metadata(path).ok().filter(|data| data.is_file())?;
        File::open(path)
            .ok()?
            .take(HEAD)
            .read_to_end(&mut head)
            .ok()?;
        let kind = kind_of(&String::from_utf8_lossy(&head))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let endings = [
            "lmp",
            "lmpdat",
            "lmpdata",
            "data",
            "dump",
            "lammpstrj",
            "liggghts",
            "txt",
            "dat",
        ];
        let prefix = match name.rsplit_once('.') {
            Some((stem, ending)) if !stem.is_empty() && endings.contains(&ending) => {
                stem.to_owned()
            }
            _ => name.into_owned(),
        };
        Some(Self {
            path: path.to_owned(),
            prefix,
            kind,
        })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn prefix(&self) -> &str {
        &self.prefix
    }

    /// All frames, and behind them what is wrong with the rest.
    fn all(&self) -> Box<dyn Iterator<Item = Item> + Send + '_> {
        let lines = || {
            let file = File::open(&self.path).map_err(|error| {
                FormatError::of_file(&self.path, format!("the file cannot be opened: {error}"))
            })?;
            Ok(LineReader::new(
                BufReader::with_capacity(1 << 17, file),
                &self.path,
            ))
        };
        let lines = match lines() {
            Ok(lines) => lines,
            Err(error) => return Box::new(std::iter::once(Err(error))),
        };
        match self.kind {
            Kind::Dump => {
                let mut number = 0;
                Box::new(dump::Frames::new(lines).map(move |frame| {
                    let found = frame.map(|frame| frame.snapshot(&self.path, number));
                    number += 1;
                    found
                }))
            }
            Kind::DataFile => {
                let once = std::iter::once_with(move || data_file::read(lines));
                Box::new(once.map(|frame| frame.map(|frame| frame.snapshot(&self.path, 0))))
            }
        }
    }

    pub(super) fn frames(&self, choice: FrameChoice) -> Box<dyn Iterator<Item = Item> + Send + '_> {
        if choice == FrameChoice::Last {
            let last = std::iter::once_with(move || {
                let (mut last, mut damage) = (None, None);
                for item in self.all() {
                    match item {
                        Ok(frame) => last = Some(frame),
                        Err(error) => damage = Some(error),
                    }
                }
                last.into_iter().map(Ok).chain(damage.map(Err))
            });
            return Box::new(last.flatten());
        }
        let wanted = self.all().take_while(move |item| match item {
            Ok(frame) => !choice.ends_before(frame.number),
            Err(_) => true,
        });
        Box::new(wanted.filter(move |item| match item {
            Ok(frame) => choice.has(frame.number),
            Err(_) => true,
        }))
    }
}

fn kind_of(head: &str) -> Option<Kind> {
    let first = head.lines().find(|line| !line.trim().is_empty())?;
    if first.starts_with("ITEM:") {
        return Some(Kind::Dump);
    }
    // `1000 atoms`: the line that each data file has.
    let counts = |line: &str| {
        let mut words = line.split_whitespace();
        let number = words.next().is_some_and(|word| word.parse::<u64>().is_ok());
        number
            && words.next() == Some("atoms")
            && words.next().is_none_or(|word| word.starts_with('#'))
    };
    head.lines().any(counts).then_some(Kind::DataFile)
}

/// The spheres of a frame, in the order of their ids.
#[derive(Debug, Default, PartialEq)]
struct Grains {
    title: String,
    step: u64,
    /// s; none: only the number of the step is known.
    time: Option<f64>,
    domain: Option<(DVec3, DVec3)>,
    periodic: [bool; 3],
    /// From 1.
    ids: Vec<u64>,
    /// From 1.
    types: Vec<u32>,
    radius: Vec<f64>,
    position: Vec<DVec3>,
    velocity: Option<Vec<DVec3>>,
    angular_velocity: Option<Vec<DVec3>>,
    mass: Option<Vec<f64>>,
    force: Option<Vec<DVec3>>,
    /// Other columns of numbers, with their names.
    others: Vec<(String, Vec<f64>)>,
}

impl Grains {
    /// Snapshot with the names of columns in native frames.
    fn snapshot(self, path: &Path, number: usize) -> Snapshot {
        let types = self.types.iter().copied().max().unwrap_or(0);
        let mut specs = Vec::new();
        let mut columns = Vec::new();
        let mut put = |name: &str, kind: ColumnKind, unit: &str, column: Column| {
            specs.push(ColumnSpec::new(name, kind, unit));
            columns.push(column);
        };
        let number_of = |id: &u64| u32::try_from(id - 1).unwrap_or(u32::MAX);
        put(
            "id",
            ColumnKind::U32,
            "1",
            Column::U32(self.ids.iter().map(number_of).collect()),
        );
        let materials = self.types.iter().map(|kind| kind - 1).collect();
        put("material", ColumnKind::U32, "1", Column::U32(materials));
        if let Some(mass) = self.mass {
            let volume = |r: &f64| 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
            let volumes = self.radius.iter().map(volume).collect();
            put("mass", ColumnKind::F64, "kg", Column::F64(mass));
            put("volume", ColumnKind::F64, "m^3", Column::F64(volumes));
        }
        put("radius", ColumnKind::F64, "m", Column::F64(self.radius));
        let vectors = [
            (["x", "y", "z"], "m", Some(self.position)),
            (["vx", "vy", "vz"], "m/s", self.velocity),
            (["wx", "wy", "wz"], "rad/s", self.angular_velocity),
            (["fx", "fy", "fz"], "N", self.force),
        ];
        for (names, unit, values) in vectors {
            let Some(values) = values else { continue };
            for (axis, name) in names.into_iter().enumerate() {
                let column = values.iter().map(|value| value[axis]).collect();
                put(name, ColumnKind::F64, unit, Column::F64(column));
            }
        }
        for (name, values) in self.others {
            put(&name, ColumnKind::F64, "1", Column::F64(values));
        }
        Snapshot {
            path: path.to_owned(),
            number,
            specs,
            frame: Frame {
                // Without a time the steps stand for it, so that frames have an order and a distance.
                time: self.time.unwrap_or(self.step as f64),
                step: self.step,
                columns,
            },
            header: FramesHeader {
                title: self.title,
                domain: self.domain,
                periodic: self.periodic,
                dimensions: Some(3),
                materials: (1..=types).map(|kind| format!("type-{kind}")).collect(),
                ..FramesHeader::default()
            },
        }
    }

    /// Sorts all columns by id; the first id that stands twice, if there is one.
    fn sort(&mut self) -> Result<(), u64> {
        let mut order: Vec<usize> = (0..self.ids.len()).collect();
        order.sort_by_key(|&row| self.ids[row]);
        let twice = order
            .windows(2)
            .find(|pair| self.ids[pair[0]] == self.ids[pair[1]]);
        if let Some(pair) = twice {
            return Err(self.ids[pair[0]]);
        }
        fn sorted<T: Copy>(values: &mut Vec<T>, order: &[usize]) {
            *values = order.iter().map(|&row| values[row]).collect();
        }
        sorted(&mut self.ids, &order);
        sorted(&mut self.types, &order);
        sorted(&mut self.radius, &order);
        sorted(&mut self.position, &order);
        let vectors = [
            &mut self.velocity,
            &mut self.angular_velocity,
            &mut self.force,
        ];
        for vectors in vectors.into_iter().flatten() {
            sorted(vectors, &order);
        }
        let others = self.others.iter_mut().map(|(_, values)| values);
        for numbers in self.mass.iter_mut().chain(others) {
            sorted(numbers, &order);
        }
        Ok(())
    }
}

/// Most types of atoms: each is a material of the scene to come.
const MOST_TYPES: i64 = 4096;

/// Largest id: ours have 32 bits.
const MOST_IDS: i64 = 1 << 32;

#[cfg(test)]
mod tests;
