//! STL: binary files by `stl_io`, text by ourselves (`docs/decisions/0035-mesh-libraries.md`).

use std::io::Cursor;
use std::path::Path;

use glam::{DVec3, Vec3};

use super::{Surface, TriangleMesh, too_large};
use crate::error::FormatError;
use crate::formats::lines::{LineReader, Token, with_line_feeds};
use crate::formats::number::parse_number_of_fortran;
use crate::readable::counted;

/// 80 bytes of free text and the number of triangles.
const BINARY_HEADER: usize = 84;
/// A normal and three corners in single precision, and two bytes of attributes.
const BINARY_TRIANGLE: usize = 50;

/// Reads either kind. Many binary files begin with the word `solid`, which is the mark of the text form: so a file
/// whose size is that of a binary file is one, and so is one with bytes that no text has.
pub(super) fn parse(path: &Path, bytes: Vec<u8>) -> Result<Surface, FormatError> {
    let zero_early = bytes.iter().take(1024).any(|&byte| byte == 0);
    if zero_early || binary_length(&bytes) == Some(bytes.len()) {
        return parse_binary(path, bytes);
    }
    let text = with_line_feeds(&bytes);
    if text.split(|&byte| byte == b'\n').any(is_line_of_stl) {
        return parse_text(path, &text);
    }
    let is_plain = |&byte: &u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    if bytes.iter().take(1024).all(is_plain) {
        let found = "a text without a line that begins with solid or facet";
        return Err(FormatError {
            expected: "a text STL or a binary one".into(),
            ..FormatError::of_file(path, found)
        });
    }
    parse_binary(path, bytes)
}

/// Whether the first word of a line is one with which text STL begins; remarks may stand in front.
fn is_line_of_stl(line: &[u8]) -> bool {
    let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
    let mut words = line.split(u8::is_ascii_whitespace);
    let first = words.find(|word| !word.is_empty()).unwrap_or_default();
    first.eq_ignore_ascii_case(b"solid") || first.eq_ignore_ascii_case(b"facet")
}

/// The length that the number of triangles implies; `None` if the file is shorter than a header.
fn binary_length(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..BINARY_HEADER)?.try_into().ok()?;
    (u32::from_le_bytes(count) as usize)
        .checked_mul(BINARY_TRIANGLE)?
        .checked_add(BINARY_HEADER)
}

fn parse_binary(path: &Path, mut bytes: Vec<u8>) -> Result<Surface, FormatError> {
    let Some(length) = binary_length(&bytes) else {
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
    let mut surface = Surface {
        is_single_precision: true,
        ..Surface::default()
    };
    // Bytes behind the last triangle are ignored, as other programs do, but whole triangles are not lost without a word.
    let surplus = (bytes.len() - length) / BINARY_TRIANGLE;
    if surplus > 0 {
        let announced = (length - BINARY_HEADER) / BINARY_TRIANGLE;
        surface.warnings.push(format!(
            "its header announces {}, and bytes for {surplus} more follow, which are not read",
            counted(announced, "triangle")
        ));
    }
    // `solid ` in the free text would make the library read text. Line feeds end the line that it looks at.
    bytes[..80].fill(b'\n');
    let unread =
        |error| FormatError::of_file(path, format!("the triangles cannot be read: {error}"));
    let mut file = Cursor::new(&bytes);
    let triangles = stl_io::create_stl_reader(&mut file).map_err(unread)?;
    for (index, triangle) in triangles.enumerate() {
        // The normal follows from the corners.
        let corners = triangle
            .map_err(unread)?
            .vertices
            .map(|corner| Vec3::from(<[f32; 3]>::from(corner)).as_dvec3());
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

/// Words that belong to a facet, so that they are none of the free text around it.
const INSIDE: [&str; 6] = ["normal", "outer", "loop", "vertex", "endloop", "endfacet"];

/// Text STL in double precision. Keywords in any case; the normals are not used. Lines outside facets are names and remarks.
fn parse_text(path: &Path, bytes: &[u8]) -> Result<Surface, FormatError> {
    let mut words = Words {
        // Names may be in the encoding of any country.
        lines: LineReader::new(bytes, path).with_any_encoding(),
        line: Vec::new(),
        next: 0,
    };
    let mut surface = Surface::default();
    let mut is_ended = false;
    while words.has_more()? {
        let word = words.ahead(0).to_ascii_lowercase();
        let is_end_of = |words: &Words<'_>, what: &[&str]| {
            let next = words.ahead(1).to_ascii_lowercase();
            word == "end" && what.contains(&next.as_str())
        };
        if INSIDE.contains(&word.as_str()) || is_end_of(&words, &["loop", "facet"]) {
            // A facet that begins with another word: refused.
            words.keyword(&["facet"])?;
        }
        if word != "facet" {
            is_ended |= word == "endsolid" || is_end_of(&words, &["solid"]);
            words.skip_line();
            continue;
        }
        words.keyword(&["facet"])?;
        let corners = facet(&mut words)?;
        is_ended = false;
        if !surface.push(corners) {
            return Err(too_large(path));
        }
    }
    if !is_ended && !surface.triangles.is_empty() {
        surface
            .warnings
            .push("it ends without endsolid, so it may be cut".to_owned());
    }
    Ok(surface)
}

/// The corners of a facet, behind its first word.
fn facet(words: &mut Words<'_>) -> Result<[DVec3; 3], FormatError> {
    words.keyword(&["normal"])?;
    // Programs write anything for the normal of a triangle without area, or nothing.
    while words.has_more()? && !words.is_keyword() {
        words.next += 1;
    }
    words.keyword(&["outer"])?;
    words.keyword(&["loop"])?;
    let mut corners = [DVec3::ZERO; 3];
    for corner in &mut corners {
        words.keyword(&["vertex"])?;
        *corner = DVec3::new(words.number()?, words.number()?, words.number()?);
    }
    for (joined, what) in [("endloop", "loop"), ("endfacet", "facet")] {
        if words.keyword(&[joined, "end"])? == "end" {
            words.keyword(&[what])?;
        }
    }
    Ok(corners)
}

/// The words of a text STL; line ends count as blanks but outside facets. Remarks and colours are passed over.
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
            let start = self.lines.line().trim_ascii_start();
            let is_remark = ["#", "//", ";", "!", "%"]
                .iter()
                .any(|mark| start.starts_with(mark));
            let first = start.split_ascii_whitespace().next().unwrap_or_default();
            let is_colour = ["color", "colour"]
                .iter()
                .any(|word| first.eq_ignore_ascii_case(word));
            if is_remark || is_colour {
                continue;
            }
            let words = self.lines.tokens();
            let words = words.take_while(|word| !word.text.starts_with('#'));
            self.line
                .extend(words.map(|word| (word.start, word.start + word.text.len())));
        }
        Ok(true)
    }

    /// The word after so many others of the line; empty behind the last.
    fn ahead(&self, others: usize) -> &str {
        let place = self.line.get(self.next + others);
        place.map_or("", |&(start, end)| &self.lines.line()[start..end])
    }

    /// Whether the next word is one of those between which the numbers stand.
    fn is_keyword(&self) -> bool {
        let word = self.ahead(0);
        let all = INSIDE.iter().chain(&["facet", "solid", "endsolid", "end"]);
        all.into_iter()
            .any(|known| word.eq_ignore_ascii_case(known))
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
        let help = (text.eq_ignore_ascii_case("vertex") && any_of.contains(&"endloop"))
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

    fn number(&mut self) -> Result<f64, FormatError> {
        let word = self.word("a number")?;
        match parse_number_of_fortran(word.text) {
            Some(value) if value.is_finite() => Ok(value),
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
    if u32::try_from(mesh.triangles.len()).is_err() {
        return Err(format!(
            "an STL cannot hold {} triangles",
            mesh.triangles.len()
        ));
    }
    for &index in mesh.triangles.iter().flatten() {
        let corner = mesh
            .vertices
            .get(index as usize)
            .ok_or_else(|| format!("a triangle uses vertex {index} of {}", mesh.vertices.len()))?;
        if !corner.as_vec3().is_finite() {
            return Err(format!(
                "the vertex {corner} cannot be stored in single precision"
            ));
        }
    }
    let start = out.len();
    out.reserve(BINARY_HEADER + mesh.triangles.len() * BINARY_TRIANGLE);
    let triangles = (0..mesh.triangles.len()).map(|index| {
        let [a, b, c] = mesh.corners(index);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let [normal, a, b, c] = [normal, a, b, c].map(|v| v.as_vec3().to_array());
        stl_io::Triangle {
            normal: stl_io::Normal::new(normal),
            vertices: [a, b, c].map(stl_io::Vertex::new),
        }
    });
    stl_io::write_stl(out, triangles).map_err(|error| error.to_string())?;
    // Must not begin with `solid`.
    out[start..start + 80].fill(b' ');
    out[start..start + 10].copy_from_slice(b"binary STL");
    Ok(())
}
