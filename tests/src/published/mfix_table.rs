//! The files that MFiX's tests write.

use anyhow::{Context, Result, ensure};

/// One table of a file, with what stands above it.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Table {
    pub(super) scheme: String,
    /// N/m.
    pub(super) stiffness: f64,
    pub(super) restitution: f64,
    pub(super) rows: Vec<Vec<f64>>,
}

/// All tables of a file.
pub(super) fn read(text: &str) -> Result<Vec<Table>> {
    let mut tables: Vec<Table> = Vec::new();
    let mut open = Table::default();
    for line in text.lines() {
        if let Some((key, value)) = line.split_once('=') {
            let value = || {
                let value = value.trim();
                value
                    .parse::<f64>()
                    .with_context(|| format!("{value}: no number"))
            };
            match key.trim() {
                "KN" => open.stiffness = value()?,
                "DES_EN_INPUT" => open.restitution = value()?,
                _ => {}
            }
        } else if let Some((_, scheme)) = line.split_once("Scheme:") {
            if !open.rows.is_empty() {
                tables.push(std::mem::take(&mut open));
            }
            scheme.trim().clone_into(&mut open.scheme);
        } else {
            let fields: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
            match fields {
                Ok(row) if row.len() > 2 => open.rows.push(row),
                _ => {}
            }
        }
    }
    ensure!(!open.rows.is_empty(), "there is no table in the file");
    tables.push(open);
    Ok(tables)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_keep_what_stands_above_them() {
        let text = "\n  DEM01: A BALL\n\n   Time Stepping Scheme: EULER\n\n  KN =   0.1000E+05\n  KN_W = 1\n\
                    DES_EN_INPUT =   0.9000\n\n Time  Stage  Pos\n 0.0  1  0.5  0.5\n 0.1 1 -0.4 0.4\n\n\
                    Time Stepping Scheme: ADAMS_BASHFORTH\n KN = 2.\n DES_EN_INPUT = 1\n 3 4 5\n";
        let tables = read(text).unwrap();
        assert_eq!(tables.len(), 2);
        assert_eq!(tables[0].scheme, "EULER");
        assert_eq!((tables[0].stiffness, tables[0].restitution), (1e4, 0.9));
        assert_eq!(tables[0].rows[1], [0.1, 1.0, -0.4, 0.4]);
        assert_eq!(tables[1].rows, [[3.0, 4.0, 5.0]]);
        assert!(read("no numbers\n").is_err());
        assert!(read("KN = x\n 1 2 3\n").is_err());
    }
}
