//! `.ene`: the energies of the whole system at each saved time.
//!
//! One header line per file, then one line of 8 columns per time. See `docs/formats/tables.md#energies`.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::lines::LineReader;
use super::number::{NumberStyle, push_number, push_number_in_width};
use crate::error::FormatError;
use crate::run_tables::ENERGIES;

/// The energies at one time. Fixed particles do not count in any of them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EnergyRow {
    /// Time in s.
    pub time: f64,
    /// Gravitational energy `-g . sum(m x)` in J.
    pub gravitational: f64,
    /// Translational kinetic energy `sum(m v^2 / 2)` in J.
    pub translational_kinetic: f64,
    /// Rotational kinetic energy `sum(w . I w / 2)` in J.
    pub rotational_kinetic: f64,
    /// Energy stored in contacts (normal and friction springs, adhesion, bonds) in J.
    pub elastic: f64,
    /// Centre of mass in m; NaN if nothing can move.
    pub center_of_mass: DVec3,
}

/// The header words.
pub const COLUMNS: [&str; 8] = {
    let mut names = [""; ENERGIES.columns.len()];
    let mut place = 0;
    while place < names.len() {
        names[place] = ENERGIES.columns[place].name;
        place += 1;
    }
    names
};

/// Width of a column in MercuryDPM's look.
const WIDTH: usize = 16;

/// Reads the rows one by one.
///
/// The header may be missing (MercuryDPM prints none when it appends to a file) or come again (files
/// put together by hand); blank lines, lines that start with `#` and surplus columns are ignored. After an error the
/// iterator ends.
#[derive(Debug)]
pub struct EnergyReader<R> {
    lines: LineReader<R>,
    finished: bool,
}

impl EnergyReader<BufReader<File>> {
    /// Opens a file.
    ///
    /// # Errors
    /// If it cannot be opened.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        let path = path.as_ref();
        Ok(Self::new(BufReader::new(super::open(path)?), path))
    }
}

impl<R: BufRead> EnergyReader<R> {
    /// Reads from anything; `path` is only used in messages.
    pub fn new(input: R, path: impl Into<PathBuf>) -> Self {
        Self {
            lines: LineReader::new(input, path),
            finished: false,
        }
    }

    fn read_row(&mut self) -> Result<Option<EnergyRow>, FormatError> {
        while self.lines.advance()? {
            // `t` is the first word of old versions.
            let first = self.lines.tokens().next().map_or("", |token| token.text);
            if first.starts_with('#') || first == "time" || first == "t" {
                continue;
            }
            let mut v = [0.0; 8];
            self.lines.tokens().numbers(&mut v, &COLUMNS)?;
            return Ok(Some(EnergyRow {
                time: v[0],
                gravitational: v[1],
                translational_kinetic: v[2],
                rotational_kinetic: v[3],
                elastic: v[4],
                center_of_mass: DVec3::new(v[5], v[6], v[7]),
            }));
        }
        Ok(None)
    }
}

impl<R: BufRead> Iterator for EnergyReader<R> {
    type Item = Result<EnergyRow, FormatError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.finished {
            return None;
        }
        let result = self.read_row().transpose();
        self.finished = !matches!(result, Some(Ok(_)));
        result
    }
}

impl EnergyRow {
    /// The numbers in the order of [`COLUMNS`].
    #[must_use]
    pub fn values(&self) -> [f64; COLUMNS.len()] {
        let c = self.center_of_mass;
        [
            self.time,
            self.gravitational,
            self.translational_kinetic,
            self.rotational_kinetic,
            self.elastic,
            c.x,
            c.y,
            c.z,
        ]
    }
}

/// Appends the header line.
pub fn write_header(style: NumberStyle, out: &mut Vec<u8>) {
    for (index, name) in COLUMNS.iter().enumerate() {
        if index > 0 {
            out.push(b' ');
        }
        if let NumberStyle::Digits(_) = style {
            out.extend(std::iter::repeat_n(b' ', WIDTH.saturating_sub(name.len())));
        }
        out.extend_from_slice(name.as_bytes());
    }
    out.push(b'\n');
}

/// Appends one row: right-aligned columns of 16 characters with [`NumberStyle::Digits`], else single blanks.
pub fn write_row(row: &EnergyRow, style: NumberStyle, out: &mut Vec<u8>) {
    for (index, value) in row.values().into_iter().enumerate() {
        if index > 0 {
            out.push(b' ');
        }
        match style {
            NumberStyle::Shortest => push_number(out, value, style),
            NumberStyle::Digits(_) => push_number_in_width(out, value, style, WIDTH),
        }
    }
    out.push(b'\n');
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::formats::test_support::{any_number, any_vector, assert_same_numbers};
    use crate::reference_data::shared;

    fn read(text: &str) -> Result<Vec<EnergyRow>, FormatError> {
        EnergyReader::new(text.as_bytes(), "t.ene").collect()
    }

    fn written(rows: &[EnergyRow], style: NumberStyle) -> String {
        let mut out = Vec::new();
        write_header(style, &mut out);
        for row in rows {
            write_row(row, style, &mut out);
        }
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn reads_with_and_without_header() {
        let expected = EnergyRow {
            time: 0.5,
            gravitational: -1.0,
            translational_kinetic: 2.0,
            rotational_kinetic: 3.0,
            elastic: 4.0,
            center_of_mass: DVec3::new(5.0, 6.0, 7.0),
        };
        let row = "0.5 -1 2 3 4 5 6 7 surplus\n";
        assert_eq!(read(row).unwrap(), [expected]);
        assert_eq!(
            read(&format!("time a b\n{row}\n# x\nt b\n{row}")).unwrap(),
            [expected; 2]
        );
        assert_eq!(
            written(&[expected], NumberStyle::Shortest),
            format!("{}\n0.5 -1 2 3 4 5 6 7\n", COLUMNS.join(" "))
        );
        let no_mass = read("0 0 0 0 0 nan nan -nan\n").unwrap();
        assert!(no_mass[0].center_of_mass.z.is_nan());
    }

    #[test]
    fn bad_input_is_located() {
        for (text, line, column, part) in [
            ("0 1 2 3 4 5 6\n", 1, 14, "in place of centerOfMassZ"),
            (
                "time\n0 1 two 3 4 5 6 7\n",
                2,
                5,
                "\"two\" for traKineticEnergy",
            ),
            ("zeit\n", 1, 1, "\"zeit\" for time"),
        ] {
            let error = read(text).unwrap_err();
            assert_eq!(
                (error.line, error.column),
                (Some(line), Some(column)),
                "{error}"
            );
            assert!(error.found.contains(part), "{error}");
        }
        assert!(EnergyReader::open("no/such.ene").is_err());
    }

    /// MercuryDPM's own files survive; those of the present version line by line as text.
    #[test]
    fn files_of_mercury_dpm() {
        for (name, digits, same_text) in [
            ("interactions/FreeFallSelfTest.ene", 10, true),
            (
                "interactions/TwoParticleElasticCollisionSelfTest.ene",
                10,
                true,
            ),
            ("interactions/ForceSelfTest0.ene", 10, false),
            ("interactions/ForceSelfTest1.ene", 10, false),
            ("interactions/ForceSelfTest2.ene", 10, false),
            ("interactions/ForceSelfTest3.ene", 10, false),
            ("interactions/ForceSelfTest4.ene", 10, false),
            ("chute-legacy/AxisymmetricHopper.ene", 13, false),
            ("chute-legacy/hopper_3d_demo.ene", 13, false),
        ] {
            let Some(path) = shared(&format!("data/selftest/{name}")) else {
                return;
            };
            let text = std::fs::read_to_string(&path).unwrap();
            let rows: Vec<_> = EnergyReader::open(&path)
                .unwrap()
                .collect::<Result<_, _>>()
                .unwrap();
            assert_eq!(rows.len() + 1, text.lines().count());
            let back = written(&rows, NumberStyle::Digits(digits));
            if same_text {
                assert!(back == text, "{name}");
            }
            let numbers = |text: &str| text.split_once('\n').unwrap().1.to_owned();
            assert_same_numbers(&numbers(&back), &numbers(&text), name);
        }
    }

    proptest! {
        #[test]
        fn shortest_round_trip_is_exact(v in [any_number(), any_number(), any_number(), any_number(), any_number()], center_of_mass in any_vector()) {
            let row = EnergyRow {
                time: v[0], gravitational: v[1], translational_kinetic: v[2], rotational_kinetic: v[3],
                elastic: v[4], center_of_mass,
            };
            let back = read(&written(&[row], NumberStyle::Shortest)).unwrap();
            prop_assert_eq!(format!("{back:?}"), format!("{:?}", [row]));
        }
    }
}
