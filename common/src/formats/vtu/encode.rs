//! A grid as the bytes of a `.vtu` file: XML in front, arrays behind.

use std::fmt::Write as _;

use rayon::prelude::*;

use super::{VtuArray, VtuCells, VtuCompression, VtuGrid, VtuOptions, VtuValues, blocks};

/// VTK's numbers of the kinds of cells.
const VERTEX: u8 = 1;
const LINE: u8 = 3;
const TRIANGLE: u8 = 5;

/// The XML in the making and the arrays that it points to.
struct Document<'a> {
    options: VtuOptions,
    xml: String,
    arrays: Vec<VtuValues<'a>>,
    /// Where in the XML the offset of each array belongs.
    places: Vec<usize>,
}

/// The file in parts, to be written one behind the other.
///
/// # Errors
/// Parts of the grid do not fit together, see [`write_vtu`](super::write_vtu).
pub fn encode_vtu(grid: &VtuGrid, options: VtuOptions) -> Result<Vec<Vec<u8>>, String> {
    let cells = check(grid)?;
    let mut document = Document {
        options,
        xml: String::new(),
        arrays: Vec::new(),
        places: Vec::new(),
    };
    document.open(grid, cells);
    document.arrays("PointData", &grid.point_data);
    document.arrays("CellData", &grid.cell_data);
    document.xml.push_str("      <Points>\n");
    document.array("Points", VtuValues::Vectors(grid.points.as_ref().into()));
    document.xml.push_str("      </Points>\n      <Cells>\n");
    let (connectivity, corners, kind) = match &grid.cells {
        VtuCells::Vertices => (sequence(0, 1, cells), 1, VERTEX),
        VtuCells::Lines(lines) => (flat(lines), 2, LINE),
        VtuCells::Triangles(triangles) => (flat(triangles), 3, TRIANGLE),
    };
    document.array("connectivity", connectivity);
    document.array("offsets", sequence(corners, corners, cells));
    let types = VtuValues::Constant {
        value: kind,
        length: cells,
    };
    document.array("types", types);
    document.xml.push_str("      </Cells>\n    </Piece>\n");
    Ok(document.close())
}

/// The number of cells, if everything fits.
fn check(grid: &VtuGrid) -> Result<usize, String> {
    let points = grid.points.len();
    let (cells, largest, corners) = match &grid.cells {
        VtuCells::Vertices => (points, None, 1),
        VtuCells::Lines(lines) => (lines.len(), lines.iter().flatten().max(), 2),
        VtuCells::Triangles(t) => (t.len(), t.iter().flatten().max(), 3),
    };
    if let Some(&corner) = largest.filter(|&&corner| corner as usize >= points) {
        return Err(format!("a cell uses point {corner} of {points}"));
    }
    if i32::try_from(points.max(cells * corners)).is_err() {
        let found = format!("{points} points and {cells} cells");
        return Err(format!("{found}, expected fewer than 2147483648 corners"));
    }
    let lists = [
        (&grid.point_data, points, "points"),
        (&grid.cell_data, cells, "cells"),
    ];
    for (arrays, expected, what) in lists {
        for (k, array) in arrays.iter().enumerate() {
            let name = &array.name;
            if array.values.len() != expected {
                let found = array.values.len();
                return Err(format!(
                    "array {name} has {found} entries for {expected} {what}"
                ));
            }
            if arrays[..k].iter().any(|other| other.name == *name) {
                return Err(format!("two arrays {name} on {what}"));
            }
        }
    }
    Ok(cells)
}

fn sequence(start: i32, step: i32, length: usize) -> VtuValues<'static> {
    VtuValues::Sequence {
        start,
        step,
        length,
    }
}

/// Corners of cells in a row. VTK counts in signed integers; [`check`] made sure that they fit.
fn flat<const N: usize>(cells: &[[u32; N]]) -> VtuValues<'static> {
    let corners = cells.iter().flatten().map(|&corner| corner as i32);
    VtuValues::I32(corners.collect())
}

/// Space for the largest offset.
const OFFSET_WIDTH: usize = 20;

impl<'a> Document<'a> {
    fn open(&mut self, grid: &VtuGrid, cells: usize) {
        let compressor = match self.options.compression {
            VtuCompression::None => "",
            VtuCompression::Adaptive | VtuCompression::Level(_) => {
                " compressor=\"vtkZLibDataCompressor\""
            }
        };
        self.xml.push_str("<?xml version=\"1.0\"?>\n");
        let _ = writeln!(
            self.xml,
            "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"{compressor}>\n  \
             <UnstructuredGrid>"
        );
        if let Some(time) = grid.time {
            let _ = writeln!(
                self.xml,
                "    <FieldData>\n      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{time:?}</DataArray>\n    </FieldData>"
            );
        }
        let points = grid.points.len();
        let _ = writeln!(
            self.xml,
            "    <Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">"
        );
    }

    fn arrays(&mut self, element: &str, arrays: &'a [VtuArray]) {
        let _ = writeln!(self.xml, "      <{element}>");
        for array in arrays {
            self.array(&array.name, borrow(&array.values));
        }
        let _ = writeln!(self.xml, "      </{element}>");
    }

    fn array(&mut self, name: &str, values: VtuValues<'a>) {
        let kind = values.type_name(self.options.precision);
        let _ = write!(self.xml, "        <DataArray type=\"{kind}\" Name=\"");
        escape(name, &mut self.xml);
        self.xml.push('"');
        // With `NumberOfComponents="1"` meshio reads a number as a column of its own.
        if let components @ 2.. = values.components() {
            let _ = write!(self.xml, " NumberOfComponents=\"{components}\"");
        }
        self.xml.push_str(" format=\"appended\" offset=\"");
        self.places.push(self.xml.len());
        let _ = writeln!(self.xml, "{:OFFSET_WIDTH$}\"/>", "");
        self.arrays.push(values);
    }

    /// Encodes the arrays and writes the offset of each into the XML.
    fn close(mut self) -> Vec<Vec<u8>> {
        let options = self.options;
        let encode = |values: &VtuValues| blocks::encode(values, options);
        let encoded: Vec<Vec<Vec<u8>>> = if options.parallel {
            self.arrays.par_iter().map(encode).collect()
        } else {
            self.arrays.iter().map(encode).collect()
        };
        let mut offset = 0;
        for (&place, parts) in self.places.iter().zip(&encoded) {
            // Blanks before the closing quote would be part of the number, so the padding follows the quote.
            let text = format!("{offset}\"/>");
            let room = place..place + OFFSET_WIDTH + 3;
            let text = format!("{text:<width$}", width = OFFSET_WIDTH + 3);
            self.xml.replace_range(room, &text);
            offset += parts.iter().map(Vec::len).sum::<usize>();
        }
        self.xml
            .push_str("  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n_");
        let mut parts = vec![self.xml.into_bytes()];
        parts.extend(encoded.into_iter().flatten());
        parts.push(b"\n  </AppendedData>\n</VTKFile>\n".to_vec());
        parts
    }
}

/// Borrowed view of the values.
fn borrow<'a>(values: &'a VtuValues) -> VtuValues<'a> {
    match values {
        VtuValues::F64(v) => VtuValues::F64(v.as_ref().into()),
        VtuValues::Vectors(v) => VtuValues::Vectors(v.as_ref().into()),
        VtuValues::Quaternions(v) => VtuValues::Quaternions(v.as_ref().into()),
        VtuValues::U8(v) => VtuValues::U8(v.as_ref().into()),
        VtuValues::I32(v) => VtuValues::I32(v.as_ref().into()),
        VtuValues::U32(v) => VtuValues::U32(v.as_ref().into()),
        VtuValues::I64(v) => VtuValues::I64(v.as_ref().into()),
        VtuValues::U64(v) => VtuValues::U64(v.as_ref().into()),
        VtuValues::Sequence {
            start,
            step,
            length,
        } => sequence(*start, *step, *length),
        VtuValues::Constant { value, length } => VtuValues::Constant {
            value: *value,
            length: *length,
        },
    }
}

/// Appends text as it stands in an XML attribute.
pub(super) fn escape(text: &str, out: &mut String) {
    for letter in text.chars() {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            // Readers take the first three as they stand for blanks.
            '\t' | '\n' | '\r' | '\u{7f}'..='\u{9f}' => {
                let _ = write!(out, "&#{};", u32::from(letter));
            }
            // Not allowed in XML at all.
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
}
