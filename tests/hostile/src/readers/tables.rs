//! Tables of named columns: delimited text and Parquet.

use std::fs;

use mercury_tables::{Column, Table, Values};

use super::{KB, MB, Reader};
use crate::checks::said;
use crate::mutate::Make::{Binary, Text};
use crate::place::{Place, file};

pub(super) const PARQUET: &str = "the file; what its pages claim to hold, of which the reader takes 64 MB or a thousand times the file, whichever is \
more, compressed and as values side by side";

pub(super) const READERS: &[Reader] = &[
    Reader::new("csv-table", Text(&["x", "id", "name", "\"", "\"\"", "[m]", "#", "true"]), |_| {
        vec![
            b"x [m],id,name,fixed\n0.5,1,a,true\n,2,\"b, c\",false\n".to_vec(),
            b"# none\nx;y\n1;2\n3;4\n".to_vec(),
        ]
    }, |bytes, place| read(bytes, place, "a.csv"))
    .bound(512 * KB, 160, "a cell of a text of 24 bytes and its own allocation from 2 bytes (`0,`), three times while lists grow; names twice"),
    Reader::new("parquet", Binary, parquet_samples, |bytes, place| read(bytes, place, "a.parquet")).bound(130 * MB, 4000, PARQUET),
];

fn parquet_samples(place: &Place) -> Vec<Vec<u8>> {
    let path = place.path("sample.parquet");
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
        .write_parquet(&path)
        .expect("a table");
    vec![
        fs::read(&path).expect("written above"),
        file("tables/tests/files/snappy.parquet"),
        file("tables/tests/files/gzip.parquet"),
    ]
}

fn read(bytes: &[u8], place: &Place, name: &str) {
    let Some(table) = said(Table::read(&place.write(name, bytes))) else {
        return;
    };
    let names: Vec<String> = table
        .columns()
        .iter()
        .map(|column| column.name.clone())
        .collect();
    for name in names.iter().take(5) {
        said(table.values::<f64>(name));
        said(table.values::<Option<u32>>(name));
        said(table.values::<i64>(name));
        said(table.values::<bool>(name));
        said(table.values::<String>(name));
    }
    said(table.values::<u8>("no such column"));
}
