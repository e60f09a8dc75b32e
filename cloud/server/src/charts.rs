//! Columns of tables, reduced to the least and the largest value of at most 2,000 bins.

use std::borrow::Cow;

use cloud_api::answers::{Chart, TableInfo};
use cloud_store::{Result, Store};
use mercury_common::formats::delimited::{Cell, Cells};
use mercury_common::formats::table_head;
use mercury_common::run_tables::{ALL, Column, ENERGIES, Role};

use crate::content::Content;

/// The most bins of a chart.
const BINS: usize = 2000;

/// The longest line that counts as one of a table, in bytes.
const LONGEST_LINE: usize = 1 << 16;

/// Tables that charts are made of, by the ends of their names.
pub(crate) fn is_table(name: &str) -> bool {
    let last = name.rsplit('/').next().unwrap_or(name);
    last.ends_with(".ene") || last.ends_with(".csv") || last.ends_with(".fields")
}

/// Splits a line of either kind: at commas where it has some, else at blanks.
fn fields(line: &str) -> Vec<Cow<'_, str>> {
    if line.contains(',') {
        Cells::new(line, b',').map(Cell::value).collect()
    } else {
        line.split_whitespace().map(Cow::Borrowed).collect()
    }
}

/// The declaration of a column of a file. Tables such as those of fields have none.
fn declared(file: &str, column: &str) -> Option<&'static Column> {
    let file = file.rsplit('/').next().unwrap_or(file);
    let mut tables = ALL.into_iter().chain([&ENERGIES]);
    let table = tables.find(|table| file.ends_with(&format!(".{}", table.file)));
    table.and_then(|table| table.column(column))
}

/// Whether a column of a file holds names or ids.
fn is_label(file: &str, column: &str) -> bool {
    declared(file, column).is_some_and(|column| column.role == Role::Label)
}

/// Unit of a column: that in the cell of the head, or that of its declaration.
fn unit(file: &str, cell: &str) -> String {
    let name = table_head::name(cell);
    let in_head = cell.trim().strip_prefix(name).unwrap_or_default();
    let in_head = in_head.trim().trim_start_matches('[').trim_end_matches(']');
    match declared(file, name) {
        Some(column) if in_head.is_empty() => column.unit.to_owned(),
        _ => in_head.to_owned(),
    }
}

/// Calls `each` with every line of a table, until it returns false.
fn lines(store: &dyn Store, content: &Content, mut each: impl FnMut(&str) -> bool) -> Result<()> {
    let mut rest: Vec<u8> = Vec::new();
    let mut at = 0;
    while at < content.bytes() {
        let piece = content.read(store, at..content.bytes())?;
        at += piece.len() as u64;
        rest.extend(piece);
        let mut begin = 0;
        while let Some(length) = rest[begin..].iter().position(|&byte| byte == b'\n') {
            if !each(&String::from_utf8_lossy(&rest[begin..begin + length])) {
                return Ok(());
            }
            begin += length + 1;
        }
        rest.drain(..begin);
        if rest.len() > LONGEST_LINE {
            return Ok(());
        }
    }
    if !rest.is_empty() {
        each(&String::from_utf8_lossy(&rest));
    }
    Ok(())
}

fn is_head(line: &str) -> bool {
    !line.starts_with('#')
        && fields(line)
            .first()
            .is_some_and(|word| word.parse::<f64>().is_err() && !word.is_empty())
}

/// Columns of a table, or `None` where it has no time.
pub(crate) fn describe(
    store: &dyn Store,
    content: &Content,
    file: &str,
) -> Result<Option<TableInfo>> {
    let mut head: Vec<(String, String)> = Vec::new();
    let mut names: Vec<String> = Vec::new();
    let mut rows = 0;
    lines(store, content, |line| {
        if head.is_empty() {
            if is_head(line) {
                head = (fields(line).into_iter())
                    .map(|cell| (table_head::name(&cell).to_owned(), unit(file, &cell)))
                    .collect();
            }
            return true;
        }
        // Names repeat from instant to instant: the first rows have them all.
        if let Some(name) = head.iter().position(|(column, _)| column == "name")
            && let Some(found) = fields(line).get(name)
            && !names.iter().any(|known| known == found)
        {
            names.push(found.to_string());
        }
        rows += 1;
        rows < 1000 && head.iter().any(|(column, _)| column == "name")
    })?;
    if head.first().is_none_or(|(first, _)| first != "time") {
        return Ok(None);
    }
    let (columns, units) = (head.into_iter().skip(1))
        .filter(|(column, _)| !is_label(file, column))
        .unzip();
    Ok(Some(TableInfo {
        file: file.to_owned(),
        columns,
        units,
        names,
    }))
}

/// Bins that merge in pairs when there are too many, so that the length of the table need not be known.
struct Bins {
    per_bin: u64,
    in_last: u64,
    time: Vec<f64>,
    min: Vec<Option<f64>>,
    max: Vec<Option<f64>>,
}

impl Bins {
    fn add(&mut self, time: f64, value: Option<f64>) {
        let lesser =
            |a: Option<f64>, b: Option<f64>| a.map_or(b, |a| Some(b.map_or(a, |b| a.min(b))));
        let larger =
            |a: Option<f64>, b: Option<f64>| a.map_or(b, |a| Some(b.map_or(a, |b| a.max(b))));
        if self.in_last < self.per_bin
            && let (Some(min), Some(max)) = (self.min.last_mut(), self.max.last_mut())
        {
            *min = lesser(*min, value);
            *max = larger(*max, value);
            self.in_last += 1;
            return;
        }
        if self.time.len() == BINS {
            for k in 0..BINS / 2 {
                self.time[k] = self.time[2 * k];
                self.min[k] = lesser(self.min[2 * k], self.min[2 * k + 1]);
                self.max[k] = larger(self.max[2 * k], self.max[2 * k + 1]);
            }
            self.time.truncate(BINS / 2);
            self.min.truncate(BINS / 2);
            self.max.truncate(BINS / 2);
            self.per_bin *= 2;
        }
        self.time.push(time);
        self.min.push(value);
        self.max.push(value);
        self.in_last = 1;
    }
}

/// A column of a table, of the rows called `name` where they have names.
pub(crate) fn chart(
    store: &dyn Store,
    content: &Content,
    file: &str,
    column: &str,
    name: Option<&str>,
) -> Result<Option<Chart>> {
    let mut places: Option<(usize, Option<usize>)> = None;
    let mut bins = Bins {
        per_bin: 1,
        in_last: 0,
        time: Vec::new(),
        min: Vec::new(),
        max: Vec::new(),
    };
    let mut rows = 0;
    lines(store, content, |line| {
        let fields = fields(line);
        let Some((value_at, name_at)) = places else {
            if !is_head(line) {
                return true;
            }
            let place =
                |wanted: &str| (fields.iter()).position(|cell| table_head::name(cell) == wanted);
            places = place(column).map(|at| (at, place("name")));
            return places.is_some() && place("time") == Some(0);
        };
        if let (Some(name), Some(at)) = (name, name_at)
            && fields.get(at).is_none_or(|field| field != name)
        {
            return true;
        }
        let number = |at: usize| fields.get(at).and_then(|field| field.parse::<f64>().ok());
        if let Some(time) = number(0) {
            bins.add(time, number(value_at).filter(|value| value.is_finite()));
            rows += 1;
        }
        true
    })?;
    if places.is_none() {
        return Ok(None);
    }
    let name = name.map(str::to_owned);
    let (file, column) = (file.to_owned(), column.to_owned());
    Ok(Some(Chart {
        file,
        column,
        name,
        rows,
        time: bins.time,
        min: bins.min,
        max: bins.max,
    }))
}

#[cfg(test)]
mod tests {
    use cloud_api::{Head, RunId, Segment, Stream};
    use cloud_store::FolderStore;

    use super::*;

    /// A table in two segments that part a line.
    fn table(name: &str, text: &str) -> (tempfile::TempDir, FolderStore, Content) {
        let folder = tempfile::tempdir().unwrap();
        let store = FolderStore::create(folder.path()).unwrap();
        let run = RunId::of([0; 16]);
        let mut head = Head::default();
        let half = text.len() / 2;
        let mut segments = Vec::new();
        for (from, to) in [(0, half), (half, text.len())] {
            let key = format!("data/{name}/{from}-{to}.1");
            store
                .put(&format!("runs/{run}/{key}"), &text.as_bytes()[from..to])
                .unwrap();
            segments.push(Segment {
                from: from as u64,
                to: to as u64,
                sha256: String::new(),
                key,
            });
        }
        head.streams.insert(name.to_owned(), Stream { segments });
        let content = Content::of(&run, &head, name).unwrap();
        (folder, store, content)
    }

    #[test]
    fn extremes_survive_the_reduction() {
        let mut text = String::from("time gravitEnergy\n");
        for k in 0..100_000 {
            let value = if k == 77_777 {
                5.0
            } else if k == 12_345 {
                -5.0
            } else {
                0.5
            };
            text += &format!("{} {value}\n", f64::from(k) * 0.1);
        }
        let (_folder, store, content) = table("a.ene", &text);
        // The head of this file has no units; its declaration has.
        let info = describe(&store, &content, "a.ene").unwrap().unwrap();
        assert_eq!(info.units, ["J"]);
        let chart = chart(&store, &content, "a.ene", "gravitEnergy", None)
            .unwrap()
            .unwrap();
        assert_eq!(chart.rows, 100_000);
        assert!(chart.time.len() <= BINS && chart.time.len() > BINS / 2 - 1);
        assert!(chart.time.windows(2).all(|pair| pair[0] < pair[1]));
        let max = chart.max.iter().flatten().fold(f64::MIN, |a, &b| a.max(b));
        let min = chart.min.iter().flatten().fold(f64::MAX, |a, &b| a.min(b));
        assert_eq!((min, max), (-5.0, 5.0));
    }

    #[test]
    fn rows_are_told_apart_by_name() {
        let text =
            "time [s],name,fx [N],fy [N]\n0,lid,1,2\n0,floor,3,4\n1,lid,5,nan\n1,floor,7,8\n";
        let (_folder, store, content) = table("a.walls.csv", text);
        let info = describe(&store, &content, "a.walls.csv").unwrap().unwrap();
        assert_eq!(
            (info.columns, info.names),
            (
                vec!["fx".into(), "fy".into()],
                vec!["lid".into(), "floor".into()]
            )
        );
        assert_eq!(info.units, ["N", "N"]);
        let lid = chart(&store, &content, "a.walls.csv", "fy", Some("lid"))
            .unwrap()
            .unwrap();
        assert_eq!((lid.time, lid.max), (vec![0.0, 1.0], vec![Some(2.0), None]));
        assert!(
            chart(&store, &content, "a.walls.csv", "none", None)
                .unwrap()
                .is_none()
        );
    }

    #[test]
    fn columns_of_names_are_no_charts_and_names_may_hold_commas() {
        let text = "time [s],at,name,direction,id,clump,material,diameter [m]\n\
            0.5,plane,\"in, left\",1,7,,glass,0.002\n";
        let (_folder, store, content) = table("a.left.csv", text);
        let info = describe(&store, &content, "a.left.csv").unwrap().unwrap();
        assert_eq!(info.columns, ["direction", "diameter"]);
        assert_eq!(info.names, ["in, left"]);
        let found = chart(&store, &content, "a.left.csv", "diameter", Some("in, left"));
        assert_eq!(found.unwrap().unwrap().max, [Some(0.002)]);
    }
}
