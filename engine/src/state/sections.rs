//! Sections of a state with their names: bytes that were encoded or read, before anything decodes them.

use std::fmt;
use std::ops::Range;

use super::codec::{DecodeError, Decoder, Encoder, Plain, whole};

/// Name of the section behind the last one, with a checksum of the names: so a state that is cut between two sections is seen to be cut,
/// and a name that is damaged to be damaged.
const END: &str = "end";

/// The sections of a state in their order, all checksums compared. Equal bytes are an equal state.
#[derive(Clone, PartialEq, Eq, Default)]
pub struct Sections {
    bytes: Vec<u8>,
    places: Vec<(String, Range<usize>)>,
}

impl fmt::Debug for Sections {
    /// Names, lengths and checksums: the bytes of a state are millions.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut map = f.debug_map();
        for (name, bytes) in self.iter() {
            let reported =
                format_args!("{} bytes, {:08x}", bytes.len(), crc32fast::hash(bytes)).to_string();
            map.entry(&name, &reported);
        }
        map.finish()
    }
}

impl Sections {
    /// Appends a section.
    pub fn push<'a>(&mut self, name: String, content: impl Iterator<Item = &'a [u8]>) {
        let begin = self.bytes.len();
        content.for_each(|bytes| self.bytes.extend_from_slice(bytes));
        self.places.push((name, begin..self.bytes.len()));
    }

    /// Reads the sections before the one named `end`, or all if there is none.
    ///
    /// # Errors
    /// If one is cut or damaged.
    pub fn take_from(decoder: &mut Decoder<'_>, end: &str) -> Result<Self, DecodeError> {
        let mut sections = Self::default();
        while let Some(name) = decoder.next_name() {
            if name == end {
                break;
            }
            let content = decoder.content(&name)?;
            sections.push(name, std::iter::once(content));
        }
        Ok(sections)
    }

    /// Their names and contents.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (&str, &[u8])> {
        let all = self.places.iter();
        all.map(|(name, place)| (name.as_str(), &self.bytes[place.clone()]))
    }

    /// The value in the section of this name.
    ///
    /// # Errors
    /// If there is none, or it holds no such value.
    pub fn get<T: Plain>(&self, name: &str) -> Result<T, DecodeError> {
        let wrong = |reason| DecodeError::Wrong {
            section: name.to_owned(),
            reason,
        };
        let mut all = self.iter();
        match all.find(|(found, _)| *found == name) {
            Some((_, bytes)) => whole(bytes, T::take).map_err(wrong),
            None => Err(wrong("it is missing".to_owned())),
        }
    }

    /// This state with another value in the section of this name.
    ///
    /// # Errors
    /// Errors of [`Sections::get`].
    pub fn edited<T: Plain>(
        &self,
        name: &str,
        edit: impl FnOnce(&mut T),
    ) -> Result<Self, DecodeError> {
        let mut value = self.get(name)?;
        edit(&mut value);
        let mut bytes = Vec::new();
        value.put(&mut bytes);
        let mut edited = Self::default();
        for (found, content) in self.iter() {
            let content = if found == name { &bytes } else { content };
            edited.push(found.to_owned(), std::iter::once(content));
        }
        Ok(edited)
    }

    fn checksum_of_names(&self) -> u32 {
        let mut checksum = crc32fast::Hasher::new();
        self.places
            .iter()
            .for_each(|(name, _)| checksum.update(name.as_bytes()));
        checksum.finalize()
    }

    /// Bytes of the state, with a version and checksums.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let mut encoder = Encoder::new();
        for (name, content) in self.iter() {
            encoder.section_by(name, |pieces| pieces.end().extend_from_slice(content));
        }
        encoder.section(END, &self.checksum_of_names());
        encoder.finish()
    }

    /// From the bytes of [`Sections::encode`].
    ///
    /// # Errors
    /// If the bytes are no state, of another version, cut or damaged.
    pub fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        let mut decoder = Decoder::new(bytes)?;
        let sections = Self::take_from(&mut decoder, END)?;
        let names: u32 = decoder.section(END)?;
        decoder.finish()?;
        if names != sections.checksum_of_names() {
            return Err(DecodeError::Wrong {
                section: END.to_owned(),
                reason: "the name of a section is damaged".to_owned(),
            });
        }
        Ok(sections)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_come_back_and_can_be_edited() {
        let mut encoder = Encoder::new();
        encoder.section("one", &7u64);
        encoder.section("two", &vec![1.0, 2.0]);
        encoder.section("three", &String::from("end"));
        let sections = encoder.into_sections();
        let back = Sections::decode(&sections.encode()).unwrap();
        assert_eq!(back, sections);
        assert_eq!(back.get::<Vec<f64>>("two"), Ok(vec![1.0, 2.0]));
        let edited = back
            .edited("two", |list: &mut Vec<f64>| list.push(-0.0))
            .unwrap();
        assert_ne!(edited, sections);
        assert_eq!(edited.get::<u64>("one"), Ok(7));
        assert_eq!(edited.get::<Vec<f64>>("two").map(|list| list.len()), Ok(3));
        for name in ["two", "four"] {
            let error = back.get::<u64>(name).unwrap_err().to_string();
            assert!(error.contains(name), "{error}");
        }
        // Those before the last one.
        let bytes = sections.encode();
        let mut decoder = Decoder::new(&bytes).unwrap();
        let first = Sections::take_from(&mut decoder, "three").unwrap();
        assert_eq!(first.iter().len(), 2);
        assert_eq!(decoder.section::<String>("three").as_deref(), Ok("end"));
    }
}
