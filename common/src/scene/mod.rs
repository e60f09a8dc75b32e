//! The scene file: one simulation as its user typed it.
//!
//! [`read_scene`] turns `scene.toml` (and the `--set KEY=VALUE` of the command line) into a [`Scene`]:
//! every key checked by itself, every default filled in, nothing computed. The meaning of the keys together
//! (mixed parameters, time step, what is skipped) is the plan's business, in the solver; its errors
//! look like the reader's, because values keep their place ([`Located`], [`SourceSpan::error`]).
//!
//! How it works: the text becomes a tree in which every node has its span (`tree.rs`), overrides change
//! the tree (`overrides.rs`), and a cursor (`cursor.rs`) walks it, collecting all mistakes. One file per
//! section of the format holds the types of the section and their reader; `docs/formats/scene.md` is
//! the users' page.

mod bonds;
mod boundaries;
mod clump_file;
mod contacts;
mod cursor;
mod error;
mod examples;
mod fields;
mod from_item;
mod guard;
mod insertions;
mod item;
mod json;
mod key_path;
pub mod keys;
mod law_reader;
mod laws;
mod liquid;
mod materials;
mod membranes;
mod mend;
mod motion;
mod output;
mod overrides;
mod particles;
mod properties;
mod psd;
mod quantities;
mod region;
mod results;
mod settings;
mod shapes;
mod source;
mod spelling;
mod sprays;
mod statement;
mod tree;
mod walls;

use std::cell::RefCell;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

pub use crate::run_tables::Switches;
pub use bonds::{BondLaw, BondPoisson, BondTime, Bonds};
pub use boundaries::{Flux, FluxPart, NamedRegion};
pub use clump_file::{parse_clump, read_clump};
pub use contacts::ContactOverride;
pub use cursor::Files;
pub use error::{SceneError, SceneErrors};
pub use fields::{FieldTable, FieldWidth};
pub use guard::{Guard, GuardPolicy};
pub use insertions::{Body, Component, Insertion, Method, Quantity, Rate, Target, Total};
pub use json::is_json;
pub use laws::{
    Given, Key, KeyDefault, Law, LawKeys, LawOverride, LawPart, LawValues, Mixing, Range,
};
pub use liquid::{BridgesForm, LianSevilleVolume, LiquidNeighbours, LiquidSettings, Lubrication};
pub use materials::Material;
pub use membranes::{
    Bending, BendingStiffness, Hold, HoldMotion, Membrane, MembraneElasticity, MembranePressure,
    MembraneShape, Pick,
};
pub use mend::Mended;
pub use motion::{Load, Motion, MotionKind, ServoTarget};
pub use output::{ClumpsAs, Output};
pub use particles::{
    Clump, ClumpPlace, Lattice, Orientation, ParticleSource, ParticleValues, Particles, Prescribed,
    Start,
};
pub use psd::{MixturePart, Psd, SizeLaw, Weighting, parse_psd, read_psd, read_psd_with};
pub use quantities::SetValue;
pub use region::Region;
pub use results::{ResultRequest, Until};
pub use settings::{
    ClumpMass, Conventions, CoulombLimits, Dimensions, Domain, Face, RollingLever, SlidingNormal,
    TangentialHistory, Time, TimeStep,
};
pub use shapes::{MeshSide, MeshSource, Shape, Side, Turn};
pub use source::{Located, Source, SourceSpan};
pub use spelling::{listed, nearest};
pub use sprays::{AtWalls, Nozzle, Spray, SprayDrag, SprayFlow, SprayPattern, SpraySource};
pub use statement::{NamedFile, Statement, differences};
pub use tree::help_with_backslashes;
pub use walls::{Oka, Wall, Wear, WearBasis, WearLaw};

use bonds::BONDS;
use boundaries::{FLUX, NAMED_REGION};
use contacts::CONTACTS;
use cursor::{Context, Fields};
use fields::FIELD;
use guard::GUARD;
use insertions::INSERTION;
use item::Item;
use keys::{Absent, Kind, SceneKey, TableKeys, key, vector};
use liquid::LIQUID;
use materials::MATERIAL;
use membranes::MEMBRANE;
use output::{OUTPUT, Trackable};
use particles::{CLUMP, PARTICLES};
use settings::{CONTACT, DOMAIN, TIME};
use sprays::SPRAY;
use tree::{Node, Value};
use walls::WALL;

use crate::readable;

/// Name of a scene from standard input in messages.
pub const STANDARD_INPUT: &str = "<stdin>";

/// Bytes of a scene, law or clump: more than any has, and what a device without an end is cut at.
const LONGEST_TEXT: u64 = 256_000_000;

/// Beginning of the names of a run's files: the name of the scene's file without its ending, `scene` for [`STANDARD_INPUT`].
#[must_use]
pub fn stem(path: &Path) -> String {
    if path == Path::new(STANDARD_INPUT) {
        return "scene".to_owned();
    }
    let stem = path.file_stem().unwrap_or("run".as_ref());
    stem.to_string_lossy().into_owned()
}

/// Row of a material in [`Scene::materials`]; it is also its number in `.data` and `.fstat`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MaterialIndex(pub usize);

/// Row of a clump template in [`Scene::clumps`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ClumpIndex(pub usize);

/// One simulation as typed: every list in the order of the file, SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The file, as the user named it.
    pub path: PathBuf,
    /// The whole file, for errors that belong to no key.
    pub place: SourceSpan,
    /// All that is stated, to be compared with another scene.
    pub statement: Statement,
    /// The values of the command line in SI.
    pub set: Vec<SetValue>,
    /// `title`; default: the file's name without its ending.
    pub title: String,
    /// `seed`; default 0.
    pub seed: u64,
    /// `gravity`, m/s2; default 0.
    pub gravity: Located<DVec3>,
    /// `[time]`
    pub time: Time,
    /// `[domain]`
    pub domain: Domain,
    /// `[contact]`
    pub contact: Conventions,
    /// `[guard]`
    pub guard: Guard,
    /// `[liquid]`
    pub liquid: LiquidSettings,
    /// `[materials.NAME]`
    pub materials: Vec<Material>,
    /// `[[contacts]]`
    pub contacts: Vec<ContactOverride>,
    /// `[[walls]]`
    pub walls: Vec<Wall>,
    /// `[clumps.NAME]`
    pub clumps: Vec<Clump>,
    /// `[[particles]]`
    pub particles: Vec<Particles>,
    /// `[[insertions]]`
    pub insertions: Vec<Insertion>,
    /// `[[regions]]`
    pub regions: Vec<NamedRegion>,
    /// `[[deletions]]`
    pub deletions: Vec<NamedRegion>,
    /// `[[fluxes]]`
    pub fluxes: Vec<Flux>,
    /// `[[membranes]]`
    pub membranes: Vec<Membrane>,
    /// `[[bonds]]`
    pub bonds: Vec<Bonds>,
    /// `[[sprays]]`
    pub sprays: Vec<Spray>,
    /// `[[fields]]`
    pub fields: Vec<FieldTable>,
    /// `[results]`
    pub results: Vec<ResultRequest>,
    /// `[output]`
    pub output: Output,
}

impl Scene {
    /// The folder that relative file names start from.
    #[must_use]
    pub fn directory(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }
}

/// Reads a scene file with the `KEY=VALUE` of the command line put on top, in their order; for programs without
/// contact laws: the tables of laws are taken as they stand.
///
/// # Errors
/// All mistakes of the file and the command line at once; of syntax errors one per line.
pub fn read_scene(path: &Path, overrides: &[String]) -> Result<Scene, SceneErrors> {
    let text = read_text(path, "scene")?;
    parse_scene(path, &text, overrides, Files::MustExist)
}

/// Reads a scene file as [`read_scene`] does, and its laws by their tables of keys.
///
/// # Errors
/// As [`read_scene`]; what is wrong with the laws, too.
pub fn read_scene_with(
    laws: &[&'static LawKeys],
    path: &Path,
    overrides: &[String],
) -> Result<Scene, SceneErrors> {
    let text = read_text(path, "scene")?;
    parse_scene_with(laws, path, &text, overrides, Files::MustExist)
}

/// The text of a scene's file.
///
/// # Errors
/// If it cannot be read, or is no UTF-8.
pub fn read_scene_text(path: &Path) -> Result<String, SceneErrors> {
    read_text(path, "scene")
}

/// The text of a scene that comes from standard input, called [`STANDARD_INPUT`] in messages.
///
/// # Errors
/// If it cannot be read, or is no UTF-8.
pub fn read_scene_from(input: impl Read) -> Result<String, SceneErrors> {
    text_from(Path::new(STANDARD_INPUT), input, "scene")
}

/// The text of a file; `what` names its kind in messages.
fn read_text(path: &Path, what: &str) -> Result<String, SceneErrors> {
    match std::fs::File::open(path) {
        Ok(file) => text_from(path, file, what),
        Err(error) => Err(unreadable(path, what, &error).into()),
    }
}

fn unreadable(path: &Path, what: &str, error: &std::io::Error) -> SceneError {
    let name = path.display().to_string();
    SceneError {
        place: SourceSpan::new(&Source::file(name, "", &Files::MustExist), 0..0, ""),
        message: format!("the {what} cannot be read: {error}"),
        help: (error.kind() == ErrorKind::NotFound)
            .then(|| near_file(path))
            .flatten()
            .map(|near| format!("did you mean `{}`?", near.display())),
    }
}

/// A text up to [`LONGEST_TEXT`].
fn text_from(path: &Path, input: impl Read, what: &str) -> Result<String, SceneErrors> {
    let mut bytes = Vec::new();
    let read = input.take(LONGEST_TEXT + 1).read_to_end(&mut bytes);
    read.map_err(|error| unreadable(path, what, &error))?;
    let name = path.display().to_string();
    if bytes.len() as u64 > LONGEST_TEXT {
        let place = SourceSpan::new(&Source::file(name, "", &Files::MustExist), 0..0, "");
        let message = format!(
            "this is no {what}: it is longer than {}",
            readable::bytes(LONGEST_TEXT as f64)
        );
        return Err(place.error(message).into());
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
        let source = Source::file(name, text, &Files::MustExist);
        SourceSpan::new(&source, valid..valid + 1, "")
            .error("this is not UTF-8 text")
            .with_help("save the file as UTF-8")
            .into()
    })
}

/// A file in the same folder whose name is nearly that of one that is not there.
fn near_file(path: &Path) -> Option<PathBuf> {
    let wanted = path.file_name()?.to_string_lossy().into_owned();
    let folder = match path.parent()? {
        empty if empty == Path::new("") => Path::new("."),
        folder => folder,
    };
    let files = std::fs::read_dir(folder).ok()?.flatten();
    let mut names: Vec<String> = files
        .filter(|entry| entry.path().is_file())
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    // Whatever the order of the folder, the same is found.
    names.sort();
    // A scene without its ending is no slip of one letter.
    let is_whole =
        |name: &&String| **name == format!("{wanted}.toml") || **name == format!("{wanted}.json");
    let whole = names.iter().find(is_whole);
    let near = whole.map(String::as_str);
    let near = near.or_else(|| nearest(&wanted, names.iter().map(String::as_str)))?;
    Some(path.with_file_name(near))
}

/// Reads a scene from its text. `path` names it in messages and gives the folder of its files.
///
/// # Errors
/// As [`read_scene`].
pub fn parse_scene(
    path: &Path,
    text: &str,
    overrides: &[String],
    files: Files,
) -> Result<Scene, SceneErrors> {
    parse(None, path, text, overrides, files)
}

/// Reads a scene from its text as [`parse_scene`] does, and its laws by their tables of keys.
///
/// # Errors
/// As [`read_scene_with`].
pub fn parse_scene_with(
    laws: &[&'static LawKeys],
    path: &Path,
    text: &str,
    overrides: &[String],
    files: Files,
) -> Result<Scene, SceneErrors> {
    parse(Some(laws.to_vec()), path, text, overrides, files)
}

/// A scene with mistakes, put right in some way so that its other keys can be checked further. It is never run. `scale`: a factor
/// for the numbers that are put in. `None`: its mistakes cannot be put right one by one.
#[must_use]
pub fn mend_scene_with(
    laws: &[&'static LawKeys],
    path: &Path,
    text: &str,
    overrides: &[String],
    files: Files,
    scale: f64,
) -> Option<Mended> {
    let laws = Some(laws.to_vec());
    let source = Source::file(path.display().to_string(), text, &files);
    let (draft, wrong) = Draft::new(laws, path, &source, text, overrides, files).ok()?;
    wrong.is_empty().then(|| mend::mend(&draft, scale))?
}

/// A scene as text in JSON, with the `KEY=VALUE` of `overrides` put on top. Keys are not checked.
///
/// ```
/// use std::path::Path;
/// use mercury_common::scene::scene_as_json;
///
/// let text = "title = \"a\"\n[time]\nend = 1.0\n";
/// let json = scene_as_json(Path::new("a.toml"), text, &["time.end=2".to_owned()])?;
/// assert_eq!(json, r#"{"title": "a", "time": {"end": 2}}"#);
/// # Ok::<(), mercury_common::scene::SceneErrors>(())
/// ```
///
/// # Errors
/// Mistakes of syntax, and of `overrides`.
pub fn scene_as_json(path: &Path, text: &str, overrides: &[String]) -> Result<String, SceneErrors> {
    let files = Files::MustExist;
    let source = Source::file(path.display().to_string(), text, &files);
    let (draft, wrong) = Draft::new(None, path, &source, text, overrides, files)?;
    if !wrong.is_empty() {
        return Err(SceneErrors(wrong));
    }
    let mut json = String::new();
    json::write_document(&draft.document, &mut json);
    Ok(json)
}

fn parse(
    laws: Option<Vec<&'static LawKeys>>,
    path: &Path,
    text: &str,
    overrides: &[String],
    files: Files,
) -> Result<Scene, SceneErrors> {
    let source = Source::file(path.display().to_string(), text, &files);
    let (draft, wrong) = Draft::new(laws, path, &source, text, overrides, files)?;
    draft
        .read(draft.document.clone(), wrong)
        .map_err(SceneErrors)
}

/// A document with the values of the command line, and what is needed to read it.
struct Draft<'a> {
    laws: Option<Vec<&'static LawKeys>>,
    path: &'a Path,
    place: SourceSpan,
    document: Node,
    /// Values that the command line sets, with the path of each.
    given: Vec<(&'a str, String)>,
    files: Files,
}

impl<'a> Draft<'a> {
    /// The document, and what is wrong with the command line.
    fn new(
        laws: Option<Vec<&'static LawKeys>>,
        path: &'a Path,
        source: &Arc<Source>,
        text: &str,
        overrides: &'a [String],
        files: Files,
    ) -> Result<(Self, Vec<SceneError>), SceneErrors> {
        let mut document = tree::parse_document(source, text)?;
        let place = SourceSpan::new(source, 0..0, "");
        if is_clump_file(&document) {
            let error = place.error("this is a clump file, not a scene");
            return Err(error
                .with_help("a scene names it in [clumps.NAME] with file and material, and puts bodies of it with [[particles]] clump = \"NAME\"")
                .into());
        }
        let (mut wrong, mut given) = (Vec::new(), Vec::new());
        for argument in overrides {
            match overrides::apply(&mut document, argument, &files) {
                Ok(path) => given.push((argument.as_str(), path)),
                Err(error) => wrong.push(error),
            }
        }
        let draft = Self {
            laws,
            path,
            place,
            document,
            given,
            files,
        };
        Ok((draft, wrong))
    }

    /// Reads a document; `wrong`: what is known to be wrong.
    fn read(&self, mut document: Node, wrong: Vec<SceneError>) -> Result<Scene, Vec<SceneError>> {
        let laws = self.laws.as_deref();
        let mut wrong_units = Vec::new();
        let set = quantities::settle(&mut document, &SCENE, laws, &self.given, &mut wrong_units);
        let context = Context {
            errors: RefCell::new(wrong),
            directory: self.path.parent().unwrap_or(Path::new("")).to_owned(),
            files: self.files.clone(),
            materials: keys_below(&document, "materials"),
            clumps: keys_below(&document, "clumps"),
            laws: self.laws.clone(),
            named: RefCell::new(Vec::new()),
        };
        let mut scene = read_document(&context, &document, self.path, &self.place);
        if let Some(scene) = &mut scene {
            scene.statement = Statement::new(&document, context.named.take());
            scene.set = set;
        }
        let mut errors = context.errors.into_inner();
        quantities::with_units(&mut errors, wrong_units);
        errors.sort_by_key(|error| error.place.order());
        match scene {
            Some(scene) if errors.is_empty() => Ok(scene),
            _ if errors.is_empty() => Err(vec![self.place.error("this is not a scene")]),
            _ => Err(errors),
        }
    }
}

/// Whether the document describes a rigid body, and has nothing that only a scene has.
fn is_clump_file(document: &Node) -> bool {
    let Value::Table(root) = &document.value else {
        return false;
    };
    let has = |key: &&str| root.get(key).is_some();
    ["pebbles", "principal_moments"].iter().all(has)
        && !["time", "domain", "materials"].iter().any(has)
}

/// The names of the tables below a table of the document.
fn keys_below(document: &Node, key: &str) -> Vec<String> {
    let Value::Table(root) = &document.value else {
        return Vec::new();
    };
    match root.get(key).map(|entry| &entry.node.value) {
        Some(Value::Table(table)) => table.entries.iter().map(|e| e.key.clone()).collect(),
        _ => Vec::new(),
    }
}

/// A list of tables.
const fn tables(
    name: &'static str,
    item: &'static Kind,
    example: &'static str,
    text: &'static str,
) -> SceneKey {
    key(name, Kind::List("", item), example, text).absent(Absent::EmptyList)
}

/// The keys of a scene.
#[rustfmt::skip]
pub static SCENE: TableKeys = TableKeys::new(&[&[
    key("title", Kind::Line, "\"A box of grains\"", "one line, without control characters").or_open("the file's name"),
    key("seed", Kind::Whole(0, u64::MAX), "1", "every random choice follows from it, by name of what draws").or(0.0),
    key("gravity", vector("m/s2"), "[0, 0, -9.81]", "acceleration of all free bodies").absent(Absent::Zero),
    key("time", Kind::Table(&TIME), "{ end = 1.0 }   # s", "duration and time step"),
    key("domain", Kind::Table(&DOMAIN), "{ min = [0, 0, 0], max = [0.1, 0.1, 0.2] }   # m", "the space"),
    key("contact", Kind::Table(&CONTACT), "{ wall_curvature = true }", "conventions of contacts").absent(Absent::EmptyTable),
    key("guard", Kind::Table(&GUARD), "{ policy = \"warn\" }", "what a run may not do in silence").absent(Absent::EmptyTable),
    key("liquid", Kind::Table(&LIQUID), "{ evaporation = 1e-7 }   # m/s", "what holds for the liquid of the whole scene").absent(Absent::EmptyTable),
    key("materials", Kind::Named(&MATERIAL), "", "density and contact laws, by name").absent(Absent::EmptyTable),
    key("clumps", Kind::Named(&CLUMP), "", "templates of rigid bodies, by name").absent(Absent::EmptyTable),
    tables("contacts", &Kind::Table(&CONTACTS), "[{ between = [\"glass\", \"glass\"], tangential = { friction = 0.3 } }]", "what replaces the mixed parameters of two materials"),
    tables("walls", &Kind::Table(&WALL), "[{ shape = \"box\", material = \"glass\" }]", "surfaces that particles touch"),
    tables("particles", &Kind::Table(&PARTICLES), "[{ material = \"glass\", radius = 1e-3, position = [0.05, 0.05, 0.05] }]", "what is there at the start"),
    tables("insertions", &Kind::Table(&INSERTION), "[]", "particles that come during the run"),
    tables("regions", &Kind::Table(&NAMED_REGION), "[]", "where particles are counted"),
    tables("deletions", &Kind::Table(&NAMED_REGION), "[]", "where particles are taken out"),
    tables("fluxes", &Kind::Table(&FLUX), "[]", "planes whose crossings are counted"),
    tables("membranes", &Kind::Table(&MEMBRANE), "[]", "elastic sheets"),
    tables("bonds", &Kind::Table(&BONDS), "[]", "grains that are glued, to each other and to walls"),
    tables("sprays", &Kind::Table(&SPRAY), "[]", "nozzles whose droplets wet particles"),
    tables("fields", &Kind::Table(&FIELD), "[{ name = \"profile\" }]", "fields of the continuum while the run goes on"),
    key("results", Kind::Texts, "{ torque = \"mean(walls.drum.ty, steady..)\" }", "[numbers of the run by name](../how-to/results-and-errors.md), in its report and summary").absent(Absent::EmptyTable),
    key("output", Kind::Table(&OUTPUT), "{ interval = 0.01 }   # s", "what is written, and when"),
]]);

fn read_document(
    context: &Context,
    document: &Node,
    path: &Path,
    place: &SourceSpan,
) -> Option<Scene> {
    let Value::Table(root) = &document.value else {
        return None;
    };
    let mut root = Fields::new(context, root, place.clone());
    root.hold_to(&SCENE);

    let title: Option<String> = root.read("title");
    let (seed, gravity) = (root.read("seed"), root.read("gravity"));
    let time = root.section("time");
    let time = time.map(|fields| settings::read_time(&fields));
    let domain = root.section("domain");
    let domain = domain.map(|fields| settings::read_domain(&fields));
    let contact = root.section("contact");
    let contact = contact.map(|fields| settings::read_conventions(&fields));
    let overlap_error = (contact.as_ref()).map_or(0.0, |contact| *contact.overlap_error);
    let guard = root.section("guard");
    let guard = guard.map(|fields| guard::read(&fields, overlap_error));
    let liquid = root.section("liquid");
    let liquid = liquid.map(|fields| liquid::read(&fields));

    let materials = read_named(&root, "materials", materials::read);
    let clumps = read_named(&root, "clumps", particles::read_clump);
    let contacts = list(&root, "contacts");
    let contacts = contacts::read_all(context, &contacts, &law_words(&root));
    let walls = read_list(context, &root, "walls", |item| {
        walls::read(item, domain.as_ref())
    });
    let particle_items = list(&root, "particles");
    context.unique_names(&particle_items);
    let particles: Vec<Particles> = particle_items.iter().filter_map(particles::read).collect();
    let insertions = read_list(context, &root, "insertions", insertions::read);
    let regions = read_list(context, &root, "regions", boundaries::read_region);
    let deletions = read_list(context, &root, "deletions", boundaries::read_region);
    let fluxes = read_list(context, &root, "fluxes", boundaries::read_flux);
    let membranes = read_list(context, &root, "membranes", membranes::read);
    let bonds = read_list(context, &root, "bonds", bonds::read);
    let sprays = read_list(context, &root, "sprays", sprays::read);
    let fields = read_list(context, &root, "fields", fields::read);
    let results = root.get("results").and_then(|item| item.table());
    let results = results.map_or_else(Vec::new, |fields| results::read(&fields));

    let mut names = tracked_names(&particle_items, &particles);
    let inserted = list(&root, "insertions").into_iter().enumerate();
    names.extend(inserted.map(|(index, item)| {
        let name = item.node.name().map(str::to_owned);
        let name = name.unwrap_or_else(|| format!("insertion-{}", index + 1));
        (name, Trackable::Insertion)
    }));
    let output = root.section("output");
    let output = output.map(|fields| output::read(&fields, &names));

    Some(Scene {
        path: path.to_owned(),
        place: place.clone(),
        statement: Statement::default(),
        set: Vec::new(),
        title: title.unwrap_or_else(|| readable::printable(&stem(path)).into_owned()),
        seed,
        gravity,
        time: time?,
        domain: domain?,
        contact: contact?,
        guard: guard?,
        liquid: liquid?,
        materials,
        contacts,
        walls,
        clumps,
        particles,
        insertions,
        regions,
        deletions,
        fluxes,
        membranes,
        bonds,
        sprays,
        fields,
        results,
        output: output?,
    })
}

/// Every table below `key`, with its name.
fn read_named<T>(
    root: &Fields<'_>,
    key: &'static str,
    read: impl Fn(Located<String>, &Item<'_>) -> Option<T>,
) -> Vec<T> {
    let Some(fields) = root.get(key).and_then(|item| item.table()) else {
        return Vec::new();
    };
    fields
        .entries()
        .filter_map(|(name, item)| {
            let is_name = root.context.is_one_line(&name);
            read(name, &item).filter(|_| is_name)
        })
        .collect()
}

/// The items of the list `key`, none if it is absent.
fn list<'a>(root: &Fields<'a>, key: &'static str) -> Vec<Item<'a>> {
    root.get(key)
        .and_then(|item| item.list())
        .unwrap_or_default()
}

/// Reads every item of the list `key`; names in it must be unique.
fn read_list<T>(
    context: &Context,
    root: &Fields<'_>,
    key: &'static str,
    read: impl Fn(&Item<'_>) -> Option<T>,
) -> Vec<T> {
    let items = list(root, key);
    context.unique_names(&items);
    items.iter().filter_map(read).collect()
}

/// The words under `law` of every table of every material.
fn law_words(root: &Fields<'_>) -> contacts::LawWords {
    let word = |material: &Node, part: LawPart| -> Option<String> {
        let Value::Table(material) = &material.value else {
            return None;
        };
        let Value::Table(law) = &material.get(part.word())?.node.value else {
            return None;
        };
        match &law.get("law")?.node.value {
            Value::String(word) => Some(word.clone()),
            _ => None,
        }
    };
    match root.get("materials").map(|item| &item.node.value) {
        Some(Value::Table(materials)) => {
            let nodes = materials.entries.iter().map(|entry| &entry.node);
            nodes
                .map(|node| LawPart::ALL.map(|part| word(node, part)))
                .collect()
        }
        _ => Vec::new(),
    }
}

/// The names of `[[particles]]`, and whether each is a single particle. An entry that is wrong counts
/// as single: its own mistake is reported already.
fn tracked_names(items: &[Item<'_>], particles: &[Particles]) -> Vec<(String, Trackable)> {
    items
        .iter()
        .filter_map(|item| item.node.name())
        .map(|name| {
            let read = particles
                .iter()
                .find(|entry| entry.name.as_ref().is_some_and(|other| other.value == name));
            let what = match read.is_none_or(output::is_single) {
                true => Trackable::One,
                false => Trackable::Several,
            };
            (name.to_owned(), what)
        })
        .collect()
}

#[cfg(test)]
mod tests;
