//! Scenes to start from: `mercury-solve new drum` writes one, with the files it needs, and prints the next command.
//!
//! Their texts are files of this crate, `starters/`, so that they are read, run and changed like any scene.

use std::fs::{self, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// A scene to start from.
#[derive(Debug, Clone, Copy)]
pub struct Starter {
    /// The name on the command line;
    pub name: &'static str,
    /// Summary of the scene, in a line.
    pub about: &'static str,
    /// Its files by name, the scene first.
    pub files: &'static [(&'static str, &'static str)],
    /// Options of `mercury-export png` that show it well.
    pub picture: &'static str,
    /// A command for a second look, and what it gives.
    pub more: (&'static str, &'static str),
}

/// Makes the list of a starter's files from their names.
macro_rules! files {
    ($($name:literal),+) => {
        &[$(($name, include_str!(concat!("../starters/", $name)))),+]
    };
}

/// All of them.
pub const STARTERS: [Starter; 11] = [
    Starter {
        name: "drum",
        about: "Beads in a turning drum with four lifters",
        files: files!["drum.toml", "drum-lifters.obj"],
        picture: "--view front",
        more: (
            "mercury-export gif drum --view front --size 480x360",
            "a film, in drum/film/",
        ),
    },
    Starter {
        name: "hopper",
        about: "A hopper whose gate is removed; a plane counts what runs out",
        files: files!["hopper.toml"],
        picture: "--view front",
        more: (
            "mercury-export png hopper --view front --strip 4 --size 1600x520 -o hopper/strip",
            "four times side by side",
        ),
    },
    Starter {
        name: "chute",
        about: "Steady flow down a rough incline, with a profile of density, velocity and stress",
        files: files!["chute.toml"],
        picture: "--view front",
        more: (
            "mercury-cg chute --coordinates Z --width 0.003 --frames 40.. --average time -o chute/profile.svg",
            "profiles over the depth",
        ),
    },
    Starter {
        name: "repose",
        about: "A heap poured on a round plate: the angle of repose",
        files: files!["repose.toml"],
        picture: "--view front --colour height",
        more: (
            "mercury-export particles repose --frames last",
            "the remaining particles, as a table: the heap's height is the largest z",
        ),
    },
    Starter {
        name: "press",
        about: "A bed under a lid that a servo drives to a force",
        files: files!["press.toml"],
        picture: "--contacts --colour none",
        more: (
            "mercury-export gif press --size 480x360",
            "a film, in press/film/",
        ),
    },
    Starter {
        name: "clumps",
        about: "Beans of three spheres each rain into a glass",
        files: files!["clumps.toml", "bean.clump.toml"],
        picture: "--colour body --no-legend",
        more: (
            "mercury-export csv clumps --table bodies --frames last",
            "a row for each bean: place, orientation, mass",
        ),
    },
    Starter {
        name: "mixer",
        about: "Four blades turn in a bowl with two layers of grains",
        files: files!["mixer.toml", "mixer-blades.obj"],
        picture: "--colour material --view oblique",
        more: (
            "mercury-export gif mixer --colour material --view top --size 480x480",
            "a film from above, in mixer/film/",
        ),
    },
    Starter {
        name: "screen",
        about: "A vibrating screen; a plane counts what passes, by size",
        files: files!["screen.toml", "screen-bars.obj"],
        picture: "--colour material --view front",
        more: (
            "mercury-export gif screen --colour material --size 480x360",
            "a film, in screen/film/",
        ),
    },
    Starter {
        name: "spray-drum",
        about: "A nozzle wets the granules in a turning drum; bridges carry the water on",
        files: files!["spray-drum.toml"],
        picture: "--view front --colour liquid",
        more: (
            "mercury-export gif spray-drum --view front --colour liquid --size 480x480",
            "a film, in spray-drum/film/",
        ),
    },
    Starter {
        name: "triaxial",
        about: "A true triaxial test: three plates with servos, then load along one axis",
        files: files!["triaxial.toml"],
        picture: "--contacts --colour none",
        more: (
            "mercury-export gif triaxial --size 480x480",
            "a film, in triaxial/film/",
        ),
    },
    Starter {
        name: "wear",
        about: "A stream of sand wears a plate, which changes its shape",
        files: files!["wear.toml", "wear-plate.obj"],
        picture: "--colour depth --view top --no-particles",
        more: (
            "mercury-export stl wear --frames last",
            "the worn plate as a surface, in wear/stl/",
        ),
    },
];

/// Why a starter was not written.
#[derive(Debug, thiserror::Error)]
pub enum StarterError {
    /// A file of that name is there.
    #[error("{}: this file is there already, and nothing was written\nhelp: name another folder: mercury-solve new {starter} FOLDER", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
        /// The given name.
        starter: &'static str,
    },
    /// The operating system refused.
    #[error("{}: {action}: {source}", path.display())]
    System {
        /// The file or folder.
        path: PathBuf,
        /// Failed action.
        action: &'static str,
        /// Error of the system.
        source: io::Error,
    },
}

impl Starter {
    /// Writes the files into a folder, which is made if it is not there, and returns their paths. No file is ever replaced:
    /// where one of these names is taken, nothing is written.
    ///
    /// # Errors
    /// When a name is taken, or the system refuses.
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>, StarterError> {
        let exists = |path: PathBuf| StarterError::Exists {
            path,
            starter: self.name,
        };
        let paths: Vec<PathBuf> = (self.files.iter())
            .map(|(name, _)| match folder {
                folder if folder == Path::new(".") => PathBuf::from(name),
                folder => folder.join(name),
            })
            .collect();
        // Also links that lead nowhere count: they are in the way.
        if let Some(taken) = paths.iter().find(|path| path.symlink_metadata().is_ok()) {
            return Err(exists(taken.clone()));
        }
        fs::create_dir_all(folder).map_err(|source| StarterError::System {
            path: folder.to_owned(),
            action: "the folder cannot be made",
            source,
        })?;
        for (path, (_, text)) in paths.iter().zip(self.files) {
            // Not File::create: another process may have made the file.
            let made = OpenOptions::new().write(true).create_new(true).open(path);
            let written = made.and_then(|mut file| file.write_all(text.as_bytes()));
            written.map_err(|source| match source.kind() {
                io::ErrorKind::AlreadyExists => exists(path.clone()),
                _ => StarterError::System {
                    path: path.clone(),
                    action: "the file cannot be written",
                    source,
                },
            })?;
        }
        Ok(paths)
    }

    /// The commands that come next, in the folder of the scene, each with what it gives.
    #[must_use]
    pub fn next(&self) -> Vec<(String, String)> {
        let name = self.name;
        vec![
            (
                format!("mercury-solve {name}.toml --check"),
                "what the scene means; nothing is run".to_owned(),
            ),
            (
                format!("mercury-solve {name}.toml"),
                format!("less than a minute; files in {name}/"),
            ),
            (
                format!("mercury-export png {name} --frames last {}", self.picture),
                format!("a picture of the end, in {name}/png/"),
            ),
            (self.more.0.to_owned(), self.more.1.to_owned()),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_written_once_and_never_replaced() {
        for starter in STARTERS {
            let folder = tempfile::tempdir().unwrap();
            let inside = folder.path().join("a/b");
            let paths = starter.write(&inside).unwrap();
            assert_eq!(paths.len(), starter.files.len());
            for (path, (_, text)) in paths.iter().zip(starter.files) {
                assert_eq!(fs::read_to_string(path).unwrap(), *text);
            }
            // The last is mine now: it stays, and the others, which were removed, do not come back.
            let (last, others) = paths.split_last().unwrap();
            fs::write(last, "mine").unwrap();
            for other in others {
                fs::remove_file(other).unwrap();
            }
            let error = starter.write(&inside).unwrap_err();
            assert!(matches!(&error, StarterError::Exists { path, .. } if path == last));
            assert_eq!(fs::read_to_string(last).unwrap(), "mine");
            assert!(others.iter().all(|path| !path.exists()), "{}", starter.name);
        }
    }

    #[test]
    fn the_first_lines_of_a_scene_are_its_commands() {
        for starter in STARTERS {
            let (file, text) = starter.files[0];
            assert_eq!(file, format!("{}.toml", starter.name));
            for (command, _) in starter.next().iter().take(3) {
                assert!(text.contains(command.as_str()), "{file}: {command}");
            }
        }
    }
}
