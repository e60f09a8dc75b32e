//! Frames as a table of polars.

use std::any::Any;
use std::ops::Range;
use std::sync::{Arc, PoisonError};

use mercury_common::frames::{Column, ColumnKind, FrameReader};
use polars::prelude::{
    AnonymousScan, AnonymousScanArgs, Column as PolarsColumn, DataFrame, DataType, Expr, Field,
    IdxSize, IntoColumn as _, IntoLazy as _, LazyFrame, NamedFrom as _, Operator, PlSmallStr,
    PolarsError, PolarsResult, ScanArgsAnonymous, Schema, SchemaRef, Series, col,
};
use polars_plan::dsl::FileScanIR;
use polars_plan::plans::{ArenaLpIter as _, IR};
use polars_plan::utils::expr_to_leaf_column_names_iter;

use super::Broken;

/// For some columns of indices the names that they stand for.
pub type Labels = Vec<(String, Vec<String>)>;

/// The time of a frame, the number of steps made, and its number: the same in each of its rows.
const OF_FRAMES: [(&str, DataType); 3] = [
    ("time", DataType::Float64),
    ("step", DataType::UInt64),
    ("frame", DataType::UInt64),
];
/// The number of a row among all that are read; it is in no query.
const ROW: &str = "row of all frames";

/// Frames that are read when a query needs them.
#[derive(Debug)]
pub(super) struct Frames {
    reader: FrameReader,
    labels: Labels,
    schema: SchemaRef,
}

impl Frames {
    pub(super) fn new(reader: FrameReader, labels: Labels) -> Self {
        let specs = reader.schema().columns().iter();
        let is_named = |name: &str| labels.iter().any(|(column, _)| column == name);
        let columns = specs.map(|spec| {
            let kind = match spec.kind {
                _ if is_named(&spec.name) => DataType::String,
                ColumnKind::F64 => DataType::Float64,
                ColumnKind::I32 => DataType::Int32,
                // Polars as it is built here has no smaller type.
                ColumnKind::U8 | ColumnKind::U32 | ColumnKind::OptionalU32 => DataType::UInt32,
                ColumnKind::U64 => DataType::UInt64,
                ColumnKind::Text => DataType::String,
            };
            Field::new(spec.name.as_str().into(), kind)
        });
        let of_frames = OF_FRAMES.map(|(name, kind)| Field::new(name.into(), kind));
        // A column of the file has precedence over the number of the frame.
        let mut schema = Schema::from_iter(of_frames);
        schema.extend(columns);
        Self {
            schema: Arc::new(schema),
            reader,
            labels,
        }
    }

    pub(super) fn names(&self) -> Vec<&str> {
        self.schema.iter_names().map(PlSmallStr::as_str).collect()
    }

    /// The table as a scan that is never made, to which polars hands the filters of a query.
    pub(super) fn to_be_filtered(self: &Arc<Self>) -> PolarsResult<LazyFrame> {
        let schema = Some(Arc::clone(&self.schema));
        let scan = Arc::new(Scan(Arc::clone(self)));
        let arguments = ScanArgsAnonymous {
            schema,
            ..ScanArgsAnonymous::default()
        };
        LazyFrame::anonymous_scan(scan, arguments)
    }

    /// The frames that pass one of the filters of this table, as far as time, step and number decide.
    pub(super) fn that_can_count(self: &Arc<Self>, filters: &[Filter]) -> Vec<usize> {
        let all: Vec<usize> = (0..self.reader.len()).collect();
        let mine = filters
            .iter()
            .filter(|filter| Arc::ptr_eq(&filter.table, self));
        let mut conditions = Vec::new();
        for filter in mine {
            match filter
                .condition
                .clone()
                .and_then(|all| self.about_frames(all))
            {
                Some(condition) => conditions.push(condition),
                None => return all,
            }
        }
        let Some(condition) = conditions.into_iter().reduce(Expr::or) else {
            return all;
        };
        let passing = || -> PolarsResult<Vec<usize>> {
            let infos: Vec<_> = self.reader.infos().collect();
            let number = |k: &usize| *k as u64;
            let times: Vec<f64> = infos.iter().map(|info| info.time).collect();
            let steps: Vec<u64> = infos.iter().map(|info| info.step).collect();
            let numbers: Vec<u64> = all.iter().map(number).collect();
            let columns = vec![
                Series::new("time".into(), times).into_column(),
                Series::new("step".into(), steps).into_column(),
                Series::new("frame".into(), numbers).into_column(),
            ];
            let table = DataFrame::new(infos.len(), columns)?.lazy();
            let table = table.filter(condition).select([col("frame")]).collect()?;
            let numbers = table.column("frame")?.u64()?.into_no_null_iter();
            Ok(numbers.map(|number| number as usize).collect())
        };
        // Filters that frames alone cannot decide are decided row by row.
        passing().unwrap_or(all)
    }

    /// Part of the conditions that must all hold: those on time, step and number of a frame alone.
    fn about_frames(&self, condition: Expr) -> Option<Expr> {
        match condition {
            Expr::BinaryExpr {
                left,
                op: Operator::And | Operator::LogicalAnd,
                right,
            } => {
                let [left, right] = [left, right].map(|part| self.about_frames((*part).clone()));
                match (left, right) {
                    (Some(left), Some(right)) => Some(left.and(right)),
                    (left, right) => left.or(right),
                }
            }
            other => {
                let is_of_frame = |name: PlSmallStr| {
                    self.reader.schema().index_of(&name).is_none()
                        && OF_FRAMES.iter().any(|(known, _)| name == *known)
                };
                let known = expr_to_leaf_column_names_iter(&other).all(is_of_frame);
                known.then_some(other)
            }
        }
    }

    /// The rows of these frames. Columns that a query does not need are not read, and others a part at a time.
    pub(super) fn lazy(
        self: &Arc<Self>,
        frames: Vec<usize>,
        broken: &Broken,
    ) -> PolarsResult<LazyFrame> {
        let rows = |k: &usize| self.reader.info(*k).map_or(0, |info| info.rows);
        let mut ends = Vec::with_capacity(frames.len());
        let mut total = 0_usize;
        for k in &frames {
            total = total.saturating_add(rows(k));
            ends.push(total);
        }
        if IdxSize::try_from(total).is_err() {
            return Err(PolarsError::ComputeError(
                format!(
                    "{total} rows are more than a query can have, {}: select frames with WHERE time > ...",
                    IdxSize::MAX
                )
                .into(),
            ));
        }
        let chosen = Arc::new(Chosen {
            table: Arc::clone(self),
            frames,
            ends,
        });
        let columns = self.schema.iter().map(|(name, kind)| {
            let (chosen, broken) = (Arc::clone(&chosen), Arc::clone(broken));
            let (column, field) = (name.clone(), Field::new(name.clone(), kind.clone()));
            let read = move |rows: PolarsColumn| chosen.read(&column, &rows, &broken);
            let column = col(ROW).map(read, move |_, _| Ok(field.clone()));
            column.alias(name.clone())
        });
        let rows = DataFrame::new(total, Vec::new())?.lazy();
        Ok(rows
            .with_row_index(ROW, None)
            .select(columns.collect::<Vec<_>>()))
    }
}

/// Some frames of a table.
struct Chosen {
    table: Arc<Frames>,
    frames: Vec<usize>,
    /// The number of rows of each frame and of those before it.
    ends: Vec<usize>,
}

impl Chosen {
    /// A column in these rows of all chosen frames.
    fn read(&self, name: &str, rows: &PolarsColumn, broken: &Broken) -> PolarsResult<PolarsColumn> {
        let rows = rows.idx()?.iter().flatten().map(|row| row as usize);
        let table = &self.table;
        let (mut values, mut failed) = (None::<Column>, None);
        for (k, rows) in self.parts(rows) {
            let info = table.reader.info(k);
            let count = rows.len();
            let constant = |value| Column::U64(vec![value; count]);
            let part = match (name, table.reader.schema().index_of(name), info) {
                (_, Some(_), _) => table.reader.rows(k, name, rows),
                ("time", None, Some(info)) => Ok(Column::F64(vec![info.time; count])),
                ("step", None, Some(info)) => Ok(constant(info.step)),
                _ => Ok(constant(k as u64)),
            };
            match part {
                Ok(part) => match &mut values {
                    Some(values) => extend(values, part),
                    none => *none = Some(part),
                },
                Err(error) => {
                    failed = Some(error);
                    break;
                }
            }
        }
        if let Some(error) = failed {
            let words = error.to_string();
            let mut first = broken.lock().unwrap_or_else(PoisonError::into_inner);
            first.get_or_insert(error);
            return Err(PolarsError::ComputeError(words.into()));
        }
        let labels = table.labels.iter().find(|(column, _)| column == name);
        let labels = labels.map(|(_, labels)| labels.as_slice());
        let series = match values {
            Some(values) => series(name, values, labels),
            None => Series::new_empty(name.into(), table.schema.try_get(name)?),
        };
        Ok(series.into_column())
    }

    /// Rows that follow each other in one frame, with the number of the frame.
    fn parts(&self, rows: impl Iterator<Item = usize>) -> Vec<(usize, Range<usize>)> {
        let mut parts = Vec::<(usize, Range<usize>)>::new();
        // Rows of all frames that continue the last part.
        let mut next = 0..0;
        for row in rows {
            if row == next.start && !next.is_empty() {
                if let Some((_, part)) = parts.last_mut() {
                    part.end += 1;
                }
                next.start += 1;
                continue;
            }
            let place = self.ends.partition_point(|&end| end <= row);
            let start = place.checked_sub(1).map_or(0, |before| self.ends[before]);
            parts.push((self.frames[place], row - start..row - start + 1));
            next = row + 1..self.ends[place];
        }
        parts
    }
}

/// Appends values of the same kind.
fn extend(values: &mut Column, part: Column) {
    match (values, part) {
        (Column::F64(values), Column::F64(part)) => values.extend(part),
        (Column::I32(values), Column::I32(part)) => values.extend(part),
        (Column::U8(values), Column::U8(part)) => values.extend(part),
        (Column::U32(values), Column::U32(part)) => values.extend(part),
        (Column::OptionalU32(values), Column::OptionalU32(part)) => values.extend(part),
        (Column::U64(values), Column::U64(part)) => values.extend(part),
        (Column::Text(values), Column::Text(part)) => values.extend(part),
        // A file has one kind for a column.
        _ => {}
    }
}

/// The values as polars has them, indices as the names that they stand for (as numbers where they have none).
fn series(name: &str, values: Column, labels: Option<&[String]>) -> Series {
    let name = name.into();
    let label = |index: u32| match labels.and_then(|labels| labels.get(index as usize)) {
        Some(label) => label.clone(),
        None => index.to_string(),
    };
    match (values, labels) {
        (Column::U32(values), Some(_)) => {
            let words: Vec<String> = values.into_iter().map(label).collect();
            Series::new(name, words)
        }
        (Column::OptionalU32(values), Some(_)) => {
            let word = |index: Option<u32>| index.map(label);
            Series::new(name, values.into_iter().map(word).collect::<Vec<_>>())
        }
        (Column::F64(values), _) => Series::new(name, values),
        (Column::I32(values), _) => Series::new(name, values),
        (Column::U8(values), _) => {
            Series::new(name, values.into_iter().map(u32::from).collect::<Vec<_>>())
        }
        (Column::U32(values), _) => Series::new(name, values),
        (Column::OptionalU32(values), _) => Series::new(name, values),
        (Column::U64(values), _) => Series::new(name, values),
        (Column::Text(values), _) => Series::new(name, values),
    }
}

/// Filter of the rows of a table of frames that a query needs; all where there is no condition.
pub(super) struct Filter {
    table: Arc<Frames>,
    condition: Option<Expr>,
}

/// The filters that polars hands to the scans of a plan.
pub(super) fn filters(lazy: LazyFrame) -> PolarsResult<Vec<Filter>> {
    let plan = lazy.to_alp_optimized()?;
    let nodes = plan.lp_arena.iter(plan.lp_top);
    let filters = nodes.filter_map(|(_, node)| {
        let IR::Scan {
            scan_type,
            predicate,
            ..
        } = node
        else {
            return None;
        };
        let FileScanIR::Anonymous { function, .. } = scan_type.as_ref() else {
            return None;
        };
        let scan: &Scan = function.as_any().downcast_ref()?;
        Some(Filter {
            table: Arc::clone(&scan.0),
            condition: predicate
                .as_ref()
                .map(|filter| filter.to_expr(&plan.expr_arena)),
        })
    });
    Ok(filters.collect())
}

/// A scan that is planned, never made.
struct Scan(Arc<Frames>);

impl AnonymousScan for Scan {
    fn as_any(&self) -> &dyn Any {
        self
    }

    fn scan(&self, _: AnonymousScanArgs) -> PolarsResult<DataFrame> {
        Ok(DataFrame::empty_with_schema(&self.0.schema))
    }

    fn allows_predicate_pushdown(&self) -> bool {
        true
    }

    fn allows_projection_pushdown(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use mercury_common::frames::{ColumnSpec, Frame, FrameSchema, FrameWriter};
    use polars::prelude::Engine;
    use polars::sql::SQLContext;

    use super::*;

    /// `frames` frames at 0, 0.1, ... s, each with one row more than the one before, in which x counts all rows of the file.
    fn table(
        folder: &tempfile::TempDir,
        frames: usize,
        rows: impl Fn(usize) -> usize,
    ) -> Arc<Frames> {
        let path = folder.path().join("a.particles.arrow");
        let columns = vec![
            ColumnSpec::new("x", ColumnKind::F64, "m"),
            ColumnSpec::new("material", ColumnKind::U32, "1"),
            ColumnSpec::new("body", ColumnKind::OptionalU32, "1"),
            ColumnSpec::new("word", ColumnKind::Text, ""),
        ];
        let schema = FrameSchema::new("particles", columns).unwrap();
        let mut writer = FrameWriter::create(&path, schema).unwrap();
        let mut first = 0;
        for k in 0..frames {
            let numbers = first..first + rows(k);
            let whole = |n: usize| n as u32;
            let columns = vec![
                Column::F64(numbers.clone().map(|n| n as f64).collect()),
                Column::U32(numbers.clone().map(|n| whole(n % 3)).collect()),
                Column::OptionalU32(
                    numbers
                        .clone()
                        .map(|n| (n % 5 > 0).then_some(whole(n)))
                        .collect(),
                ),
                Column::Text(numbers.clone().map(|n| format!("n{n}")).collect()),
            ];
            let (time, step) = (0.1 * k as f64, 10 * k as u64);
            writer
                .append(&Frame {
                    time,
                    step,
                    columns,
                })
                .unwrap();
            first = numbers.end;
        }
        drop(writer);
        let labels = vec![(
            "material".to_owned(),
            vec!["glass".to_owned(), "steel".to_owned()],
        )];
        Arc::new(Frames::new(FrameReader::open(&path).unwrap(), labels))
    }

    fn run(table: &Arc<Frames>, sql: &str) -> DataFrame {
        let mut context = SQLContext::new();
        let frames = (0..table.reader.len()).collect();
        let lazy = table.lazy(frames, &Broken::default()).unwrap();
        context.register("particles", lazy);
        let lazy = context.execute(sql).unwrap();
        lazy.collect_with_engine(Engine::Streaming)
            .unwrap()
            .unwrap_single()
    }

    #[test]
    fn filters_of_time_step_and_number_choose_frames() {
        let folder = tempfile::tempdir().unwrap();
        let table = table(&folder, 10, |k| k);
        let chosen = |sql: &str| {
            let mut context = SQLContext::new();
            context.register("particles", table.to_be_filtered().unwrap());
            table.that_can_count(&filters(context.execute(sql).unwrap()).unwrap())
        };
        let all: Vec<usize> = (0..10).collect();
        assert_eq!(
            chosen("SELECT x FROM particles WHERE time > 0.65"),
            [7, 8, 9]
        );
        assert_eq!(
            chosen("SELECT x FROM particles WHERE time > 0.65 AND x > 3"),
            [7, 8, 9]
        );
        assert_eq!(
            chosen("SELECT x FROM particles WHERE step = 20 OR frame = 4"),
            [2, 4]
        );
        assert_eq!(
            chosen("SELECT x FROM particles WHERE time > 0.65 OR x > 3"),
            all
        );
        assert_eq!(chosen("SELECT SUM(x) FROM particles"), all);
        assert_eq!(
            chosen(
                "SELECT a.x FROM particles a JOIN particles b ON a.x = b.x WHERE a.frame = 1 AND b.frame = 3"
            ),
            [1, 3]
        );
        let below =
            "SELECT m FROM (SELECT material AS m, time AS t FROM particles) AS q WHERE t < 0.15";
        assert_eq!(chosen(below), [0, 1]);
    }

    #[test]
    fn sums_over_many_parts_are_those_of_the_frames() {
        let folder = tempfile::tempdir().unwrap();
        // More rows than polars handles at a time, and frames without rows between them.
        let table = table(&folder, 40, |k| if k % 7 == 3 { 0 } else { 9_000 + k });
        let (mut sum, mut bodies, mut rows, mut late) = (0.0, 0_u64, 0, 0.0);
        for frame in table.reader.frames() {
            let frame = frame.unwrap();
            let x = frame.columns[0].as_f64().unwrap();
            sum += x.iter().sum::<f64>();
            rows += x.len();
            if frame.time > 2.0 {
                late += x.iter().sum::<f64>();
            }
            if let Column::OptionalU32(body) = &frame.columns[2] {
                bodies += body
                    .iter()
                    .flatten()
                    .map(|&body| u64::from(body))
                    .sum::<u64>();
            }
        }
        let number = |found: &DataFrame, name: &str| {
            let column = found
                .column(name)
                .unwrap()
                .cast(&DataType::Float64)
                .unwrap();
            column.f64().unwrap().get(0).unwrap()
        };
        // Whole numbers below 2^53: their sums are exact in any order.
        let all = run(
            &table,
            "SELECT SUM(x) AS x, COUNT(*) AS n, SUM(CAST(body AS BIGINT)) AS body FROM particles",
        );
        assert_eq!(number(&all, "x"), sum);
        assert_eq!(number(&all, "n"), rows as f64);
        assert_eq!(number(&all, "body"), bodies as f64);
        let some = run(&table, "SELECT SUM(x) AS x FROM particles WHERE time > 2.0");
        assert_eq!(number(&some, "x"), late);
        let words = run(
            &table,
            "SELECT COUNT(*) AS n FROM particles WHERE word = 'n123' AND material = 'glass' AND x = 123",
        );
        assert_eq!(number(&words, "n"), 1.0);
        // A material without a name has its number: rows 2, 5, 8, ...
        let other = run(
            &table,
            "SELECT MIN(x) AS x FROM particles WHERE material = '2'",
        );
        assert_eq!(number(&other, "x"), 2.0);
    }
}
