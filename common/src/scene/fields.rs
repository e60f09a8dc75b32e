//! `[[fields]]`: fields of the continuum that are computed while the run goes on.

use std::collections::BTreeMap;
use std::path::PathBuf;

use glam::DVec3;

use super::MaterialIndex;
use super::item::Item;
use super::settings::flag;
use super::source::{Located, Place};

/// An entry of `[[fields]]`. Words that coarse-graining defines are checked where the fields are planned.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldTable {
    /// Where the entry stands.
    pub place: Place,
    /// Unique among field tables: part of the file's name.
    pub name: Located<String>,
    /// Names of fields; none: the standard ones.
    pub fields: Vec<Located<String>>,
    /// Resolved coordinates; none: all that the domain has.
    pub coordinates: Option<Located<String>>,
    /// Cells along each of them.
    pub grid: Option<Located<Vec<u64>>>,
    /// Sizes of cells, m (rad); one for all, or one for each coordinate.
    pub spacing: Option<Located<Vec<f64>>>,
    /// Or a file of points.
    pub points: Option<Located<PathBuf>>,
    /// Limits of coordinates, m (rad).
    pub limits: BTreeMap<&'static str, Located<[f64; 2]>>,
    /// Name of the kernel.
    pub kernel: &'static str,
    /// Its width; none: one mean diameter.
    pub width: Option<Located<FieldWidth>>,
    /// Where a Gaussian is cut, in widths.
    pub cutoff: Option<Located<f64>>,
    /// Error of line integrals of a Gaussian, of their largest value.
    pub tolerance: Option<Located<f64>>,
    /// Faces of the domain that mirror particles and contacts.
    pub mirror: Vec<Located<String>>,
    /// Direction of the axis of cylindrical coordinates: 0, 1 or 2.
    pub axis: Option<usize>,
    /// A point on it, m; none: the middle of the domain.
    pub through: Option<Located<DVec3>>,
    /// Whether each material has fields of its own, too; default false.
    pub by_material: bool,
    /// Materials with fields of their own.
    pub materials: Vec<Located<MaterialIndex>>,
    /// Whether displacements are those since the first look, instead of the look before; default false.
    pub since_first: bool,
    /// Between two looks, s; none: `output.interval`.
    pub interval: Option<Located<f64>>,
    /// No look before, s; default 0.
    pub from: Option<Located<f64>>,
    /// No look after, s; default never.
    pub until: Option<Located<f64>>,
    /// One mean over all looks, with standard errors; default false.
    pub average: bool,
    /// Standard deviation and distance of means over looks near in time, s.
    pub smooth: Option<Located<[f64; 2]>>,
}

impl FieldTable {
    /// Where a key of the entry stands; the place of its name for one that is not there.
    #[must_use]
    pub fn place_of(&self, key: &str) -> &Place {
        let found = match key {
            "fields" => self.fields.first().map(|name| &name.place),
            "coordinates" => self.coordinates.as_ref().map(|word| &word.place),
            "grid" => self.grid.as_ref().map(|cells| &cells.place),
            "spacing" => self.spacing.as_ref().map(|sizes| &sizes.place),
            "points" => self.points.as_ref().map(|file| &file.place),
            "limits" => self.limits.values().next().map(|range| &range.place),
            "width" => self.width.as_ref().map(|width| &width.place),
            "cutoff" => self.cutoff.as_ref().map(|widths| &widths.place),
            "tolerance" => self.tolerance.as_ref().map(|error| &error.place),
            "materials" => self.materials.first().map(|name| &name.place),
            "smooth" => self.smooth.as_ref().map(|both| &both.place),
            "mirror" => self.mirror.first().map(|face| &face.place),
            "through" => self.through.as_ref().map(|point| &point.place),
            _ => None,
        };
        found.unwrap_or(&self.name.place)
    }
}

/// The width of a kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FieldWidth {
    /// In m.
    Metres(f64),
    /// In mean diameters of the start.
    Diameters(f64),
}

/// Names of coordinates that can have limits.
const COORDINATES: [&str; 5] = ["x", "y", "z", "r", "phi"];

/// Reads an entry of `[[fields]]`.
pub(super) fn read(item: &Item<'_>) -> Option<FieldTable> {
    let table = item.table()?;
    let name = table.need("name").and_then(|item| file_word(&item));
    let names = |key| match table.get(key) {
        Some(item) => all(&item.list()?, |item| item.text()),
        None => Some(Vec::new()),
    };
    let fields = names("fields");
    let coordinates = table.get("coordinates").map(|item| item.text());
    let numbers = |key| table.get(key).map(|item| (item.list(), item.place));
    let grid = numbers("grid").map(|(items, place)| {
        let value = all(&items?, |item| item.whole(1).map(|n| n.value))?;
        Some(Located { value, place })
    });
    let spacing = numbers("spacing").map(|(items, place)| {
        let value = all(&items?, |item| item.positive().map(|x| x.value))?;
        Some(Located { value, place })
    });
    let points = table.get("points").map(|item| item.file());
    table.exactly_one(&["grid", "spacing", "points"], false);
    let limits = match table.get("limits") {
        Some(item) => item.table().and_then(|limits| {
            let given = COORDINATES.map(|name| (name, limits.get(name)));
            limits.finish();
            let given = given
                .into_iter()
                .filter_map(|(name, item)| Some((name, item?)));
            given
                .map(|(name, item)| Some((name, item.range()?)))
                .collect()
        }),
        None => Some(BTreeMap::new()),
    };
    let kernels = ["gaussian", "lucy", "linear", "heaviside"].map(|word| (word, word));
    let kernel = match table.get("kernel") {
        Some(item) => item.word("kernel", &kernels),
        None => Some("gaussian"),
    };
    let width = table.get("width").map(|item| width(&item));
    let cutoff = table.get("cutoff").map(|item| item.between(1.0, 38.0));
    let tolerance = table.get("tolerance").map(|item| item.between(1e-16, 0.1));
    let mirror = names("mirror");
    let axes = [("x", 0), ("y", 1), ("z", 2)];
    let axis = table.get("axis").map(|item| item.word("axis", &axes));
    let through = table.get("through").map(|item| item.vector());
    let by_material = flag(&table, "by_material", false);
    let materials = match table.get("materials") {
        Some(item) => item
            .list()
            .and_then(|items| all(&items, |item| item.material())),
        None => Some(Vec::new()),
    };
    let sinces = [("first", true), ("previous", false)];
    let since_first = match table.get("since") {
        Some(item) => item.word("look", &sinces),
        None => Some(false),
    };
    let interval = table.get("interval").map(|item| item.positive());
    let from = table.get("from").map(|item| item.non_negative());
    let until = table.get("until").map(|item| item.non_negative());
    let average = flag(&table, "average", false);
    let smooth = table.get("smooth").map(|item| smooth(&item));
    if average && let Some(item) = table.get("smooth") {
        item.report("cannot be used together with average = true");
    }
    table.finish();
    // If it is there but wrong, the mistake has already been reported.
    Some(FieldTable {
        place: item.place.clone(),
        name: name?,
        fields: fields?,
        coordinates: given(coordinates)?,
        grid: given(grid)?,
        spacing: given(spacing)?,
        points: given(points)?,
        limits: limits?,
        kernel: kernel?,
        width: given(width)?,
        cutoff: given(cutoff)?,
        tolerance: given(tolerance)?,
        mirror: mirror?,
        axis: given(axis)?,
        through: given(through)?,
        by_material,
        materials: materials?,
        since_first: since_first?,
        interval: given(interval)?,
        from: given(from)?,
        until: given(until)?,
        average,
        smooth: given(smooth)?,
    })
}

/// A value that may be left out, but not be wrong.
fn given<T>(read: Option<Option<T>>) -> Option<Option<T>> {
    match read {
        None => Some(None),
        Some(value) => value.map(Some),
    }
}

/// All items of a list, each read.
fn all<T>(items: &[Item<'_>], read: impl Fn(&Item<'_>) -> Option<T>) -> Option<Vec<T>> {
    let read: Vec<Option<T>> = items.iter().map(read).collect();
    read.into_iter().collect()
}

/// A name that may stand in that of a file.
fn file_word(item: &Item<'_>) -> Option<Located<String>> {
    let name = item.name()?;
    let may = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
    if name.chars().all(may) {
        return Some(name);
    }
    item.report("is part of a file's name: only letters, digits, - and _");
    None
}

/// Two times, s.
fn smooth(item: &Item<'_>) -> Option<Located<[f64; 2]>> {
    let both = item.numbers::<2>()?;
    if both.iter().any(|time| *time <= 0.0) {
        item.report("must be [width, step], two times above 0 s");
        return None;
    }
    Some(both)
}

/// A length in m, or a text as "1.5d".
fn width(item: &Item<'_>) -> Option<Located<FieldWidth>> {
    if !item.is_text() {
        return Some(item.positive()?.map(FieldWidth::Metres));
    }
    let text = item.text()?;
    let times = text
        .strip_suffix('d')
        .and_then(|times| times.trim().parse().ok());
    match times.filter(|times: &f64| *times > 0.0 && times.is_finite()) {
        Some(times) => Some(text.map(|_| FieldWidth::Diameters(times))),
        None => {
            let got = &text.value;
            item.report(format!(
                "expected a length in m, or mean diameters as in \"1.5d\", got {got:?}"
            ));
            None
        }
    }
}
