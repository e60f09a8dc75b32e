//! Wavefront OBJ: the lines `v` and `f`.
//!
//! A reader of our own: with `tobj` behind the same checks it takes twice the time (`docs/decisions/0035-mesh-libraries.md`). A test compares
//! with it.

use std::borrow::Cow;
use std::path::Path;

use glam::DVec3;

use super::{Surface, TriangleMesh, too_large};
use crate::error::FormatError;
use crate::formats::lines::{LineReader, Token, Tokens, with_line_feeds};
use crate::formats::number::{NumberStyle, parse_number_of_fortran, push_integer, push_numbers};

/// Reads vertices and faces; polygons are cut into a fan from their first corner, which is right for convex
/// ones. Negative indices count back from the vertices read so far. Everything else is skipped, remarks behind numbers included.
pub(super) fn parse(path: &Path, bytes: Vec<u8>) -> Result<Surface, FormatError> {
    let bytes = with_line_feeds(&bytes);
    let bytes = joined(&bytes);
    // Names may be in the encoding of any country.
    let mut lines = LineReader::new(&bytes[..], path).with_any_encoding();
    let mut surface = Surface::default();
    // Faces may use vertices that come later; the places are needed for the message only.
    let mut last_forward_use: Option<ForwardUse> = None;
    let mut corners = Vec::new();
    while lines.advance()? {
        let mut tokens = lines.tokens();
        match tokens.next().map(|token| token.text) {
            Some("v") => {
                surface.vertices.push(vertex(&mut tokens)?);
                if u32::try_from(surface.vertices.len()).is_err() {
                    return Err(too_large(path));
                }
            }
            Some("f") => {
                corners.clear();
                while let Some(token) = tokens.next().filter(|token| !token.text.starts_with('#')) {
                    let index = corner(&tokens, token, surface.vertices.len())?;
                    if index as usize >= surface.vertices.len()
                        && last_forward_use
                            .as_ref()
                            .is_none_or(|last| last.index < index)
                    {
                        last_forward_use = Some(ForwardUse {
                            index,
                            error: tokens.unexpected(token, "a corner of a face", ""),
                        });
                    }
                    corners.push(index);
                }
                if corners.len() < 3 {
                    return Err(FormatError::at(
                        path,
                        lines.line_number(),
                        Some(1),
                        format!("a face of {} corners", corners.len()),
                        "at least 3 corners",
                    ));
                }
                for pair in corners[1..].windows(2) {
                    surface.triangles.push([corners[0], pair[0], pair[1]]);
                }
            }
            _ => {}
        }
    }
    match last_forward_use {
        Some(last) if last.index as usize >= surface.vertices.len() => Err(FormatError {
            expected: format!("an index from 1 to {}", surface.vertices.len()),
            ..last.error
        }
        .with_help("the file has too few vertices: it is cut, or the index is wrong")),
        _ => Ok(surface),
    }
}

/// The text with continued lines, those with a backslash at their end, as one line. The line feeds that are missing then follow behind it, so
/// that lines keep their numbers. Vertices and faces alone are continued: remarks may end with the name of a folder, and names with a letter of
/// two bytes of which the second is that of a backslash (GBK).
fn joined(bytes: &[u8]) -> Cow<'_, [u8]> {
    if !bytes.contains(&b'\\') {
        return Cow::Borrowed(bytes);
    }
    let mut out = Vec::with_capacity(bytes.len());
    let (mut missing, mut is_open) = (0, false);
    for line in bytes.split_inclusive(|&byte| byte == b'\n') {
        let first = line
            .trim_ascii_start()
            .split(u8::is_ascii_whitespace)
            .next();
        let may_go_on = is_open || matches!(first, Some(b"v" | b"f"));
        match line.trim_ascii_end().strip_suffix(b"\\") {
            Some(start) if may_go_on && !line.contains(&b'#') => {
                out.extend_from_slice(start);
                out.push(b' ');
                missing += 1;
                is_open = true;
            }
            _ => {
                out.extend_from_slice(line);
                out.resize(out.len() + missing, b'\n');
                (missing, is_open) = (0, false);
            }
        }
    }
    Cow::Owned(out)
}

/// The largest index that was used before its vertex, counted from 0.
struct ForwardUse {
    index: u32,
    error: FormatError,
}

fn vertex(tokens: &mut Tokens<'_>) -> Result<DVec3, FormatError> {
    let mut v = DVec3::ZERO;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let word = tokens.expect(name, "a number")?;
        v[axis] = parse_number_of_fortran(word.text)
            .ok_or_else(|| tokens.unexpected(word, name, "a number"))?;
        if !v[axis].is_finite() {
            return Err(tokens.unexpected(word, name, "a finite number"));
        }
    }
    Ok(v)
}

/// The vertex of `7`, `7/1`, `7//2` or `7/1/2`, counted from 0.
fn corner(tokens: &Tokens<'_>, token: Token<'_>, vertices: usize) -> Result<u32, FormatError> {
    let wrong = |expected: &str| tokens.unexpected(token, "a corner of a face", expected);
    let text = token.text.split('/').next().unwrap_or_default();
    let index: i64 = text
        .parse()
        .map_err(|_| wrong("the number of a vertex, counted from 1"))?;
    let from_zero = match index {
        0 => return Err(wrong("the number of a vertex, counted from 1")),
        1.. => index - 1,
        _ => index
            .checked_add_unsigned(vertices as u64)
            .filter(|&index| index >= 0)
            .ok_or_else(|| {
                wrong(&format!(
                    "an index from -{vertices} to -1, counted back from here"
                ))
            })?,
    };
    u32::try_from(from_zero).map_err(|_| wrong("an index below 4294967296"))
}

/// Appends an OBJ in the given style; [`NumberStyle::Shortest`] reads back exactly.
pub fn push_obj(mesh: &TriangleMesh, style: NumberStyle, out: &mut Vec<u8>) {
    for vertex in &mesh.vertices {
        out.extend_from_slice(b"v ");
        push_numbers(out, &vertex.to_array(), style);
        out.push(b'\n');
    }
    for triangle in &mesh.triangles {
        out.push(b'f');
        for index in triangle {
            out.push(b' ');
            push_integer(out, i64::from(*index) + 1);
        }
        out.push(b'\n');
    }
}
