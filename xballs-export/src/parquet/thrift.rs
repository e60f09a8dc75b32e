//! Structures in Thrift's compact protocol: each field is a byte of step and type, then the value.

pub(super) const I32: u8 = 5;
const I64: u8 = 6;
pub(super) const BINARY: u8 = 8;
const LIST: u8 = 9;
pub(super) const STRUCT: u8 = 12;

/// A structure; fields must come in ascending order, at most 15 apart.
#[derive(Debug, Default)]
pub(super) struct Struct {
    fields: Vec<u8>,
    last: u8,
}

impl Struct {
    fn field(&mut self, id: u8, kind: u8) {
        self.fields.push((id - self.last) << 4 | kind);
        self.last = id;
    }

    pub(super) fn i32(&mut self, id: u8, value: i32) {
        self.field(id, I32);
        self.fields.extend(i32_bytes(value));
    }

    pub(super) fn i64(&mut self, id: u8, value: i64) {
        self.field(id, I64);
        push_varint(zigzag(value), &mut self.fields);
    }

    pub(super) fn text(&mut self, id: u8, text: &str) {
        self.field(id, BINARY);
        self.fields.extend(text_bytes(text));
    }

    pub(super) fn structure(&mut self, id: u8, inner: &Self) {
        self.field(id, STRUCT);
        inner.write(&mut self.fields);
    }

    /// A list of encoded elements of one type.
    pub(super) fn list(&mut self, id: u8, kind: u8, elements: Vec<Vec<u8>>) {
        self.field(id, LIST);
        match elements.len() {
            short @ ..15 => self.fields.push((short as u8) << 4 | kind),
            long => {
                self.fields.push(0xF0 | kind);
                push_varint(long as u64, &mut self.fields);
            }
        }
        self.fields.extend(elements.into_iter().flatten());
    }

    pub(super) fn write(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.fields);
        out.push(0);
    }

    pub(super) fn bytes(&self) -> Vec<u8> {
        let mut out = Vec::new();
        self.write(&mut out);
        out
    }
}

fn zigzag(value: i64) -> u64 {
    (value << 1 ^ value >> 63) as u64
}

pub(super) fn i32_bytes(value: i32) -> Vec<u8> {
    let mut out = Vec::new();
    push_varint(zigzag(value.into()), &mut out);
    out
}

pub(super) fn text_bytes(text: &str) -> Vec<u8> {
    let mut out = Vec::new();
    push_varint(text.len() as u64, &mut out);
    out.extend_from_slice(text.as_bytes());
    out
}

/// Seven bits per byte, the low ones first.
pub(super) fn push_varint(mut value: u64, out: &mut Vec<u8>) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_specification() {
        for (value, bytes) in [
            (0, vec![0]),
            (-1, vec![1]),
            (1, vec![2]),
            (63, vec![126]),
            (64, vec![0x80, 1]),
            (-65, vec![0x81, 1]),
        ] {
            assert_eq!(i32_bytes(value), bytes, "{value}");
        }
        let mut outer = Struct::default();
        outer.i32(2, 1);
        outer.text(5, "ab");
        assert_eq!(outer.bytes(), [0x25, 2, 0x38, 2, b'a', b'b', 0]);
    }

    #[test]
    fn lists_of_fifteen_and_more_have_a_length_of_their_own() {
        let list = |count: usize| {
            let mut outer = Struct::default();
            outer.list(1, I32, vec![vec![0]; count]);
            outer.bytes()
        };
        assert_eq!(list(14)[..2], [0x19, 0xE5]);
        assert_eq!(list(15)[..3], [0x19, 0xF5, 15]);
    }
}
