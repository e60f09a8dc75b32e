//! The clump file and what goes beside it: pebbles as a table, surface and pebbles for ParaView, the surface as STL, a picture; all in the frame of
//! the clump.

use std::path::{Path, PathBuf};

use glam::DVec3;
use mercury_common::formats::clump::{ClumpFile, push_clump};
use mercury_common::formats::mesh::{TriangleMesh, push_binary_stl};
use mercury_common::formats::number::NumberStyle;
use mercury_common::formats::pebble_list::push_pebble_list;
use mercury_common::formats::vtu::{
    VtuArray, VtuCells, VtuCompression, VtuGrid, VtuOptions, encode_vtu,
};
use mercury_common::whole_file::{FileError, WholeFile};
use mercury_pictures::{ClumpScene, Options as PictureOptions, draw_clump};
use thiserror::Error;

use crate::clump::Built;

/// Surfaces of more triangles are left out of the picture.
const MOST_DRAWN: usize = 200_000;

/// A file that is to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutputFile {
    /// Where.
    pub path: PathBuf,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Why a file was not written.
#[derive(Debug, Error)]
pub enum OutputError {
    /// The file is there already.
    #[error("{} is there already: add --force to replace it, or -o to write elsewhere", .0.display())]
    Exists(PathBuf),
    /// The folder is not there.
    #[error("{}: there is no folder {}: make it first, or -o to write elsewhere", path.display(), folder.display())]
    NoFolder {
        /// The file.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// The system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// The format cannot hold it.
    #[error("{}: {reason}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Description of the mismatch.
        reason: String,
    },
}

/// The paths of all files of a clump whose clump file is `path`: `rod.clump.toml` goes with `rod.pebbles.csv`, `rod.pebbles.vtu`,
/// if wished `rod.png`, and, where there is a surface, `rod.surface.stl` and `rod.surface.vtu`.
#[must_use]
pub fn paths(path: &Path, has_surface: bool, has_picture: bool) -> Vec<PathBuf> {
    let beside = |ending: &str| beside(path, ending);
    let mut all = vec![
        path.to_owned(),
        beside("pebbles.csv"),
        beside("pebbles.vtu"),
    ];
    if has_picture {
        all.push(beside("png"));
    }
    if has_surface {
        all.extend([surface_path(path), beside("surface.vtu")]);
    }
    all
}

/// The clump file that a user means by `path`: a name that does not end in `.toml` gets `.clump.toml`. Text behind another point
/// may be part of a number.
///
/// ```
/// use std::path::Path;
///
/// use mclump::output::with_suffix;
///
/// let file = |name: &str| with_suffix(Path::new(name)).display().to_string();
/// assert_eq!(file("b0.1e-3"), "b0.1e-3.clump.toml");
/// assert_eq!(file("out/rod.clump"), "out/rod.clump.toml");
/// assert_eq!(file("rod.toml"), "rod.toml");
/// ```
#[must_use]
pub fn with_suffix(path: &Path) -> PathBuf {
    let has = |ending: &str| {
        let known = path.extension();
        known.is_some_and(|known| known.eq_ignore_ascii_case(ending))
    };
    match path.file_name() {
        Some(name) if !has("toml") => {
            let mut name = name.to_os_string();
            name.push(if has("clump") { ".toml" } else { ".clump.toml" });
            path.with_file_name(name)
        }
        _ => path.to_owned(),
    }
}

/// The file of this ending that goes with the clump file `path`.
fn beside(path: &Path, ending: &str) -> PathBuf {
    let name = path
        .file_name()
        .map_or(String::new(), |name| name.to_string_lossy().into_owned());
    let stem = name
        .strip_suffix(".clump.toml")
        .or_else(|| name.strip_suffix(".toml"))
        .unwrap_or(&name);
    path.with_file_name(format!("{stem}.{ending}"))
}

/// Where the surface goes that the clump file at `path` names.
fn surface_path(path: &Path) -> PathBuf {
    beside(path, "surface.stl")
}

/// The contents of all files of a clump, in the order of [`paths`]; the clump file names its surface.
///
/// # Errors
/// If a coordinate does not fit the format of a file.
pub fn contents(
    built: &Built,
    path: &Path,
    has_picture: bool,
) -> Result<Vec<OutputFile>, OutputError> {
    let mut paths = paths(path, built.surface.is_some(), has_picture).into_iter();
    let mut files = Vec::new();
    let mut add = |make: &dyn Fn() -> Result<Vec<u8>, String>| {
        let path = paths.next().unwrap_or_default();
        match make() {
            Ok(bytes) => {
                files.push(OutputFile { path, bytes });
                Ok(())
            }
            Err(reason) => Err(OutputError::Content { path, reason }),
        }
    };
    let surface = built.surface.as_ref().map(|_| surface_path(path));
    let surface = surface.as_deref().and_then(Path::file_name);
    let file = ClumpFile {
        surface: surface.map(|name| name.to_string_lossy().into_owned()),
        ..built.file.clone()
    };
    add(&|| {
        let mut out = Vec::new();
        push_clump(&file, &mut out).map_err(|problem| problem.to_string())?;
        Ok(out)
    })?;
    add(&|| {
        let mut out = Vec::new();
        push_pebble_list(&built.file.pebbles, NumberStyle::Shortest, &mut out);
        Ok(out)
    })?;
    add(&|| pebbles_vtu(&built.file))?;
    if has_picture {
        add(&|| picture(built))?;
    }
    if let Some(mesh) = &built.surface {
        add(&|| {
            let mut out = Vec::new();
            push_binary_stl(mesh, &mut out)?;
            Ok(out)
        })?;
        add(&|| surface_vtu(mesh))?;
    }
    Ok(files)
}

/// Pebbles as points with radius and diameter, for ParaView's glyphs or its Point Gaussian.
fn pebbles_vtu(clump: &ClumpFile) -> Result<Vec<u8>, String> {
    let points: Vec<DVec3> = clump.pebbles.iter().map(|p| p.position).collect();
    let radii: Vec<f64> = clump.pebbles.iter().map(|p| p.radius).collect();
    let diameters: Vec<f64> = radii.iter().map(|r| 2.0 * r).collect();
    let grid = VtuGrid {
        points: points.into(),
        point_data: vec![
            VtuArray::new("radius", radii),
            VtuArray::new("diameter", diameters),
        ],
        ..VtuGrid::default()
    };
    // A few numbers: not worth a compressor, and plain to every reader.
    let options = VtuOptions {
        compression: VtuCompression::None,
        ..VtuOptions::DEFAULT
    };
    Ok(encode_vtu(&grid, options)?.concat())
}

/// Three views of pebbles and surface.
fn picture(built: &Built) -> Result<Vec<u8>, String> {
    let pebbles: Vec<(DVec3, f64)> = built
        .file
        .pebbles
        .iter()
        .map(|pebble| (pebble.position, pebble.radius))
        .collect();
    // A very fine surface would take long and show no more than its pebbles.
    let mesh = (built.surface.as_ref()).filter(|mesh| mesh.triangles.len() <= MOST_DRAWN);
    let triangles: Vec<[DVec3; 3]> = mesh.map_or(Vec::new(), |mesh| {
        (0..mesh.triangles.len())
            .map(|index| mesh.corners(index))
            .collect()
    });
    let scene = ClumpScene {
        title: &built.file.name,
        pebbles: &pebbles,
        surface: &triangles,
    };
    let image =
        draw_clump(&scene, &PictureOptions::default()).map_err(|error| error.to_string())?;
    image.png().map_err(|error| error.to_string())
}

fn surface_vtu(mesh: &TriangleMesh) -> Result<Vec<u8>, String> {
    let grid = VtuGrid {
        points: (&mesh.vertices).into(),
        cells: VtuCells::Triangles((&mesh.triangles).into()),
        ..VtuGrid::default()
    };
    Ok(encode_vtu(&grid, VtuOptions::DEFAULT)?.concat())
}

/// Whether the files may be written.
///
/// # Errors
/// If the folder of one is not there, or if one is there and `force` is not given.
pub fn check_free(paths: &[PathBuf], force: bool) -> Result<(), OutputError> {
    for path in paths {
        // The parent of a bare name is empty: the folder in which the program runs.
        let folder = path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            return Err(OutputError::NoFolder {
                path: path.clone(),
                folder: folder.to_owned(),
            });
        }
    }
    match paths.iter().find(|path| path.exists()) {
        Some(path) if !force => Err(OutputError::Exists(path.clone())),
        _ => Ok(()),
    }
}

/// Writes all files under temporary names, then renames them: each is there as a whole or not at all.
///
/// # Errors
/// If the system refuses; files that were there before are still there then, unless the refusal came with the
/// renaming.
pub fn write(files: &[OutputFile]) -> Result<(), OutputError> {
    let mut whole = Vec::with_capacity(files.len());
    for file in files {
        let mut named_later = WholeFile::create(&file.path)?;
        named_later.append(&file.bytes)?;
        named_later.sync()?;
        whole.push(named_later);
    }
    for file in whole {
        file.finish()?;
    }
    Ok(())
}
