//! Round trip of written tables, bit for bit.

use mercury_tables::{Column, Kind, ParquetWriter, Spec, Table, Values};
use proptest::collection::vec;
use proptest::prelude::*;

const KINDS: [Kind; 9] = [
    Kind::F64,
    Kind::I32,
    Kind::I64,
    Kind::U8,
    Kind::U32,
    Kind::OptionalU32,
    Kind::U64,
    Kind::Bool,
    Kind::Text,
];

/// Every pattern of bits, and often those that are easily confused: zeros of both signs, NaN of any payload, repeated values.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits),
        prop::sample::select(vec![
            0.0,
            -0.0,
            f64::NAN,
            -f64::NAN,
            f64::from_bits(0x7ff0_0000_0000_0001),
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::MIN_POSITIVE / 4.0,
            0.1,
        ]),
    ]
}

fn values(kind: Kind, rows: usize) -> BoxedStrategy<Values> {
    match kind {
        Kind::F64 => vec(number(), rows).prop_map(Values::F64).boxed(),
        Kind::I32 => vec(any::<i32>(), rows).prop_map(Values::I32).boxed(),
        Kind::I64 => vec(any::<i64>(), rows).prop_map(Values::I64).boxed(),
        Kind::U8 => vec(any::<u8>(), rows).prop_map(Values::U8).boxed(),
        Kind::U32 => vec(0..4u32, rows).prop_map(Values::U32).boxed(),
        Kind::OptionalU32 => vec(any::<Option<u32>>(), rows)
            .prop_map(Values::OptionalU32)
            .boxed(),
        Kind::U64 => vec(any::<u64>(), rows).prop_map(Values::U64).boxed(),
        Kind::Bool => vec(any::<bool>(), rows).prop_map(Values::Bool).boxed(),
        Kind::Text => vec(".{0,8}", rows).prop_map(Values::Text).boxed(),
    }
}

/// Batches of the same columns, some of them empty.
fn batches() -> impl Strategy<Value = (Vec<Kind>, Vec<Vec<Values>>)> {
    let kinds = vec(prop::sample::select(KINDS.to_vec()), 1..5);
    kinds.prop_flat_map(|kinds| {
        let columns = kinds.clone();
        let batch = (0..40usize).prop_flat_map(move |rows| {
            let column = |kind: &Kind| values(*kind, rows);
            columns.iter().map(column).collect::<Vec<_>>()
        });
        (Just(kinds), vec(batch, 0..5))
    })
}

/// A form in which equal means equal bits.
fn bits(table: &Table, name: &str, kind: Kind) -> Vec<String> {
    fn shown<T: std::fmt::Debug>(values: Vec<T>) -> Vec<String> {
        values.iter().map(|value| format!("{value:?}")).collect()
    }
    match kind {
        Kind::F64 => shown(
            (table.values::<f64>(name).unwrap().iter())
                .map(|v| v.to_bits())
                .collect(),
        ),
        Kind::I32 => shown(table.values::<i32>(name).unwrap()),
        Kind::I64 => shown(table.values::<i64>(name).unwrap()),
        Kind::U8 => shown(table.values::<u8>(name).unwrap()),
        Kind::U32 => shown(table.values::<u32>(name).unwrap()),
        Kind::OptionalU32 => shown(table.values::<Option<u32>>(name).unwrap()),
        Kind::U64 => shown(table.values::<u64>(name).unwrap()),
        Kind::Bool => shown(table.values::<bool>(name).unwrap()),
        Kind::Text => shown(table.values::<String>(name).unwrap()),
    }
}

proptest! {
    #[test]
    fn batches_are_read_back((kinds, batches) in batches()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.parquet");
        let name = |k: usize| format!("column {k}, \"quoted\" [µ]");
        let specs: Vec<Spec> = (kinds.iter().enumerate())
            .map(|(k, kind)| Spec::new(name(k), ["", "1", "m/s²"][k % 3], *kind))
            .collect();
        let metadata = [("made by".to_owned(), "a test, é".to_owned()), ("empty".to_owned(), String::new())];
        let mut writer = ParquetWriter::create(&path, specs.clone(), &metadata).unwrap();
        for batch in &batches {
            writer.write(batch.clone()).unwrap();
        }
        prop_assert!(!path.exists(), "the file has its name before it is whole");
        writer.finish().unwrap();

        let found = Table::read(&path).unwrap();
        let rows: usize = batches.iter().map(|batch| batch[0].len()).sum();
        prop_assert_eq!(found.rows(), rows);
        prop_assert_eq!(&found.metadata, &metadata);
        for (k, kind) in kinds.iter().enumerate() {
            prop_assert_eq!(&found.columns()[k].name, &specs[k].name);
            prop_assert_eq!(&found.columns()[k].unit, &specs[k].unit);
            let expected: Vec<String> = (batches.iter())
                .flat_map(|batch| {
                    let column = Column::new("c", "", batch[k].clone());
                    bits(&Table::default().with(column), "c", *kind)
                })
                .collect();
            prop_assert_eq!(bits(&found, &name(k), *kind), expected, "{:?}", kind);
        }
    }

    #[test]
    fn numbers_in_text_are_read_back(rows in vec((number(), any::<u64>(), "[a-z \",;]{0,6}"), 0..30), separator in prop::sample::select(vec![',', ';', '\t'])) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        let mut text = format!("\u{feff}# written by a test\n\nx [m]{separator}count{separator}\"a name\"\r\n");
        for (x, count, name) in &rows {
            let name = name.replace('"', "\"\"");
            text += &format!("{x:?}{separator} {count} {separator}\"{name}\"\n# between rows\n");
        }
        std::fs::write(&path, text).unwrap();
        let table = Table::read(&path).unwrap();
        prop_assert_eq!(table.rows(), rows.len());
        prop_assert_eq!(&table.columns()[0].unit, "m");
        let x = table.values::<f64>("x").unwrap();
        // Text has one NaN.
        prop_assert!(x.iter().zip(&rows).all(|(a, (b, ..))| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())));
        let counts: Vec<u64> = rows.iter().map(|row| row.1).collect();
        prop_assert_eq!(table.values::<u64>("count").unwrap(), counts);
        let names: Vec<String> = rows.iter().map(|row| row.2.clone()).collect();
        prop_assert_eq!(table.values::<String>("a name").unwrap(), names);
    }
}

#[test]
fn a_table_without_rows_keeps_its_columns() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("empty.parquet");
    let table = KINDS
        .iter()
        .enumerate()
        .fold(Table::default(), |table, (k, kind)| {
            let values = match kind {
                Kind::F64 => Values::F64(vec![]),
                Kind::I32 => Values::I32(vec![]),
                Kind::I64 => Values::I64(vec![]),
                Kind::U8 => Values::U8(vec![]),
                Kind::U32 => Values::U32(vec![]),
                Kind::OptionalU32 => Values::OptionalU32(vec![]),
                Kind::U64 => Values::U64(vec![]),
                Kind::Bool => Values::Bool(vec![]),
                Kind::Text => Values::Text(vec![]),
            };
            table.with(Column::new(k.to_string(), "m", values))
        });
    let specs = table.specs();
    table.write_parquet(&path).unwrap();
    let found = Table::read_parquet(&path).unwrap();
    assert_eq!(found.rows(), 0);
    for (found, expected) in found.specs().into_iter().zip(specs) {
        assert_eq!((&found.name, &found.unit), (&expected.name, &expected.unit));
        // Whether values might be missing is only seen where some are.
        let or_missing = expected.kind == Kind::OptionalU32 && found.kind == Kind::U32;
        assert!(found.kind == expected.kind || or_missing, "{found:?}");
    }
}

#[test]
fn a_table_without_columns_is_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nothing.parquet");
    Table::default().write_parquet(&path).unwrap();
    let found = Table::read_parquet(&path).unwrap();
    assert_eq!((found.rows(), found.columns().len()), (0, 0));
}

#[test]
fn whole_numbers_are_numbers_where_that_is_exact() {
    let exact = (1u64 << 53) + 2;
    let column = |values| Table::default().with(Column::new("n", "1", values));
    let numbers = column(Values::U64(vec![0, 7, exact])).values::<f64>("n");
    assert_eq!(numbers.unwrap(), [0.0, 7.0, 2.0f64.powi(53) + 2.0]);
    for wrong in [exact - 1, u64::MAX] {
        let error = column(Values::U64(vec![1, wrong])).values::<f64>("n");
        let error = error.unwrap_err().to_string();
        let start = format!(": {wrong} in row 2 of column `n`, expected a number");
        assert!(error.starts_with(&start), "{error}");
    }
    let small = column(Values::I64(vec![-1, 200]));
    assert!(small.values::<u8>("n").is_err());
    assert_eq!(small.values::<i32>("n").unwrap(), [-1, 200]);
}
