//! Between typed lists and flat columns: vectors, quaternions, ids that may be missing.

use glam::{DQuat, DVec3};

use super::{Column, ColumnKind, ColumnSpec, Frame, FrameSchema};

/// Operation on every column of a [`Table`](super::Table): noting its description, putting its values into a frame, or taking
/// them out of one. `names` are those of the flat columns, as many as the values have components.
pub trait ColumnVisitor {
    /// A column that every file of the table has.
    fn column<V: Values>(&mut self, values: &mut V, names: &[&str], unit: &str, description: &str);

    /// A column that a file may have, and `in_file` has.
    fn optional<V: Values>(
        &mut self,
        in_file: bool,
        values: &mut Option<V>,
        names: &[&str],
        unit: &str,
        description: &str,
    );

    /// Columns of numbers, as many as the file has.
    fn numbers(&mut self, lists: &mut Vec<Vec<f64>>, in_file: &[ColumnSpec]);
}

/// A list that stands in one flat column for each component of its entries.
pub trait Values: Default {
    /// The type of each column.
    const KIND: ColumnKind;

    /// The columns, one per component.
    fn split(self) -> Vec<Column>;

    /// The list of the columns, given with their names in the order of [`split`](Self::split).
    ///
    /// # Errors
    /// Says what a column is and should be.
    fn join(columns: Vec<(&str, Column)>) -> Result<Self, String>;
}

/// The descriptions of columns.
#[derive(Default)]
pub(super) struct Specs(pub(super) Vec<ColumnSpec>);

impl ColumnVisitor for Specs {
    fn column<V: Values>(&mut self, _: &mut V, names: &[&str], unit: &str, description: &str) {
        let spec = |name: &&str| ColumnSpec::new(*name, V::KIND, unit).described(description);
        self.0.extend(names.iter().map(spec));
    }

    fn optional<V: Values>(
        &mut self,
        in_file: bool,
        _: &mut Option<V>,
        names: &[&str],
        unit: &str,
        description: &str,
    ) {
        if in_file {
            self.column(&mut V::default(), names, unit, description);
        }
    }

    fn numbers(&mut self, _: &mut Vec<Vec<f64>>, in_file: &[ColumnSpec]) {
        self.0.extend_from_slice(in_file);
    }
}

/// The columns of a frame in the making.
#[derive(Default)]
pub(super) struct Put(pub(super) Vec<Column>);

impl ColumnVisitor for Put {
    fn column<V: Values>(&mut self, values: &mut V, _: &[&str], _: &str, _: &str) {
        self.0.extend(std::mem::take(values).split());
    }

    fn optional<V: Values>(
        &mut self,
        _: bool,
        values: &mut Option<V>,
        _: &[&str],
        _: &str,
        _: &str,
    ) {
        self.0.extend(values.take().into_iter().flat_map(V::split));
    }

    fn numbers(&mut self, lists: &mut Vec<Vec<f64>>, _: &[ColumnSpec]) {
        self.0.extend(lists.drain(..).map(Column::F64));
    }
}

/// Fills lists from a frame, and keeps what is wrong with it first.
pub(super) struct Take<'a> {
    columns: Columns<'a>,
    pub(super) result: Result<(), String>,
}

impl<'a> Take<'a> {
    pub(super) fn new(columns: Columns<'a>) -> Self {
        Self {
            columns,
            result: Ok(()),
        }
    }

    fn values<V: Values>(&mut self, names: &[&str]) -> V {
        match self.columns.take(names) {
            Ok(values) => values,
            Err(found) => {
                self.result = self.result.clone().and(Err(found));
                V::default()
            }
        }
    }
}

impl ColumnVisitor for Take<'_> {
    fn column<V: Values>(&mut self, values: &mut V, names: &[&str], _: &str, _: &str) {
        *values = self.values(names);
    }

    fn optional<V: Values>(
        &mut self,
        in_file: bool,
        values: &mut Option<V>,
        names: &[&str],
        _: &str,
        _: &str,
    ) {
        *values = in_file.then(|| self.values(names));
    }

    fn numbers(&mut self, lists: &mut Vec<Vec<f64>>, in_file: &[ColumnSpec]) {
        *lists = in_file
            .iter()
            .map(|spec| self.values(&[&spec.name]))
            .collect();
    }
}

/// The columns of a frame, taken out by name, whatever their order and whatever else is there.
pub(super) struct Columns<'a> {
    schema: &'a FrameSchema,
    columns: Vec<Column>,
}

impl<'a> Columns<'a> {
    pub(super) fn new(schema: &'a FrameSchema, frame: Frame) -> Self {
        Self {
            schema,
            columns: frame.columns,
        }
    }

    fn take<V: Values>(&mut self, names: &[&str]) -> Result<V, String> {
        let mut columns = Vec::with_capacity(names.len());
        for &name in names {
            let place = self.schema.index_of(name);
            let column = place.and_then(|k| self.columns.get_mut(k));
            let column = column.ok_or_else(|| format!("no column `{name}`"))?;
            columns.push((name, std::mem::replace(column, Column::U8(Vec::new()))));
        }
        V::join(columns)
    }
}

fn unlike<V: Values>(name: &str, found: &Column) -> String {
    let (found, expected) = (found.kind(), V::KIND);
    format!("column `{name}` is {found:?}, expected {expected:?}")
}

/// The one column of a list of plain values.
fn single(columns: Vec<(&str, Column)>) -> Result<(&str, Column), String> {
    let [column] = as_many(columns)?;
    Ok(column)
}

fn as_many<const N: usize>(columns: Vec<(&str, Column)>) -> Result<[(&str, Column); N], String> {
    let expected = |columns: Vec<(&str, Column)>| format!("{} columns for {N}", columns.len());
    columns.try_into().map_err(expected)
}

impl Values for Vec<f64> {
    const KIND: ColumnKind = ColumnKind::F64;

    fn split(self) -> Vec<Column> {
        vec![Column::F64(self)]
    }

    fn join(columns: Vec<(&str, Column)>) -> Result<Self, String> {
        match single(columns)? {
            (_, Column::F64(values)) => Ok(values),
            (name, other) => Err(unlike::<Self>(name, &other)),
        }
    }
}

impl Values for Vec<u8> {
    const KIND: ColumnKind = ColumnKind::U8;

    fn split(self) -> Vec<Column> {
        vec![Column::U8(self)]
    }

    fn join(columns: Vec<(&str, Column)>) -> Result<Self, String> {
        match single(columns)? {
            (_, Column::U8(values)) => Ok(values),
            (name, other) => Err(unlike::<Self>(name, &other)),
        }
    }
}

/// 1 and 0; all but 0 reads as true.
impl Values for Vec<bool> {
    const KIND: ColumnKind = ColumnKind::U8;

    fn split(self) -> Vec<Column> {
        vec![Column::U8(self.into_iter().map(u8::from).collect())]
    }

    fn join(columns: Vec<(&str, Column)>) -> Result<Self, String> {
        Ok(Vec::<u8>::join(columns)?
            .into_iter()
            .map(|value| value != 0)
            .collect())
    }
}

/// Read also from a column that might miss values (other programs call all columns nullable) but misses none.
impl Values for Vec<u32> {
    const KIND: ColumnKind = ColumnKind::U32;

    fn split(self) -> Vec<Column> {
        vec![Column::U32(self)]
    }

    fn join(columns: Vec<(&str, Column)>) -> Result<Self, String> {
        match single(columns)? {
            (_, Column::U32(values)) => Ok(values),
            (name, Column::OptionalU32(values)) => {
                let values: Option<Self> = values.into_iter().collect();
                values.ok_or_else(|| format!("column `{name}` misses values"))
            }
            (name, other) => Err(unlike::<Self>(name, &other)),
        }
    }
}

impl Values for Vec<Option<u32>> {
    const KIND: ColumnKind = ColumnKind::OptionalU32;

    fn split(self) -> Vec<Column> {
        vec![Column::OptionalU32(self)]
    }

    fn join(columns: Vec<(&str, Column)>) -> Result<Self, String> {
        match single(columns)? {
            (_, Column::U32(values)) => Ok(values.into_iter().map(Some).collect()),
            (_, Column::OptionalU32(values)) => Ok(values),
            (name, other) => Err(unlike::<Self>(name, &other)),
        }
    }
}

/// Columns x, y, z.
impl Values for Vec<DVec3> {
    const KIND: ColumnKind = ColumnKind::F64;

    fn split(self) -> Vec<Column> {
        let axis = |axis: usize| Column::F64(self.iter().map(|vector| vector[axis]).collect());
        (0..3).map(axis).collect()
    }

    fn join(columns: Vec<(&str, Column)>) -> Result<Self, String> {
        let columns: [_; 3] = as_many(columns)?;
        let [x, y, z] = columns.map(|column| Vec::<f64>::join(vec![column]));
        let parts = x?.into_iter().zip(y?).zip(z?);
        Ok(parts.map(|((x, y), z)| DVec3::new(x, y, z)).collect())
    }
}

/// Columns w, x, y, z.
impl Values for Vec<DQuat> {
    const KIND: ColumnKind = ColumnKind::F64;

    fn split(self) -> Vec<Column> {
        let part = |of: fn(&DQuat) -> f64| Column::F64(self.iter().map(of).collect());
        vec![part(|q| q.w), part(|q| q.x), part(|q| q.y), part(|q| q.z)]
    }

    fn join(columns: Vec<(&str, Column)>) -> Result<Self, String> {
        let columns: [_; 4] = as_many(columns)?;
        let [w, x, y, z] = columns.map(|column| Vec::<f64>::join(vec![column]));
        let parts = w?.into_iter().zip(x?).zip(y?).zip(z?);
        Ok(parts
            .map(|(((w, x), y), z)| DQuat::from_xyzw(x, y, z, w))
            .collect())
    }
}
