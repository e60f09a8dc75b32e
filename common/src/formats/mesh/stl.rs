//! STL, binary and text.
//!
//! Readers of our own: stl_io keeps only single precision of text files, gives no place of an error, and takes every file that
//! begins with `solid` for text. The tests compare with it.

use std::path::Path;

use glam::DVec3;

use super::{Surface, TriangleMesh, too_large};
use crate::error::FormatError;
use crate::formats::lines::{LineReader, Token};
use crate::formats::number::parse_number;

/// 80 bytes of free text and the number of triangles.
const BINARY_HEADER: usize = 84;
/// A normal and three corners in single precision, and two bytes of attributes.
const BINARY_TRIANGLE: usize = 50;

/// Reads either kind. Many binary files begin with the word `solid`, which is the mark of the text form: so a file
/// whose size is that of a binary file is one, and so is one with bytes that no text has.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Surface, FormatError> {
    let expected = binary_length(bytes);
    let looks_like_text = bytes
        .trim_ascii_start()
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
        || bytes.starts_with(b"\xef\xbb\xbf");
    let zero_early = bytes.iter().take(1024).any(|&byte| byte == 0);
    if expected == Some(bytes.len()) || !looks_like_text || zero_early {
        parse_binary(path, bytes)
    } else {
        parse_text(path, bytes)
    }
}

/// The length that the number of triangles implies; `None` if the file is shorter than a header.
fn binary_length(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..BINARY_HEADER)?.try_into().ok()?;
    (u32::from_le_bytes(count) as usize)
        .checked_mul(BINARY_TRIANGLE)?
        .checked_add(BINARY_HEADER)
}

fn parse_binary(path: &Path, bytes: &[u8]) -> Result<Surface, FormatError> {
    let Some(length) = binary_length(bytes) else {
        return Err(FormatError {
            expected: format!(
                "at least the {BINARY_HEADER} bytes of the header of a binary STL, or a text STL"
            ),
            ..FormatError::of_file(path, format!("{} bytes", bytes.len()))
        }
        .with_help("a text STL begins with the word solid"));
    };
    if bytes.len() < length {
        let present = (bytes.len() - BINARY_HEADER) / BINARY_TRIANGLE;
        let announced = (length - BINARY_HEADER) / BINARY_TRIANGLE;
        return Err(FormatError {
            expected: format!("{announced} triangles ({length} bytes) as its header announces"),
            ..FormatError::of_file(
                path,
                format!(
                    "a binary STL of {present} whole triangles ({} bytes)",
                    bytes.len()
                ),
            )
        }
        .with_help("the file is cut or not an STL: export or copy it again"));
    }
    // Bytes behind the last triangle are ignored, as other programs do.
    let mut surface = Surface::default();
    for (index, record) in bytes[BINARY_HEADER..length]
        .chunks_exact(BINARY_TRIANGLE)
        .enumerate()
    {
        // The normal comes first; it follows from the corners.
        let corners = [12, 24, 36].map(|start| {
            DVec3::from_array([0, 4, 8].map(|offset| {
                let at = start + offset;
                let bytes = [record[at], record[at + 1], record[at + 2], record[at + 3]];
                f32::from_le_bytes(bytes).into()
            }))
        });
        if let Some(bad) = corners.iter().find(|corner| !corner.is_finite()) {
            return Err(FormatError {
                expected: "finite coordinates".into(),
                ..FormatError::of_file(path, format!("the corner {bad} in triangle {}", index + 1))
            }
            .with_help("the file is damaged, or not a binary STL"));
        }
        if !surface.push(corners) {
            return Err(too_large(path));
        }
    }
    Ok(surface)
}

/// Text STL in double precision. Keywords in any case; the normals are not used.
fn parse_text(path: &Path, bytes: &[u8]) -> Result<Surface, FormatError> {
    let mut words = Words {
        lines: LineReader::new(bytes, path),
        line: Vec::new(),
        next: 0,
    };
    let mut surface = Surface::default();
    words.keyword(&["solid"])?;
    words.skip_line();
    loop {
        match words.keyword(&["facet", "endsolid"])? {
            "facet" => {}
            _ => {
                words.skip_line();
                // A file may hold several solids.
                if !words.has_more()? {
                    return Ok(surface);
                }
                words.keyword(&["solid"])?;
                words.skip_line();
                continue;
            }
        }
        words.keyword(&["normal"])?;
        for _ in 0..3 {
            // Some programs write NaN for the normal of a triangle without area.
            words.number(false)?;
        }
        words.keyword(&["outer"])?;
        words.keyword(&["loop"])?;
        let mut corners = [DVec3::ZERO; 3];
        for corner in &mut corners {
            words.keyword(&["vertex"])?;
            *corner = DVec3::new(
                words.number(true)?,
                words.number(true)?,
                words.number(true)?,
            );
        }
        words.keyword(&["endloop"])?;
        words.keyword(&["endfacet"])?;
        if !surface.push(corners) {
            return Err(too_large(path));
        }
    }
}

/// The words of a text STL; line ends count as blanks but after `solid` and `endsolid`.
struct Words<'a> {
    lines: LineReader<&'a [u8]>,
    /// Start and end of the words of the current line.
    line: Vec<(usize, usize)>,
    next: usize,
}

impl Words<'_> {
    fn has_more(&mut self) -> Result<bool, FormatError> {
        while self.next == self.line.len() {
            self.line.clear();
            self.next = 0;
            if !self.lines.advance()? {
                return Ok(false);
            }
            self.line.extend(
                self.lines
                    .tokens()
                    .map(|word| (word.start, word.start + word.text.len())),
            );
        }
        Ok(true)
    }

    fn skip_line(&mut self) {
        self.next = self.line.len();
    }

    fn word(&mut self, expected: &str) -> Result<Token<'_>, FormatError> {
        if !self.has_more()? {
            return Err(FormatError::at(
                self.lines.path(),
                self.lines.line_number(),
                None,
                "the end of the file within the mesh",
                expected,
            )
            .with_help("the file is cut: a text STL ends with endsolid"));
        }
        let (start, end) = self.line[self.next];
        self.next += 1;
        Ok(Token {
            text: &self.lines.line()[start..end],
            start,
        })
    }

    fn keyword(&mut self, any_of: &[&'static str]) -> Result<&'static str, FormatError> {
        let expected = any_of.join(" or ");
        let word = self.word(&expected)?;
        if let Some(keyword) = any_of
            .iter()
            .find(|keyword| word.text.eq_ignore_ascii_case(keyword))
        {
            return Ok(keyword);
        }
        let (text, start) = (word.text.to_owned(), word.start);
        let help = (text.eq_ignore_ascii_case("vertex") && any_of == ["endloop"])
            .then_some("only triangles are allowed in an STL");
        let error = self.lines.tokens().unexpected(
            Token { text: &text, start },
            "a keyword of STL",
            &expected,
        );
        Err(match help {
            Some(help) => error.with_help(help),
            None => error,
        })
    }

    fn number(&mut self, finite: bool) -> Result<f64, FormatError> {
        let word = self.word("a number")?;
        match parse_number(word.text) {
            Some(value) if value.is_finite() || !finite => Ok(value),
            _ => {
                let (text, start) = (word.text.to_owned(), word.start);
                let word = Token { text: &text, start };
                Err(self
                    .lines
                    .tokens()
                    .unexpected(word, "a coordinate", "a finite number"))
            }
        }
    }
}

/// Appends a binary STL: single precision, normals from the corners (0 for a triangle without area).
///
/// # Errors
/// A message if a coordinate is beyond single precision, an index has no vertex, or there are more triangles than the format counts.
pub fn push_binary_stl(mesh: &TriangleMesh, out: &mut Vec<u8>) -> Result<(), String> {
    let count = u32::try_from(mesh.triangles.len())
        .map_err(|_| format!("an STL cannot hold {} triangles", mesh.triangles.len()))?;
    out.reserve(BINARY_HEADER + mesh.triangles.len() * BINARY_TRIANGLE);
    // Must not begin with `solid`.
    let mut title = [b' '; 80];
    title[..10].copy_from_slice(b"binary STL");
    out.extend_from_slice(&title);
    out.extend_from_slice(&count.to_le_bytes());
    for triangle in &mesh.triangles {
        let mut corners = [DVec3::ZERO; 3];
        for (corner, &index) in corners.iter_mut().zip(triangle) {
            *corner = *mesh.vertices.get(index as usize).ok_or_else(|| {
                format!("a triangle uses vertex {index} of {}", mesh.vertices.len())
            })?;
            if !corner.as_vec3().is_finite() {
                return Err(format!(
                    "the vertex {corner} cannot be stored in single precision"
                ));
            }
        }
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for vector in [normal, a, b, c] {
            for coordinate in vector.as_vec3().to_array() {
                out.extend_from_slice(&coordinate.to_le_bytes());
            }
        }
        out.extend_from_slice(&[0, 0]);
    }
    Ok(())
}
