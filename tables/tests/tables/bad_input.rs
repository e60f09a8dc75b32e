//! Errors in a file or a table give helpful messages, never a panic.

use std::fs;
use std::path::{Path, PathBuf};

use mercury_tables::{Column, Kind, ParquetWriter, Spec, Table, Values};
use proptest::prelude::*;

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn with(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, bytes).unwrap();
        path
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name();
        entries.map(|e| name(e).into_string().unwrap()).collect()
    }
}

fn small() -> Table {
    Table::default()
        .with(Column::new("x", "m", Values::F64(vec![0.5, f64::NAN, 2.0])))
        .with(Column::new("id", "1", Values::U32(vec![0, 1, 2])))
        .with(Column::new(
            "name",
            "",
            Values::Text(["a", "b", ""].map(String::from).to_vec()),
        ))
        .with(Column::new(
            "fixed",
            "1",
            Values::Bool(vec![true, false, true]),
        ))
        .with(Column::new(
            "body",
            "1",
            Values::OptionalU32(vec![None, Some(3), None]),
        ))
}

fn refused(path: &Path, message: &str) {
    let error = Table::read(path).unwrap_err().to_string();
    let expected = format!("{}{message}", path.display());
    assert_eq!(error, expected);
}

#[test]
fn columns_that_are_missing_or_of_another_type() {
    let place = Place::new();
    let path = place.path("t.parquet");
    small().write_parquet(&path).unwrap();
    let table = Table::read(&path).unwrap();
    let name = path.display();
    let errors = [
        (
            table.values::<f64>("radius").unwrap_err(),
            "no column `radius`\nhelp: its columns are x, id, name, fixed, body",
        ),
        (
            table.values::<f64>("name").unwrap_err(),
            "column `name` holds text, expected a number",
        ),
        (
            table.values::<String>("x").unwrap_err(),
            "column `x` holds numbers, expected text",
        ),
        (
            table.values::<u32>("fixed").unwrap_err(),
            "column `fixed` holds truth values, expected a whole number from 0 to 4294967295",
        ),
        (
            table.values::<bool>("id").unwrap_err(),
            "column `id` holds whole numbers, expected true or false",
        ),
        (
            table.values::<u32>("body").unwrap_err(),
            "nothing in row 1 of column `body`, expected a whole number from 0 to 4294967295",
        ),
    ];
    for (error, message) in errors {
        assert_eq!(error.to_string(), format!("{name}: {message}"));
    }
}

#[test]
fn files_that_are_no_tables() {
    let place = Place::new();
    let missing = place.path("missing.parquet");
    let error = Table::read(&missing).unwrap_err().to_string();
    assert!(
        error.contains("missing.parquet: the file cannot be read: "),
        "{error}"
    );
    assert!(Table::read(place.0.path()).is_err(), "a folder");
    for path in [place.with("a.parquet", ""), place.with("b.parquet", "PA")] {
        let error = Table::read_parquet(&path).unwrap_err().to_string();
        let message = "the file does not begin like a Parquet file, expected Parquet";
        assert_eq!(error, format!("{}: {message}", path.display()));
    }
    let cut = ": the end of the Parquet file is missing: it was cut, or is still being written";
    refused(&place.with("c.parquet", "PAR1"), cut);
    refused(&place.with("d.parquet", "PAR1PAR"), cut);
    for bytes in [
        &b"PAR1PAR1"[..],
        b"PAR1\xff\xff\xff\xffPAR1",
        b"PAR1\0\0\0\0PAR1",
    ] {
        let error = Table::read(&place.with("e.parquet", bytes)).unwrap_err();
        assert!(error.to_string().contains("e.parquet: the "), "{error}");
    }
}

/// Written by pyarrow 26: `pq.write_table(table, path, compression=...)` of columns x (numbers, one missing), d (dates), s (text),
/// c (a dictionary), i16, n (whole numbers, one missing), f32, l (lists), u32 (one missing).
#[test]
fn files_of_other_programs() {
    let path = |name: &str| {
        Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("tests/files")
            .join(name)
    };
    let table = Table::read(&path("snappy.parquet")).unwrap();
    let x = table.values::<f64>("x").unwrap();
    assert!(x[0] == 1.0 && x[1].is_nan() && x[2] == 3.0);
    assert_eq!(table.values::<String>("s").unwrap(), ["a", "b", "c"]);
    assert_eq!(table.values::<u8>("i16").unwrap(), [1, 2, 3]);
    let single = [0.1f32, 0.2, 0.3].map(f64::from);
    assert_eq!(table.values::<f64>("f32").unwrap(), single);
    let some = table.values::<Option<u32>>("u32").unwrap();
    assert_eq!(some, [Some(1), None, Some(7)]);
    let help = "\nhelp: columns of numbers, truth values and text can be read";
    for (name, what) in [
        ("d", "values of type Date32"),
        (
            "n",
            "missing values among whole numbers, truth values or text",
        ),
    ] {
        let error = table.values::<f64>(name).unwrap_err().to_string();
        let expected = format!("snappy.parquet: column `{name}` holds {what}{help}");
        assert!(error.ends_with(&expected), "{error}");
    }
    assert_eq!(table.values::<String>("c").unwrap(), ["u", "v", "u"]);
    assert!(table.values::<String>("l").is_err());
    let error = Table::read(&path("gzip.parquet")).unwrap_err().to_string();
    let expected = "gzip.parquet: the Parquet file cannot be read: it is compressed by GZIP, not by Snappy or Zstandard\n\
        help: write it by one of them, or uncompressed";
    assert!(error.ends_with(expected), "{error}");
}

#[test]
fn a_parquet_file_that_was_cut_anywhere() {
    let place = Place::new();
    let path = place.path("t.parquet");
    small().write_parquet(&path).unwrap();
    let bytes = fs::read(&path).unwrap();
    for length in 4..bytes.len() {
        let cut = place.with("cut.parquet", &bytes[..length]);
        let error = Table::read(&cut).unwrap_err().to_string();
        assert!(
            error.contains("cut.parquet: the end of the Parquet file"),
            "{length}: {error}"
        );
    }
}

proptest! {
    #[test]
    fn damage_never_brings_the_program_down(places in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4)) {
        let place = Place::new();
        let path = place.path("t.parquet");
        small().write_parquet(&path).unwrap();
        let mut bytes = fs::read(&path).unwrap();
        for (at, byte) in places {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        // Numbers may be others then; what matters is an answer.
        let _ = Table::read(&place.with("damaged.parquet", bytes));
    }

    #[test]
    fn text_of_any_kind_is_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..80), text in "[a-c,;\"\t\n# \\[\\]]{0,60}") {
        let place = Place::new();
        for bytes in [bytes, text.into_bytes()] {
            if let Ok(table) = Table::read(&place.with("t.csv", bytes)) {
                for column in table.columns() {
                    prop_assert_eq!(column.values.len(), table.rows());
                    let _ = table.values::<f64>(&column.name);
                }
            }
        }
    }
}

#[test]
fn text_that_is_no_table() {
    let place = Place::new();
    let text = |text: &str| place.with("t.csv", text);
    refused(
        &text(""),
        ": the file is empty, expected a line with the names of the columns",
    );
    refused(
        &text("# a comment\n\n"),
        ": the file is empty, expected a line with the names of the columns",
    );
    refused(
        &text("x,,y\n"),
        ":1: no name of column 2, expected a name in every column of the header",
    );
    refused(
        &text("x [m],y,x [mm]\n"),
        ":1: the name `x` twice, expected columns with different names",
    );
    refused(
        &text("# c\nx,y\n1,2\n\n3\n"),
        ":5: 1 fields, expected 2, as in the header",
    );
    refused(
        &text("x,y\n1,2,3\n"),
        ":2: 3 fields, expected 2, as in the header",
    );
    refused(
        &text("x,y\n\"1,2\n"),
        ":2:1: a quote that is not closed, expected a second one at the end of the field, or none",
    );
    refused(
        &place.with("t.csv", b"x,y\n1,\xff\n"),
        ":2:3: a byte that is not text, expected a text file in UTF-8\nhelp: save it as text with the encoding UTF-8",
    );
}

#[test]
fn fields_that_are_not_of_the_requested_type() {
    let place = Place::new();
    let path = place.with(
        "t.csv",
        "# sizes\nx;n;known\n1.5;2;true\n\n-0,5;2.5;yes\n;-1;\n",
    );
    let table = Table::read(&path).unwrap();
    let name = path.display();
    let errors = [
        (
            table.values::<f64>("x").unwrap_err(),
            ":5: \"-0,5\" in column `x`, expected a number",
        ),
        (
            table.values::<u32>("n").unwrap_err(),
            ":5: \"2.5\" in column `n`, expected a whole number from 0 to 4294967295",
        ),
        (
            table.values::<bool>("known").unwrap_err(),
            ":5: \"yes\" in column `known`, expected true or false",
        ),
        (
            table.values::<f64>("y").unwrap_err(),
            ": no column `y`\nhelp: its columns are x, n, known",
        ),
    ];
    for (error, message) in errors {
        assert_eq!(error.to_string(), format!("{name}{message}"));
    }
    assert_eq!(table.values::<f64>("n").unwrap(), [2.0, 2.5, -1.0]);
    assert_eq!(table.values::<String>("x").unwrap(), ["1.5", "-0,5", ""]);
}

#[test]
fn columns_that_make_no_table_are_refused() {
    let place = Place::new();
    let path = place.path("t.parquet");
    let name = path.display();
    let number = |n: &str, values: Vec<f64>| Column::new(n, "m", Values::F64(values));
    let twice = Table::default()
        .with(number("x", vec![]))
        .with(number("x", vec![]));
    let error = twice.write_parquet(&path).unwrap_err().to_string();
    assert_eq!(error, format!("{name}: two columns are called `x`"));
    let unequal = Table::default()
        .with(number("x", vec![1.0]))
        .with(number("y", vec![]));
    let error = unequal.write_parquet(&path).unwrap_err().to_string();
    assert_eq!(
        error,
        format!("{name}: column `y` has 0 rows, expected 1 as in `x`")
    );
    let specs = vec![Spec::new("x", "m", Kind::F64)];
    let mut writer = ParquetWriter::create(&path, specs, &[]).unwrap();
    for (values, message) in [
        (vec![], "0 columns, expected 1"),
        (
            vec![Values::U64(vec![1])],
            "column `x` is U64, expected F64",
        ),
    ] {
        let error = writer.write(values).unwrap_err().to_string();
        assert_eq!(error, format!("{name}: {message}"));
    }
    drop(writer);
    assert!(
        place.names().is_empty(),
        "something was left: {:?}",
        place.names()
    );
}

#[test]
fn a_file_that_cannot_be_written() {
    let place = Place::new();
    let path = place.path("missing/t.parquet");
    let error = small().write_parquet(&path).unwrap_err().to_string();
    let start = format!("{}: the file cannot be written: ", path.display());
    assert!(error.starts_with(&start), "{error}");
}

#[test]
fn an_old_file_stays_until_the_new_one_is_whole() {
    let place = Place::new();
    let path = place.with("t.parquet", "old");
    let specs = vec![Spec::new("x", "m", Kind::F64)];
    let mut writer = ParquetWriter::create(&path, specs, &[]).unwrap();
    writer.write(vec![Values::F64(vec![1.0])]).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"old");
    drop(writer);
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(place.names(), ["t.parquet"]);
}
