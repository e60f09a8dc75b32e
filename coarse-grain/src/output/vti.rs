//! Image data for ParaView: one value per cell of the grid.

use std::fmt::Write as _;

use crate::CgError;
use crate::analysis::{Block, Column};
use crate::coordinates::{Coordinates, GridAxis, Place};
use crate::evaluate::Evaluator;
use crate::fields::Components;
use crate::sums::SYMMETRIC;

/// A `.vti` file: cells of the grid; along directions that are not resolved there is one, as long as the domain. Vectors and tensors are
/// arrays of 3 and 9 components.
///
/// # Errors
/// When the fields are not on a Cartesian grid.
pub fn encode(evaluator: &Evaluator, block: &Block) -> Result<Vec<u8>, CgError> {
    let (Coordinates::Cartesian(resolved), Place::Grid(grid)) =
        (evaluator.coordinates, &evaluator.place)
    else {
        let found = "a .vti file holds fields on a grid of x, y, z";
        return Err(CgError::Input(format!(
            "{found}\nhelp: -o NAME.csv takes any points and coordinates"
        )));
    };
    let mut of_axis = grid.iter();
    let axes: Vec<GridAxis> = (0..3)
        .map(|axis| {
            let whole = GridAxis {
                min: block.space.min[axis],
                max: block.space.max[axis],
                count: 1,
            };
            if resolved[axis] {
                of_axis.next().copied().unwrap_or(whole)
            } else {
                whole
            }
        })
        .collect();
    let extent = format!(
        "0 {} 0 {} 0 {}",
        axes[0].count, axes[1].count, axes[2].count
    );
    // A plane of no thickness would have no cells.
    let step = |axis: &GridAxis| if axis.step() > 0.0 { axis.step() } else { 1.0 };
    let mut xml = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n",
    );
    let _ = writeln!(
        xml,
        "  <ImageData WholeExtent=\"{extent}\" Origin=\"{:?} {:?} {:?}\" Spacing=\"{:?} {:?} {:?}\">",
        axes[0].min,
        axes[1].min,
        axes[2].min,
        step(&axes[0]),
        step(&axes[1]),
        step(&axes[2])
    );
    let _ = writeln!(
        xml,
        "    <FieldData>\n      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{:?}</DataArray>\n{}    </FieldData>\n    <Piece Extent=\"{extent}\">\n      <CellData>",
        block.time,
        units(block)
    );
    let mut data: Vec<u8> = Vec::new();
    let mut rest = &block.columns[..];
    while let Some(first) = rest.first() {
        let (columns, others) = rest.split_at(first.field.components.count());
        rest = others;
        let part = first
            .part
            .as_ref()
            .map_or(String::new(), |part| format!("{part}."));
        array(
            &mut xml,
            &mut data,
            &format!("{part}{}", first.field.name),
            first.field.components,
            columns,
            &axes,
            |column| Some(&column.values),
        );
        if first.errors.is_some() {
            let name = format!("{part}{}_error", first.field.name);
            array(
                &mut xml,
                &mut data,
                &name,
                first.field.components,
                columns,
                &axes,
                |column| column.errors.as_ref(),
            );
        }
    }
    xml.push_str(
        "      </CellData>\n    </Piece>\n  </ImageData>\n  <AppendedData encoding=\"raw\">\n_",
    );
    let mut out = xml.into_bytes();
    out.extend(data);
    out.extend_from_slice(b"\n  </AppendedData>\n</VTKFile>\n");
    Ok(out)
}

/// Field data that name the unit of each array: `velocity_unit` is `m/s`.
fn units(block: &Block) -> String {
    let mut xml = String::new();
    let mut rest = &block.columns[..];
    while let Some(first) = rest.first() {
        rest = &rest[first.field.components.count()..];
        let part = first.part.as_ref();
        let part = part.map_or(String::new(), |part| format!("{part}."));
        let _ = writeln!(
            xml,
            "      <Array type=\"String\" Name=\"{}_unit\" NumberOfTuples=\"1\" format=\"ascii\">{}</Array>",
            escaped(&format!("{part}{}", first.field.name)),
            characters(first.field.unit)
        );
    }
    xml
}

/// A name as an attribute of XML.
fn escaped(name: &str) -> String {
    let mut escaped = String::new();
    for letter in name.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '"' => escaped.push_str("&quot;"),
            other => escaped.push(other),
        }
    }
    escaped
}

/// A text as VTK writes it in ASCII: the numbers of its bytes, and 0 at its end.
fn characters(text: &str) -> String {
    let bytes = text.bytes().map(|byte| byte.to_string());
    bytes.chain(["0".to_owned()]).collect::<Vec<_>>().join(" ")
}

fn array<'a>(
    xml: &mut String,
    data: &mut Vec<u8>,
    name: &str,
    components: Components,
    columns: &'a [Column],
    axes: &[GridAxis],
    values: impl Fn(&'a Column) -> Option<&'a Vec<f64>>,
) {
    // Which column stands at each component; symmetric tensors are written in full.
    let order: Vec<usize> = match components {
        Components::Symmetric => (0..9)
            .map(|k| {
                let (a, b) = (k / 3, k % 3);
                SYMMETRIC
                    .iter()
                    .position(|&pair| pair == (a.min(b), a.max(b)))
                    .unwrap_or(0)
            })
            .collect(),
        other => (0..other.count()).collect(),
    };
    let _ = write!(
        xml,
        "        <DataArray type=\"Float64\" Name=\"{}\"",
        escaped(name)
    );
    if order.len() > 1 {
        let _ = write!(xml, " NumberOfComponents=\"{}\"", order.len());
    }
    let _ = writeln!(xml, " format=\"appended\" offset=\"{}\"/>", data.len());
    let cells: usize = axes.iter().map(|axis| axis.count).product();
    data.extend_from_slice(&((cells * order.len() * 8) as u64).to_le_bytes());
    let columns: Vec<Option<&Vec<f64>>> = columns.iter().map(values).collect();
    // VTK counts x fastest, our grids z.
    let [nx, ny, nz] = [axes[0].count, axes[1].count, axes[2].count];
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let point = (i * ny + j) * nz + k;
                for &column in &order {
                    let value = columns
                        .get(column)
                        .copied()
                        .flatten()
                        .map_or(f64::NAN, |values| values[point]);
                    data.extend_from_slice(&value.to_le_bytes());
                }
            }
        }
    }
}
