//! The one thing that server and workers share: keys with contents, and a compare-and-swap.
//!
//! [`FolderStore`] keeps them in a folder, `S3Store` (feature `s3`) in a bucket. Nothing above this crate knows which one
//! it is.

mod folder;
pub mod frames;
mod hash;
#[cfg(feature = "s3")]
mod s3;

use std::fs::File;
use std::io;
use std::ops::Range;
use std::path::PathBuf;

pub use folder::FolderStore;
pub use hash::{Hashing, hex, sha256, sha256_of_file};
#[cfg(feature = "s3")]
pub use s3::S3Store;

/// Why a store did not do what was wanted.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// A key that is no key: see [`check_key`].
    #[error("{0:?} is no key: parts of letters, digits and . _ - with / between")]
    Key(String),
    /// The store gives no answer, or the wrong one. May pass.
    #[error("the store does not respond at {key}: {source}")]
    OutOfReach {
        /// Key.
        key: String,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// There is no such key where there must be one.
    #[error("the store has no {0}")]
    Missing(String),
    /// An address at which there is no store, or none that is good enough.
    #[error("{url}: {why}")]
    Url {
        /// The address.
        url: String,
        /// The problem.
        why: String,
    },
    /// A folder that is no store, and cannot become one.
    #[error("{path}: {source}")]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
}

/// Result of an operation.
pub type Result<T> = std::result::Result<T, StoreError>;

/// Which content a key had when it was read. Only good for comparing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Version(String);

/// A key with the length of its content.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Key.
    pub key: String,
    /// Length in bytes.
    pub bytes: u64,
}

/// Keys with contents. A key always has its whole old or its whole new content.
pub trait Store: Send + Sync {
    /// Gives `key` a content.
    fn put(&self, key: &str, bytes: &[u8]) -> Result<()>;

    /// Gives `key` the bytes `range` of `file`; returns their SHA-256.
    fn put_file(&self, key: &str, file: &mut File, range: Range<u64>) -> Result<String>;

    /// The content of `key`, or `None`.
    fn get(&self, key: &str) -> Result<Option<Vec<u8>>>;

    /// Bytes of the content of `key`, as many as there are within `range`.
    fn get_range(&self, key: &str, range: Range<u64>) -> Result<Vec<u8>>;

    /// Appends the content of `key` to `to`; returns its SHA-256.
    fn get_into(&self, key: &str, to: &mut File) -> Result<String>;

    /// Length of the content of `key`, or `None`.
    fn bytes(&self, key: &str) -> Result<Option<u64>>;

    /// All keys that begin with `prefix`, which ends in `/`, in order.
    fn list(&self, prefix: &str) -> Result<Vec<Entry>>;

    /// Removes `key`, where it exists.
    fn delete(&self, key: &str) -> Result<()>;

    /// Removes all keys that begin with `prefix`, which ends in `/`.
    fn delete_all(&self, prefix: &str) -> Result<()> {
        for entry in self.list(prefix)? {
            self.delete(&entry.key)?;
        }
        Ok(())
    }

    /// The content of `key` with its version, or `None`.
    fn get_versioned(&self, key: &str) -> Result<Option<(Vec<u8>, Version)>>;

    /// Gives `key` the content `new` if its version is still `expected` (`None`: there is no such key).
    /// Returns the new version, or `None` where it was another.
    fn swap(&self, key: &str, expected: Option<&Version>, new: &[u8]) -> Result<Option<Version>>;
}

/// The longest part of a key between slashes, in bytes; file systems take 255, and `swap` adds some.
const LONGEST_PART: usize = 240;

/// Checks a key: parts of `A-Z a-z 0-9 . _ -`, none of which begins with a dot, with single slashes between.
pub fn check_key(key: &str) -> Result<()> {
    let good = |part: &str| {
        !part.is_empty()
            && part.len() <= LONGEST_PART
            && !part.starts_with('.')
            && part
                .bytes()
                .all(|b| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'_' | b'-'))
    };
    if key.split('/').all(good) {
        Ok(())
    } else {
        Err(StoreError::Key(key.to_owned()))
    }
}

/// Whether `url` names a bucket, which is slower than a folder and costs money for each request.
pub fn is_remote(url: &str) -> bool {
    url.starts_with("s3://")
}

/// Opens the store at `url`: a folder, or `s3://BUCKET/PREFIX`.
pub fn open(url: &str) -> Result<Box<dyn Store>> {
    if is_remote(url) {
        return remote(url, false);
    }
    Ok(Box::new(FolderStore::open(
        url.strip_prefix("file://").unwrap_or(url),
    )?))
}

/// Opens the store at `url`, and makes it one where it is a folder. A bucket has to exist.
pub fn create(url: &str) -> Result<Box<dyn Store>> {
    if is_remote(url) {
        return remote(url, true);
    }
    Ok(Box::new(FolderStore::create(
        url.strip_prefix("file://").unwrap_or(url),
    )?))
}

#[cfg(feature = "s3")]
fn remote(url: &str, probe: bool) -> Result<Box<dyn Store>> {
    let store = if probe {
        S3Store::create(url)
    } else {
        S3Store::open(url)
    };
    Ok(Box::new(store?))
}

#[cfg(not(feature = "s3"))]
fn remote(url: &str, _: bool) -> Result<Box<dyn Store>> {
    Err(StoreError::Url {
        url: url.to_owned(),
        why: "this program was built without object storage; build it with --features s3"
            .to_owned(),
    })
}
