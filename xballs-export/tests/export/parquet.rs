//! Parquet and CSV of a table hold the same numbers, bit for bit.

use std::path::Path;
use std::process::Command;

use crate::run_folder::{DATA, folder_with_data, folder_with_run};
use mercury_tables::Table;

fn export(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_mercury-export"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    (output.status.code(), said)
}

fn bits(table: &Table, name: &str) -> Vec<u64> {
    let values = table.values::<f64>(name).unwrap();
    values.into_iter().map(f64::to_bits).collect()
}

#[test]
fn parquet_and_csv_hold_the_same_numbers() {
    let place = folder_with_run();
    let out = place.path().join("out");
    for (table, rows) in [("particles", 3), ("contacts", 2)] {
        for command in ["csv", "parquet"] {
            let arguments = [command, "run", "-o", "out", "--table", table];
            assert_eq!(export(place.path(), &arguments), (Some(0), String::new()));
        }
        let whole = Table::read(&out.join(format!("run.{table}.parquet"))).unwrap();
        assert_eq!(whole.rows(), 4 * rows);
        let steps = whole.values::<u64>("step").unwrap();
        for k in 0..4 {
            let here = k * rows..(k + 1) * rows;
            assert_eq!(steps[here.clone()], vec![50 * k as u64; rows]);
            let frame = Table::read(&out.join(format!("run.{table}.{k:04}.csv"))).unwrap();
            assert_eq!(frame.columns().len() + 1, whole.columns().len());
            for column in frame.columns() {
                let name = &column.name;
                if ["body", "j", "wall"].contains(&name.as_str()) {
                    let found = &whole.values::<Option<u32>>(name).unwrap()[here.clone()];
                    let expected = frame.values::<Option<u32>>(name).unwrap();
                    assert_eq!(*found, expected, "{name}");
                } else {
                    assert_eq!(
                        bits(&whole, name)[here.clone()],
                        bits(&frame, name),
                        "{name}"
                    );
                }
            }
        }
        let unit = |name: &str| whole.column(name).unwrap().unit.clone();
        assert_eq!((unit("time"), unit("step")), ("s".into(), "1".into()));
        let length = if table == "particles" { "x" } else { "overlap" };
        assert_eq!(unit(length), "m");
    }
}

/// The last frame of [`DATA`] has an `info` that is no whole number, and so no materials.
#[test]
fn frames_of_other_columns_are_refused_and_leave_nothing() {
    let place = folder_with_data(DATA);
    let message = "frame 2: other columns than in the frames before\n".to_owned();
    assert_eq!(
        export(place.path(), &["parquet", "old.data"]),
        (Some(2), message)
    );
    let left = std::fs::read_dir(place.path().join("parquet")).unwrap();
    assert_eq!(left.count(), 0);
    let (code, _) = export(place.path(), &["parquet", "old.data", "--frames", "..2"]);
    assert_eq!(code, Some(0));
}
