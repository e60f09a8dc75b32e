//! Wavefront OBJ: the lines `v` and `f`.
//!
//! A reader of our own: tobj gives no place of an error, and panics on some faces (`docs/decisions/0029-libraries.md`). The tests compare
//! with it.

use std::path::Path;

use glam::DVec3;

use super::{Surface, TriangleMesh, too_large};
use crate::error::FormatError;
use crate::formats::lines::{LineReader, Token, Tokens};
use crate::formats::number::{NumberStyle, push_integer, push_numbers};

/// Reads vertices and faces; polygons are cut into a fan from their first corner, which is right for convex
/// ones. Negative indices count back from the vertices read so far. Everything else is skipped.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Surface, FormatError> {
    let mut lines = LineReader::new(bytes, path);
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
                while let Some(token) = tokens.next() {
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

/// The largest index that was used before its vertex, counted from 0.
struct ForwardUse {
    index: u32,
    error: FormatError,
}

fn vertex(tokens: &mut Tokens<'_>) -> Result<DVec3, FormatError> {
    let mut v = DVec3::ZERO;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let token = tokens.clone().next();
        v[axis] = tokens.number(name)?;
        if let Some(token) = token.filter(|_| !v[axis].is_finite()) {
            return Err(tokens.unexpected(token, name, "a finite number"));
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
