//! The files of laws that are open while a distribution is read: laws name files, whose laws name files again.

use std::path::{Path, PathBuf};

use super::SizeError;
use crate::scene::{Located, Psd};

/// Files inside each other. Laws of laws are rarely deeper than two.
const MOST_DEEP: usize = 4;

/// Files of one distribution, each counted as often as it is named: files that each name the next one twice double with every level.
const MOST: usize = 1000;

/// The files from the outermost to the one that is read now.
#[derive(Debug)]
pub(super) struct OpenFiles {
    /// Names in messages, and paths.
    chain: Vec<(String, PathBuf)>,
    /// The first of the chain holds the whole distribution and is not named by a law.
    outermost: usize,
    count: usize,
}

impl OpenFiles {
    /// Files of a distribution that stands in a file of its own or in a scene.
    pub(super) fn of(psd: &Located<Psd>) -> Self {
        let name = psd.place.source_name();
        let is_file = !psd.place.is_argument() && Path::new(name).is_file();
        let chain: Vec<_> = is_file
            .then(|| (shown(Path::new(name)), real(Path::new(name))))
            .into_iter()
            .collect();
        Self {
            outermost: chain.len(),
            chain,
            count: 0,
        }
    }

    /// Counts a table or law.
    ///
    /// # Errors
    /// If there are too many.
    pub(super) fn count(&mut self, file: &Located<PathBuf>) -> Result<(), SizeError> {
        self.count += 1;
        if self.count <= MOST {
            return Ok(());
        }
        let message = format!("one distribution of more than {MOST} files");
        let help = "write what the files hold into one mixture or one table";
        Err(SizeError::Improper(file.error(message).with_help(help)))
    }

    /// Opens a law.
    ///
    /// # Errors
    /// If it is open already, or too deep inside of others; with the names from file to file.
    pub(super) fn enter(&mut self, file: &Located<PathBuf>) -> Result<(), SizeError> {
        let path = real(file);
        let names = |from: usize| {
            let open = self.chain[from..].iter().map(|(name, _)| name.clone());
            open.chain([shown(file)]).collect::<Vec<_>>().join(" -> ")
        };
        if let Some(first) = self.chain.iter().position(|(_, open)| *open == path) {
            let message = format!("a law of sizes includes itself: {}", names(first));
            let help = "write the sizes into one of these files, or name a table (.csv)";
            return Err(SizeError::Improper(file.error(message).with_help(help)));
        }
        if self.chain.len() >= self.outermost + MOST_DEEP {
            let message = format!(
                "laws of sizes more than {MOST_DEEP} files deep: {}",
                names(0)
            );
            let help = "write what these files hold into fewer of them";
            return Err(SizeError::Improper(file.error(message).with_help(help)));
        }
        self.chain.push((shown(file), path));
        Ok(())
    }

    /// Closes the law that was opened last.
    pub(super) fn leave(&mut self) {
        self.chain.pop();
    }
}

/// The name of a file, without its folder.
fn shown(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// Where a file is, by whatever links it is named.
fn real(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}
