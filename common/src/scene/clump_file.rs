//! The clump file that `[clumps.NAME]` refers to, read like a scene: unknown keys, types and places.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use glam::DMat3;

use super::cursor::{Context, Fields, Files};
use super::error::{SceneError, SceneErrors};
use super::item::Item;
use super::source::{Source, SourceSpan};
use super::tree::{self, Node, Value};
use crate::formats::clump::{ClumpFile, Pebble, Remark};

/// Reads a clump file.
///
/// # Errors
/// All mistakes at once, each with its place: keys that are missing, unknown or of the wrong type, and what
/// [`ClumpFile::problems`] finds.
pub fn read_clump(path: impl AsRef<Path>) -> Result<ClumpFile, SceneErrors> {
    let path = path.as_ref();
    parse_clump(path, &super::read_text(path, "clump file")?)
}

/// Reads a clump file from its text; `path` names it in messages.
///
/// # Errors
/// As [`read_clump`].
pub fn parse_clump(path: &Path, text: &str) -> Result<ClumpFile, SceneErrors> {
    let files = Files::Unchecked;
    let source = Source::file(path.display().to_string(), text, &files);
    let document = tree::parse_document(&source, text)?;
    let context = Context {
        errors: RefCell::default(),
        directory: PathBuf::new(),
        files,
        materials: Vec::new(),
        clumps: Vec::new(),
        laws: None,
        named: RefCell::default(),
    };
    let whole = SourceSpan::new(&source, 0..0, "");
    let clump = read_document(&context, &document, &whole);
    let mut errors = context.errors.into_inner();
    errors.sort_by_key(|error| error.place.order());
    match clump {
        Some(clump) if errors.is_empty() => Ok(clump),
        _ if errors.is_empty() => Err(whole.error("this is not a clump file").into()),
        _ => Err(SceneErrors(errors)),
    }
}

fn read_document(context: &Context, document: &Node, whole: &SourceSpan) -> Option<ClumpFile> {
    let Value::Table(root) = &document.value else {
        return None;
    };
    let root = Fields::new(context, root, whole.clone());
    // Places of what was read, for the rules that follow.
    let places: RefCell<Vec<SourceSpan>> = RefCell::default();
    let keep = |item: Item<'_>| {
        places.borrow_mut().push(item.place.clone());
        item.number().map(|number| number.value)
    };
    let keep_vector = |item: Item<'_>| {
        places.borrow_mut().push(item.place.clone());
        item.vector().map(|vector| vector.value)
    };

    let name = root.need("name").and_then(|item| {
        places.borrow_mut().push(item.place.clone());
        item.name()
    });
    let density = root.need("density").and_then(keep);
    let mass = root.need("mass").and_then(keep);
    let volume = root.need("volume").and_then(keep);
    let centre_of_mass = match root.get("centre_of_mass") {
        Some(item) => keep_vector(item),
        None => Some(glam::DVec3::ZERO),
    };
    let principal_moments = root.need("principal_moments").and_then(keep_vector);
    let rotation = match root.get("rotation") {
        Some(item) => {
            places.borrow_mut().push(item.place.clone());
            matrix(&item)
        }
        None => Some(DMat3::IDENTITY),
    };
    let inertia_method = match root.get("inertia_method") {
        Some(item) => item.name().map(|name| name.value),
        None => Some("given".to_owned()),
    };
    let pebbles = root.need("pebbles").and_then(|item| {
        places.borrow_mut().push(item.place.clone());
        let read: Vec<Option<Pebble>> = item
            .list()?
            .iter()
            .map(|item| {
                let fields = item.table()?;
                let position = fields.need("position").and_then(keep_vector);
                let radius = fields.need("radius").and_then(keep);
                fields.finish();
                Some(Pebble {
                    position: position?,
                    radius: radius?,
                })
            })
            .collect();
        read.into_iter().collect::<Option<Vec<Pebble>>>()
    });
    let surface = match root.get("surface") {
        Some(item) => item.name().map(|name| Some(name.value)),
        None => Some(None),
    };
    let source = remarks(&root, "source");
    let checks = remarks(&root, "checks");
    root.finish();

    let clump = ClumpFile {
        name: name?.value,
        density: density?,
        mass: mass?,
        volume: volume?,
        centre_of_mass: centre_of_mass?,
        principal_moments: principal_moments?,
        rotation: rotation?,
        inertia_method: inertia_method?,
        pebbles: pebbles?,
        surface: surface?,
        source: source?,
        checks: checks?,
    };
    let places = places.into_inner();
    for problem in clump.problems() {
        let place = places
            .iter()
            .find(|place| place.key() == problem.key)
            .cloned()
            .unwrap_or_else(|| whole.with_key(problem.key));
        context.report(SceneError {
            place,
            message: problem.message,
            help: None,
        });
    }
    Some(clump)
}

/// Three rows of three numbers.
fn matrix(item: &Item<'_>) -> Option<DMat3> {
    let rows = item.list()?;
    if rows.len() != 3 {
        item.report(format!("expected 3 rows of 3 numbers, got {}", rows.len()));
        return None;
    }
    let rows: Vec<_> = rows.iter().map(Item::vector).collect();
    let mut matrix = DMat3::ZERO;
    for (index, row) in rows.into_iter().enumerate() {
        let row = row?.value;
        for column in 0..3 {
            matrix.col_mut(column)[index] = row[column];
        }
    }
    Some(matrix)
}

fn remarks(root: &Fields<'_>, key: &'static str) -> Option<Vec<(String, Remark)>> {
    let Some(item) = root.get(key) else {
        return Some(Vec::new());
    };
    table(&item)
}

fn table(item: &Item<'_>) -> Option<Vec<(String, Remark)>> {
    let fields = item.table()?;
    let read: Vec<_> = fields
        .entries()
        .map(|(key, item)| Some((key.value, remark(&item)?)))
        .collect();
    read.into_iter().collect()
}

fn remark(item: &Item<'_>) -> Option<Remark> {
    Some(match &item.node.value {
        Value::String(text) => Remark::Text(text.clone()),
        Value::Integer(value) => Remark::Whole(*value),
        Value::Float(_) => Remark::Number(item.number()?.value),
        Value::Boolean(value) => Remark::Flag(*value),
        Value::Datetime => Remark::Text(item.place.text().to_owned()),
        Value::LeftOut => return None,
        Value::Array(_) => {
            let read: Vec<_> = item.list()?.iter().map(remark).collect();
            Remark::List(read.into_iter().collect::<Option<_>>()?)
        }
        Value::Table(_) => Remark::Table(table(item)?),
    })
}
