//! Lines of a chain: their members, and how a link follows from the line before.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use mercury_common::whole_file::FileError;
use serde::{Deserialize, Serialize};

use crate::plan::sha256;

/// Number of the physics: it rises with every change of this program that changes a state or an output of an existing scene. Only a program with the same
/// number can make the steps of a run again.
pub const PHYSICS: u32 = 1;

/// Version of the lines.
const VERSION: u32 = 1;

/// A file that was read for the scene.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct StatedFile {
    /// The key of the scene that leads to it; `scene` of the scene itself.
    pub key: String,
    /// Its length.
    pub bytes: u64,
    /// SHA-256 of its bytes.
    pub sha256: String,
}

/// A scene as a run was made from it.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Stated {
    /// SHA-256 of the statement: a line `KEY = VALUE` for each key of the scene, in the order of the keys.
    pub scene: String,
    /// `KEY=VALUE` that the command line put on top of the scene.
    pub set: Vec<String>,
    /// The scene, and the files that were read for it.
    pub files: Vec<StatedFile>,
}

/// The scene of a run, for its chain and its checkpoints.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ChainScene {
    /// As the chain states it.
    pub stated: Stated,
    /// Every key of the scene with its value.
    pub statement: BTreeMap<String, String>,
}

impl ChainScene {
    /// With the sum of the statement.
    #[must_use]
    pub fn new(
        statement: BTreeMap<String, String>,
        set: Vec<String>,
        files: Vec<StatedFile>,
    ) -> Self {
        let lines = statement
            .iter()
            .map(|(key, value)| format!("{key} = {value}\n"));
        let stated = Stated {
            scene: sha256(lines.collect::<String>().as_bytes()),
            set,
            files,
        };
        Self { stated, statement }
    }
}

/// The first line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Begin {
    /// Version of the lines.
    pub mercury_chain: u32,
    /// [`PHYSICS`] of the program.
    pub physics: u32,
    /// Version of the program.
    pub program: String,
    /// The scene.
    #[serde(flatten)]
    pub stated: Stated,
}

/// A line of a run that goes on with another scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Step behind which it holds.
    pub change: u64,
    /// Time of this step, s.
    pub time: f64,
    /// The scene.
    #[serde(flatten)]
    pub stated: Stated,
}

/// Length of a file, and SHA-256 of so many bytes from its beginning.
pub type FileState = (u64, String);

/// A line of a state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// Steps made.
    pub step: u64,
    /// s
    pub time: f64,
    /// [`state_sum`](super::state_sum) of the state.
    pub state: String,
    /// The files that grow, by their names.
    pub outputs: BTreeMap<String, FileState>,
}

/// A number of the summary.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EndResult {
    /// Its definition.
    pub of: String,
    /// Its value.
    pub value: Option<f64>,
    /// Its standard error.
    pub error: Option<f64>,
}

/// The last line of a run that came to its end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct End {
    /// How it ended: `planned`, `at_rest`, `worn` or `known`.
    pub end: String,
    /// The last state, and all files as they were closed.
    #[serde(flatten)]
    pub link: Link,
    /// The numbers of the summary.
    pub results: BTreeMap<String, EndResult>,
}

/// Members of a line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Content {
    /// The first line.
    Begin(Begin),
    /// Another scene from here on.
    Change(Change),
    /// The end. Before [`Content::Link`], which has fewer members.
    End(End),
    /// A state.
    Link(Link),
}

impl Content {
    /// The step that it is of.
    #[must_use]
    pub fn step(&self) -> u64 {
        match self {
            Self::Begin(_) => 0,
            Self::Change(change) => change.change,
            Self::Link(link) => link.step,
            Self::End(end) => end.link.step,
        }
    }
}

/// Why a chain cannot be read, or does not hold.
#[derive(Debug, thiserror::Error)]
pub enum ChainError {
    /// The operating system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// A line is wrong.
    #[error("{}: line {number} {problem}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Of the line, from 1.
        number: usize,
        /// Description of the problem.
        problem: String,
    },
}

/// A line of a chain that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Its members but for the link.
    pub content: Content,
    /// Its link.
    pub link: String,
    /// Bytes of the chain up to its end.
    pub end: u64,
}

/// A chain that was read, all links recomputed.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    first: Begin,
    /// All lines.
    pub lines: Vec<Line>,
}

/// Bytes between the members of a line and its link.
const BEFORE_LINK: &str = ",\"link\":\"";
/// Bytes behind its link.
const BEHIND_LINK: &str = "\"}";

/// Link of a line from that of the line before, which is empty for the first, and the text of its other members.
fn link_of(before: &str, members: &str) -> String {
    sha256(format!("{before}{members}").as_bytes())
}

/// A line, with its end, and its link.
pub(super) fn line_of(
    before: &str,
    content: &Content,
) -> Result<(String, String), serde_json::Error> {
    let members = serde_json::to_string(content)?;
    let link = link_of(before, &members);
    let open = members.strip_suffix('}').unwrap_or(&members);
    Ok((format!("{open}{BEFORE_LINK}{link}{BEHIND_LINK}\n"), link))
}

/// The first line of a chain.
pub(super) fn first(stated: Stated) -> Content {
    Content::Begin(Begin {
        mercury_chain: VERSION,
        physics: PHYSICS,
        program: env!("CARGO_PKG_VERSION").to_owned(),
        stated,
    })
}

/// Reads a line behind one with this link.
fn read_line(line: &str, before: &str) -> Result<Line, String> {
    if line.ends_with('\r') {
        return Err("ends in CR LF: an editor or a transfer as text changed the file".to_owned());
    }
    let parts = line.strip_suffix(BEHIND_LINK);
    let parts = parts.and_then(|line| line.rsplit_once(BEFORE_LINK));
    let (open, link) = parts.ok_or("has no link at its end")?;
    let members = format!("{open}}}");
    let content: Content = serde_json::from_str(&members)
        .map_err(|error| format!("has other members than those of a chain: {error}"))?;
    if link_of(before, &members) != link {
        return Err(format!(
            "(step {}) does not follow from the line before it: one of the two was changed, or lines were left out, added or exchanged",
            content.step()
        ));
    }
    Ok(Line {
        content,
        link: link.to_owned(),
        end: 0,
    })
}

impl Chain {
    /// Reads a chain.
    ///
    /// # Errors
    /// If the file cannot be read, or a line is wrong.
    pub fn read(path: &Path) -> Result<Self, ChainError> {
        let failed = FileError::of(path, "the chain cannot be read");
        let bytes = std::fs::read(path).map_err(failed)?;
        Self::parse(path, &bytes)
    }

    /// Reads the chain in these bytes of a file.
    ///
    /// # Errors
    /// If a line is wrong.
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<Self, ChainError> {
        let wrong = |number, problem| ChainError::Line {
            path: path.to_owned(),
            number,
            problem,
        };
        let mut first: Option<Begin> = None;
        let mut lines: Vec<Line> = Vec::new();
        let mut end = 0;
        for (index, text) in bytes.split_inclusive(|byte| *byte == b'\n').enumerate() {
            let number = index + 1;
            let wrong = |problem: &str| wrong(number, problem.to_owned());
            let text = text
                .strip_suffix(b"\n")
                .ok_or_else(|| wrong("is cut off"))?;
            let text = std::str::from_utf8(text).map_err(|_| wrong("is no text in UTF-8"))?;
            let before = lines.last().map_or("", |line| &line.link);
            let mut line = read_line(text, before).map_err(|problem| wrong(&problem))?;
            end += text.len() as u64 + 1;
            line.end = end;
            match (&line.content, &first) {
                (Content::Begin(begin), None) if begin.mercury_chain == VERSION => {
                    first = Some(begin.clone());
                }
                (Content::Begin(begin), None) => {
                    let version = begin.mercury_chain;
                    return Err(wrong(&format!(
                        "begins a chain of version {version}, this program reads version {VERSION}"
                    )));
                }
                (Content::Begin(_), Some(_)) => return Err(wrong("begins a chain once more")),
                (_, None) => return Err(wrong("is not the beginning of a chain")),
                _ => {}
            }
            lines.push(line);
        }
        let first = first.ok_or_else(|| wrong(1, "is missing: the file is empty".to_owned()))?;
        Ok(Self { first, lines })
    }

    /// The first line.
    #[must_use]
    pub fn first(&self) -> &Begin {
        &self.first
    }

    /// The scene that holds at the end, and the step behind which it does.
    #[must_use]
    pub fn stated(&self) -> (&Stated, u64) {
        let changes = self.lines.iter().rev();
        let mut changes = changes.filter_map(|line| match &line.content {
            Content::Change(change) => Some((&change.stated, change.change)),
            _ => None,
        });
        changes.next().unwrap_or((&self.first.stated, 0))
    }

    /// States at simulated times, with their links.
    pub fn links(&self) -> impl DoubleEndedIterator<Item = (&Link, &str)> {
        self.lines.iter().filter_map(|line| match &line.content {
            Content::Link(link) => Some((link, line.link.as_str())),
            _ => None,
        })
    }

    /// The end; `None` of a run that was stopped.
    #[must_use]
    pub fn end(&self) -> Option<&End> {
        match &self.lines.last()?.content {
            Content::End(end) => Some(end),
            _ => None,
        }
    }

    /// The last link.
    #[must_use]
    pub fn last(&self) -> &str {
        self.lines.last().map_or("", |line| &line.link)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines() -> Vec<String> {
        let statement = BTreeMap::from([("time.end".to_owned(), "1".to_owned())]);
        let link = |step: u64| Link {
            step,
            time: step as f64 * 0.1,
            state: sha256(b"state"),
            outputs: BTreeMap::from([("a.ene".to_owned(), (step, sha256(b"")))]),
        };
        let contents = [
            first(ChainScene::new(statement, Vec::new(), Vec::new()).stated),
            Content::Link(link(100)),
            Content::Link(link(200)),
            Content::End(End {
                end: "planned".to_owned(),
                link: link(250),
                results: BTreeMap::new(),
            }),
        ];
        let mut before = String::new();
        let mut lines = Vec::new();
        for content in &contents {
            let (line, link) = line_of(&before, content).unwrap();
            lines.push(line);
            before = link;
        }
        lines
    }

    fn parse(text: &str) -> Result<Chain, String> {
        Chain::parse(Path::new("a"), text.as_bytes()).map_err(|error| error.to_string())
    }

    #[test]
    fn lines_are_read_back() {
        let chain = parse(&lines().concat()).unwrap();
        let steps: Vec<u64> = chain.links().map(|(link, _)| link.step).collect();
        assert_eq!(steps, [100, 200]);
        assert_eq!(chain.end().unwrap().link.step, 250);
        assert_eq!(chain.first().physics, PHYSICS);
        // As a user checks it: SHA-256 of `time.end = 1\n`.
        assert_eq!(chain.stated().0.scene, sha256(b"time.end = 1\n"));
        assert_eq!(chain.last().len(), 64);
    }

    #[test]
    fn any_change_of_a_line_is_found_and_named() {
        let lines = lines();
        let whole = lines.concat();
        let follows = |number: usize, step: u64| {
            format!("a: line {number} (step {step}) does not follow from the line before it")
        };
        let said = |text: &str| parse(text).unwrap_err();
        let is = |text: &str, begin: &str| {
            let said = said(text);
            assert!(said.starts_with(begin), "{said}");
        };
        is(
            &whole.replace("\"step\":200", "\"step\":201"),
            &follows(3, 201),
        );
        is(&[&lines[0][..], &lines[2]].concat(), &follows(2, 200));
        is(
            &[&lines[0][..], &lines[1], &lines[1]].concat(),
            &follows(3, 100),
        );
        is(&[&lines[1][..], &lines[0]].concat(), &follows(1, 100));
        is(&whole.replace('\n', "\r\n"), "a: line 1 ends in CR LF");
        is(&whole[..whole.len() - 1], "a: line 4 is cut off");
        is("", "a: line 1 is missing: the file is empty");
        is("{}\n", "a: line 1 has no link at its end");
        is(&format!("{}\u{fffd}\n", lines[0]), "a: line 2 has no link");
        let other = whole.replacen("\"mercury_chain\":1", "\"mercury_chain\":2", 1);
        is(&other, &follows(1, 0));
        for (at, _) in whole.char_indices().step_by(7) {
            let mut bytes = whole.clone().into_bytes();
            bytes[at] ^= 1;
            let read = Chain::parse(Path::new("a"), &bytes);
            assert!(read.is_err(), "byte {at}");
        }
    }
}
