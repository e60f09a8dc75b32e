//! Files of another kind under the name of the expected one.

use std::path::Path;

use crate::error::FormatError;
use crate::run_files::Packing;

/// Refuses what is there often in place of a file, by its first bytes: a pointer of Git LFS, a page of the web, a compressed file, a text in UTF-16.
pub(crate) fn refuse(path: &Path, bytes: &[u8]) -> Result<(), FormatError> {
    let file = |found: &str| FormatError::of_file(path, found);
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(file("a text in UTF-16").with_help("save it as text with the encoding UTF-8"));
    }
    if let Some(packing) = Packing::of(bytes) {
        let help = format!("unpack it first ({})", packing.command());
        return Err(file("a compressed file").with_help(help));
    }
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = text.trim_ascii_start();
    let begins = |word: &[u8]| {
        let start = text.get(..word.len());
        start.is_some_and(|start| start.eq_ignore_ascii_case(word))
    };
    if begins(b"version https://git-lfs.") {
        return Err(file("a pointer of Git LFS in place of the file")
            .with_help("fetch the file itself: git lfs pull"));
    }
    if begins(b"<!doctype html") || begins(b"<html") {
        return Err(file("a page of the web (HTML) in place of the file").with_help(
            "the download has failed, or was of the page about the file: download the file itself",
        ));
    }
    Ok(())
}
