//! Cases that the field publishes with numbers: the curves of Chung & Ooi (2011) and the tests of MFiX.
//!
//! The numbers are not part of the project: they lie in `shared/data` beside it.

mod chung_ooi;
mod mfix;
mod mfix_table;
mod pictures;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::cases::Case;

/// Where the numbers are.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    folder: PathBuf,
}

impl Published {
    /// The files beside the project; `None` where they are not installed.
    #[must_use]
    pub fn find() -> Option<Self> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
        let complete = folder.join("chung_ooi").is_dir() && folder.join("mfix").is_dir();
        complete.then_some(Self { folder })
    }

    fn text(&self, relative: &str) -> Result<String> {
        let path = self.folder.join(relative);
        std::fs::read_to_string(&path)
            .with_context(|| format!("{}: cannot be read", path.display()))
    }

    /// The points (x, y) of one series of a table `series,x,y`.
    fn curve(&self, relative: &str, series: &str) -> Result<Vec<(f64, f64)>> {
        let points = curve(&self.text(relative)?, series);
        points.with_context(|| format!("{relative}: no points of {series}"))
    }

    /// The points below a path of names in a JSON file.
    fn points(&self, relative: &str, names: &[&str]) -> Result<Vec<Vec<f64>>> {
        let root: serde_json::Value = serde_json::from_str(&self.text(relative)?)?;
        let mut value = &root;
        for name in names {
            value = &value[*name];
        }
        let rows = serde_json::from_value(value.clone());
        rows.with_context(|| format!("{relative}: no points of {}", names.join("/")))
    }

    /// All checks; those of MFiX need a minute.
    ///
    /// # Errors
    /// If a file is missing or is not what it should be.
    pub fn all(&self) -> Result<Vec<Case>> {
        let mut cases = self.quick()?;
        cases.extend(mfix::slow(self)?);
        Ok(cases)
    }

    /// The checks of a second each.
    ///
    /// # Errors
    /// If a file is missing or is not what it should be.
    pub fn quick(&self) -> Result<Vec<Case>> {
        let mut cases = chung_ooi::cases(self)?;
        cases.extend(mfix::quick(self)?);
        Ok(cases)
    }

    /// Draws the pictures of the page into a folder.
    ///
    /// # Errors
    /// If a file of numbers is missing or a picture cannot be written.
    pub fn draw(&self, folder: &Path) -> Result<()> {
        pictures::chung_ooi(self, folder)?;
        pictures::mfix(self, folder)
    }
}

fn curve(text: &str, series: &str) -> Option<Vec<(f64, f64)>> {
    let rows = text.lines().filter_map(|line| {
        let mut fields = line.split(',');
        (fields.next()? == series).then_some(())?;
        Some((fields.next()?.parse().ok()?, fields.next()?.parse().ok()?))
    });
    let rows: Vec<_> = rows.collect();
    (!rows.is_empty()).then_some(rows)
}

/// Kratos' measure of how far a curve is off: the sum of the differences over the sum of the values.
fn deviation(ours: impl Fn(f64) -> f64, theirs: &[(f64, f64)]) -> f64 {
    let off: f64 = theirs.iter().map(|&(x, y)| (ours(x) - y).abs()).sum();
    off / theirs.iter().map(|(_, y)| y.abs()).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_are_found_and_missing_ones_reported() {
        let text = "# about\nseries,x,y\nsteel,1,2\nfem,1,3\nsteel,2,-4e-1\n";
        assert_eq!(curve(text, "steel").unwrap(), [(1.0, 2.0), (2.0, -0.4)]);
        assert!(curve(text, "glass").is_none());
    }

    #[test]
    fn deviation_is_that_of_all_points_together() {
        let theirs = [(1.0, 1.0), (2.0, -3.0)];
        assert_eq!(deviation(|x| 2.0 * x - 1.0, &theirs), 6.0 / 4.0);
    }
}
