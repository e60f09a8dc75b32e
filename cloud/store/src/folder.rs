//! A store in a folder: keys are files below it.
//!
//! A content is written beside its place, brought to the disk and renamed, so a crash leaves the old or the new one.
//! `swap` holds a lock (`flock`) on `.swap/<key>` meanwhile; on network file systems that is as good as the locks of
//! that system (NFS 4 and Lustre with `flock` have them).

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU64, Ordering};

use rustix::fs::{FlockOperation, flock};

use crate::hash::copy_range;
use crate::{Entry, Hashing, Result, Store, StoreError, Version, check_key, sha256};

/// Marks a folder as a store, so that a wrong path or a disk that is not mounted is not taken for an empty one.
const MARK: &str = ".mercury-store";

/// A store in a folder.
pub struct FolderStore {
    root: PathBuf,
}

impl FolderStore {
    /// Opens the store in `root`, which must be one.
    pub fn open(root: impl Into<PathBuf>) -> Result<Self> {
        let store = Self { root: root.into() };
        store.mark()?;
        Ok(store)
    }

    /// Makes the folder `root` a store, unless it is one.
    pub fn create(root: impl Into<PathBuf>) -> Result<Self> {
        let store = Self { root: root.into() };
        let failed = |source| StoreError::Folder {
            path: store.root.clone(),
            source,
        };
        fs::create_dir_all(store.root.join(".swap")).map_err(failed)?;
        fs::create_dir_all(store.root.join(".new")).map_err(failed)?;
        let mark = store.root.join(MARK);
        if !mark.exists() {
            fs::write(mark, "A store of mercury-cloud, version 1.\n").map_err(failed)?;
        }
        Ok(store)
    }

    fn mark(&self) -> Result<()> {
        match fs::metadata(self.root.join(MARK)) {
            Ok(_) => Ok(()),
            Err(source) => Err(StoreError::Folder {
                path: self.root.clone(),
                source,
            }),
        }
    }

    fn place(&self, key: &str) -> Result<PathBuf> {
        check_key(key)?;
        Ok(self.root.join(key))
    }

    /// Meaning of a missing file: no such key, or no store at all.
    fn missing<T>(&self, key: &str, source: io::Error, otherwise: T) -> Result<T> {
        if source.kind() == io::ErrorKind::NotFound && self.mark().is_ok() {
            Ok(otherwise)
        } else {
            Err(out_of_reach(key, source))
        }
    }

    /// Writes a content beside its place, brings it to the disk and renames it.
    fn write<T>(&self, key: &str, fill: impl FnOnce(&mut File) -> io::Result<T>) -> Result<T> {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let place = self.place(key)?;
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let new = self.root.join(".new").join(format!(
            "{}.{count}.{}",
            process::id(),
            &sha256(key.as_bytes())[..16]
        ));
        let written = (|| {
            let mut file = File::create(&new)?;
            let result = fill(&mut file)?;
            file.sync_data()?;
            let folder = place.parent().unwrap_or(&self.root);
            fs::create_dir_all(folder)?;
            fs::rename(&new, &place)?;
            File::open(folder)?.sync_all()?;
            Ok(result)
        })();
        written.map_err(|source| {
            // What is left of it does no harm; the error that matters is the first one.
            let _ = fs::remove_file(&new);
            out_of_reach(key, source)
        })
    }
}

fn out_of_reach(key: &str, source: io::Error) -> StoreError {
    StoreError::OutOfReach {
        key: key.to_owned(),
        source,
    }
}

impl Store for FolderStore {
    fn put(&self, key: &str, bytes: &[u8]) -> Result<()> {
        self.write(key, |file| file.write_all(bytes))
    }

    fn put_file(&self, key: &str, from: &mut File, range: Range<u64>) -> Result<String> {
        self.write(key, |file| {
            let mut hashing = Hashing::new(file);
            copy_range(from, range, &mut hashing)?;
            Ok(hashing.finish().0)
        })
    }

    fn get(&self, key: &str) -> Result<Option<Vec<u8>>> {
        match fs::read(self.place(key)?) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(source) => self.missing(key, source, None),
        }
    }

    fn get_range(&self, key: &str, range: Range<u64>) -> Result<Vec<u8>> {
        let read = || {
            let mut file = File::open(self.root.join(key))?;
            file.seek(SeekFrom::Start(range.start))?;
            let mut bytes = Vec::new();
            file.take(range.end.saturating_sub(range.start))
                .read_to_end(&mut bytes)?;
            Ok(bytes)
        };
        check_key(key)?;
        match read() {
            Ok(bytes) => Ok(bytes),
            Err(source) => match self.missing(key, source, ()) {
                Ok(()) => Err(StoreError::Missing(key.to_owned())),
                Err(error) => Err(error),
            },
        }
    }

    fn get_into(&self, key: &str, to: &mut File) -> Result<String> {
        let mut from = match File::open(self.place(key)?) {
            Ok(file) => file,
            Err(source) => {
                self.missing(key, source, ())?;
                return Err(StoreError::Missing(key.to_owned()));
            }
        };
        let mut hashing = Hashing::new(to);
        io::copy(&mut from, &mut hashing).map_err(|source| out_of_reach(key, source))?;
        Ok(hashing.finish().0)
    }

    fn bytes(&self, key: &str) -> Result<Option<u64>> {
        match fs::metadata(self.place(key)?) {
            Ok(file) => Ok(Some(file.len())),
            Err(source) => self.missing(key, source, None),
        }
    }

    fn list(&self, prefix: &str) -> Result<Vec<Entry>> {
        let folder = prefix.trim_end_matches('/');
        let place = self.place(folder)?;
        let mut entries = Vec::new();
        match walk(&place, folder, &mut entries) {
            Ok(()) => {}
            Err(source) => self.missing(prefix, source, ())?,
        }
        entries.sort_by(|a, b| a.key.cmp(&b.key));
        Ok(entries)
    }

    fn delete(&self, key: &str) -> Result<()> {
        match fs::remove_file(self.place(key)?) {
            Ok(()) => Ok(()),
            Err(source) => self.missing(key, source, ()),
        }
    }

    fn delete_all(&self, prefix: &str) -> Result<()> {
        let folder = prefix.trim_end_matches('/');
        match fs::remove_dir_all(self.place(folder)?) {
            Ok(()) => Ok(()),
            Err(source) => self.missing(prefix, source, ()),
        }
    }

    fn get_versioned(&self, key: &str) -> Result<Option<(Vec<u8>, Version)>> {
        Ok(self.get(key)?.map(|bytes| {
            let version = Version(sha256(&bytes));
            (bytes, version)
        }))
    }

    fn swap(&self, key: &str, expected: Option<&Version>, new: &[u8]) -> Result<Option<Version>> {
        check_key(key)?;
        // Locks are few files for all keys: two keys that share one only wait for each other.
        let lock = self.root.join(".swap").join(&sha256(key.as_bytes())[..2]);
        let held = OpenOptions::new()
            .create(true)
            .truncate(false)
            .write(true)
            .open(lock)
            .and_then(|file| {
                flock(&file, FlockOperation::LockExclusive)
                    .map(|()| file)
                    .map_err(io::Error::from)
            })
            .map_err(|source| out_of_reach(key, source))?;
        let now = self.get_versioned(key)?.map(|(_, version)| version);
        let swapped = if now.as_ref() == expected {
            self.put(key, new)?;
            Some(Version(sha256(new)))
        } else {
            None
        };
        drop(held);
        Ok(swapped)
    }
}

fn walk(folder: &Path, key: &str, entries: &mut Vec<Entry>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let Ok(name) = entry.file_name().into_string() else {
            continue;
        };
        let key = format!("{key}/{name}");
        let kind = entry.metadata();
        match kind {
            Ok(kind) if kind.is_dir() => walk(&entry.path(), &key, entries)?,
            Ok(kind) => entries.push(Entry {
                key,
                bytes: kind.len(),
            }),
            // Removed since the folder was read.
            Err(gone) if gone.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder that went away is not an empty store: what it held is out of reach, not gone.
    #[test]
    fn a_store_that_went_away_is_out_of_reach() {
        let folder = tempfile::tempdir().unwrap();
        let store = FolderStore::create(folder.path().join("store")).unwrap();
        store.put("runs/x", b"1").unwrap();
        fs::rename(folder.path().join("store"), folder.path().join("away")).unwrap();
        assert!(matches!(
            store.get("runs/x"),
            Err(StoreError::OutOfReach { .. })
        ));
        assert!(matches!(
            store.list("runs/"),
            Err(StoreError::OutOfReach { .. })
        ));
        assert!(matches!(
            store.put("runs/x", b"2"),
            Err(StoreError::OutOfReach { .. })
        ));
        assert!(FolderStore::open(folder.path().join("store")).is_err());
        fs::rename(folder.path().join("away"), folder.path().join("store")).unwrap();
        assert_eq!(store.get("runs/x").unwrap().unwrap(), b"1");
    }
}
