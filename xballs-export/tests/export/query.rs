//! SQL over the tables of a run, from the command line.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use mercury_common::frames::{FramesHeader, ParticleColumns, ParticleWriter};
use mercury_tables::Table;

use crate::run_folder::folder_with_run;

fn query(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mercury-export"))
        .current_dir(folder)
        .arg("query")
        .args(arguments)
        .output()
        .unwrap()
}

fn answer(folder: &Path, arguments: &[&str]) -> String {
    let output = query(folder, arguments);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), errors.as_str()), (Some(0), ""));
    String::from_utf8(output.stdout).unwrap()
}

fn refusal(folder: &Path, arguments: &[&str]) -> String {
    let output = query(folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

/// The run of [`folder_with_run`] and a table of walls.
fn folder() -> tempfile::TempDir {
    let place = folder_with_run();
    let walls = "time [s],name,fz [N]\n0.5,floor,-2\n1.0,floor,-4.5\n1.0,lid,\n";
    fs::write(place.path().join("run/run.walls.csv"), walls).unwrap();
    place
}

#[test]
fn frames_are_a_table_with_their_times_and_names_of_materials() {
    let place = folder();
    // Three frames at 0.5, 1 and 1.5 s, in which vy is the time; two spheres of glass at x = 1 and 2, one of steel at 3.
    let sql = "SELECT material, COUNT(*) AS n, AVG(vy) AS speed, SUM(x) AS x FROM particles \
               WHERE time > 0.3 GROUP BY material ORDER BY material";
    let expected = "material  n  speed  x\nglass     6  1      9\nsteel     3  1      9\n";
    assert_eq!(answer(place.path(), &["run", sql]), expected);
    let file = "run/run.particles.arrow";
    assert_eq!(answer(place.path(), &[file, sql]), expected);
    let sql = "SELECT time, step, frame, id, body FROM particles WHERE frame = 2 AND id > 3";
    let expected = "time  step  frame  id  body\n1     100   2      4\n1     100   2      7   2\n";
    assert_eq!(answer(place.path(), &["run", sql]), expected);
    let sql = "SELECT wall, SUM(fz) AS fz FROM contacts WHERE wall IS NOT NULL GROUP BY wall";
    assert_eq!(answer(place.path(), &["run", sql]), "wall   fz\nfloor  4\n");
}

#[test]
fn tables_of_text_have_names_without_units_and_join_frames() {
    let place = folder();
    let sql = "SELECT name, SUM(fz) AS fz, COUNT(fz) AS n FROM walls GROUP BY name ORDER BY name";
    let expected = "name   fz    n\nfloor  -6.5  2\nlid          0\n";
    assert_eq!(answer(place.path(), &["run", sql]), expected);
    // A sum of nothing is missing.
    let sql = "SELECT w.time, w.fz, COUNT(*) AS n FROM walls w JOIN particles p ON w.time = p.time \
               WHERE w.name = 'floor' GROUP BY w.time, w.fz ORDER BY w.time";
    let expected = "time  fz    n\n0.5   -2    3\n1     -4.5  3\n";
    assert_eq!(answer(place.path(), &["run", sql]), expected);
}

#[test]
fn answers_are_written_whole_and_replace_nothing_without_request() {
    let place = folder();
    let sql = "SELECT id, time, material FROM particles WHERE time = 1.5 ORDER BY id";
    for file in ["a.csv", "a.parquet", "a.arrow"] {
        assert_eq!(answer(place.path(), &["run", sql, "-o", file]), "");
        let again = refusal(place.path(), &["run", sql, "-o", file]);
        assert!(again.contains("is there already"), "{again}");
        answer(place.path(), &["run", sql, "-o", file, "--force"]);
    }
    let text = fs::read_to_string(place.path().join("a.csv")).unwrap();
    assert_eq!(
        text,
        "id,time,material\n0,1.5,glass\n4,1.5,glass\n7,1.5,steel\n"
    );
    let table = Table::read_parquet(&place.path().join("a.parquet")).unwrap();
    assert_eq!(table.values::<u32>("id").unwrap(), [0, 4, 7]);
    assert_eq!(table.values::<f64>("time").unwrap(), [1.5; 3]);
    let arrow = fs::read(place.path().join("a.arrow")).unwrap();
    assert!(arrow.starts_with(b"ARROW1") && arrow.ends_with(b"ARROW1"));
    let wrong = refusal(place.path(), &["run", sql, "-o", "a.txt"]);
    assert!(wrong.contains(".csv, .parquet or .arrow"), "{wrong}");
    assert!(!place.path().join("a.txt").exists());
}

#[test]
fn mistakes_name_what_there_is() {
    let place = folder();
    let refused = |sql: &str| refusal(place.path(), &["run", sql]);
    let column = refused("SELECT vq FROM particles");
    assert!(
        column.contains("vq") && column.contains("vx, vy, vz"),
        "{column}"
    );
    let table = refused("SELECT * FROM wall");
    assert!(table.contains("wall"), "{table}");
    assert!(table.contains("contacts, particles, walls"), "{table}");
    let syntax = refused("SELEC vx FROM particles");
    assert!(syntax.contains("help: the tables are contacts"), "{syntax}");
    fs::write(place.path().join("b.csv"), "a\n1\n").unwrap();
    let reader = refused("SELECT * FROM read_csv('b.csv')");
    assert!(reader.contains("tables of a run, not files"), "{reader}");
    for sql in [
        "",
        "SELECT 1; SELECT 2",
        "SELECT * FROM particles WHERE vx = 'a'",
        "DROP TABLE walls; SELECT",
    ] {
        refused(sql);
    }
    let data = refusal(place.path(), &["b.csv", "SELECT 1"]);
    assert!(data.contains("no native frames"), "{data}");
}

#[test]
fn runs_without_frames_and_cut_ones_are_answered() {
    let place = folder();
    let path = place.path().join("run/run.particles.arrow");
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() - 40]).unwrap();
    let sql = "SELECT COUNT(*) AS n, MAX(time) AS last FROM particles";
    let output = query(place.path(), &["run", sql]);
    assert_eq!(output.status.code(), Some(0));
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(said, "n  last\n9  1\n");
    let warning = String::from_utf8(output.stderr).unwrap();
    assert!(warning.contains("behind 3 whole frames"), "{warning}");

    let header = FramesHeader::default();
    ParticleWriter::create(&path, &header, &ParticleColumns::default()).unwrap();
    let sql = "SELECT COUNT(*) AS n FROM particles";
    assert_eq!(answer(place.path(), &["run", sql]), "n\n0\n");
    let sql = "SELECT id, x FROM particles WHERE time > 1";
    assert_eq!(answer(place.path(), &["run", sql]), "id  x\n");
}

#[test]
fn a_study_is_a_table() {
    let place = tempfile::tempdir().unwrap();
    let text = "run,friction,angle [deg]\na,0.1,20\nb,0.3,25.5\nc,0.5,\n";
    fs::write(place.path().join("study.csv"), text).unwrap();
    let sql = "SELECT run, angle FROM study WHERE friction > 0.2 ORDER BY run";
    assert_eq!(
        answer(place.path(), &[".", sql]),
        "run  angle\nb    25.5\nc\n"
    );
}
