//! Reads tables back with a small reader of its own, written from the specification.

use std::collections::BTreeMap;

use super::*;

/// A value of Thrift's compact protocol.
#[derive(Debug, Clone, PartialEq)]
enum Value {
    Integer(i64),
    Text(Vec<u8>),
    List(Vec<Value>),
    Struct(BTreeMap<u8, Value>),
}

impl Value {
    fn get(&self, id: u8) -> &Self {
        match self {
            Self::Struct(fields) => &fields[&id],
            other => panic!("{other:?}"),
        }
    }

    fn integer(&self) -> i64 {
        match self {
            Self::Integer(value) => *value,
            other => panic!("{other:?}"),
        }
    }

    fn list(&self) -> &[Self] {
        match self {
            Self::List(values) => values,
            other => panic!("{other:?}"),
        }
    }

    fn text(&self) -> String {
        match self {
            Self::Text(bytes) => String::from_utf8(bytes.clone()).unwrap(),
            other => panic!("{other:?}"),
        }
    }
}

struct Cursor<'a> {
    bytes: &'a [u8],
    place: usize,
}

impl Cursor<'_> {
    fn byte(&mut self) -> u8 {
        self.place += 1;
        self.bytes[self.place - 1]
    }

    fn varint(&mut self) -> u64 {
        let (mut value, mut shift) = (0, 0);
        loop {
            let byte = self.byte();
            value |= u64::from(byte & 0x7F) << shift;
            shift += 7;
            if byte < 0x80 {
                return value;
            }
        }
    }

    fn value(&mut self, kind: u8) -> Value {
        match kind {
            5 | 6 => {
                let value = self.varint();
                Value::Integer((value >> 1) as i64 ^ -((value & 1) as i64))
            }
            8 => {
                let length = self.varint() as usize;
                self.place += length;
                Value::Text(self.bytes[self.place - length..self.place].to_vec())
            }
            9 => {
                let head = self.byte();
                let count = match head >> 4 {
                    15 => self.varint(),
                    short => short.into(),
                };
                Value::List((0..count).map(|_| self.value(head & 15)).collect())
            }
            12 => {
                let (mut fields, mut id) = (BTreeMap::new(), 0);
                loop {
                    match self.byte() {
                        0 => return Value::Struct(fields),
                        head => {
                            id += head >> 4;
                            fields.insert(id, self.value(head & 15));
                        }
                    }
                }
            }
            other => panic!("type {other}"),
        }
    }
}

/// The values of a column of numbers, nulls as `None`.
type Read = Vec<Option<Vec<u8>>>;

fn read(file: &[u8]) -> (Value, Vec<(String, Read)>) {
    assert_eq!(&file[..4], b"PAR1");
    assert_eq!(&file[file.len() - 4..], b"PAR1");
    let length = &file[file.len() - 8..file.len() - 4];
    let length = u32::from_le_bytes(length.try_into().unwrap()) as usize;
    let footer = &file[file.len() - 8 - length..];
    let footer = Cursor {
        bytes: footer,
        place: 0,
    }
    .value(12);
    let schema = &footer.get(2).list()[1..];
    let mut columns: Vec<(String, Read)> = schema
        .iter()
        .map(|e| (e.get(4).text(), Vec::new()))
        .collect();
    for group in footer.get(4).list() {
        for ((chunk, element), (name, found)) in
            group.get(1).list().iter().zip(schema).zip(&mut columns)
        {
            let data = chunk.get(3);
            assert_eq!(data.get(3).list()[0].text(), *name);
            let begin = data.get(9).integer() as usize;
            let end = begin + data.get(7).integer() as usize;
            let mut cursor = Cursor {
                bytes: file,
                place: begin,
            };
            while cursor.place < end {
                read_page(&mut cursor, element, found);
            }
            assert_eq!(cursor.place, end);
        }
    }
    (footer, columns)
}

fn read_page(cursor: &mut Cursor, element: &Value, found: &mut Read) {
    let header = cursor.value(12);
    let count = header.get(5).get(1).integer() as usize;
    let end = cursor.place + header.get(3).integer() as usize;
    let mut there = vec![true; count];
    if element.get(3).integer() == 1 {
        let stop = cursor.place + 4;
        let length = u32::from_le_bytes(cursor.bytes[cursor.place..stop].try_into().unwrap());
        cursor.place = stop;
        let stop = stop + length as usize;
        there.clear();
        while cursor.place < stop {
            let run = cursor.varint() as usize;
            assert_eq!(run & 1, 0, "a run, not packed bits");
            let value = cursor.byte() == 1;
            there.extend(std::iter::repeat_n(value, run >> 1));
        }
    }
    assert_eq!(there.len(), count);
    for is_there in there {
        let size = match element.get(1).integer() {
            1 => 4,
            2 | 5 => 8,
            _ => {
                let bytes = cursor.bytes[cursor.place..cursor.place + 4]
                    .try_into()
                    .unwrap();
                cursor.place += 4;
                u32::from_le_bytes(bytes) as usize
            }
        };
        found.push(is_there.then(|| {
            cursor.place += size;
            cursor.bytes[cursor.place - size..cursor.place].to_vec()
        }));
    }
    assert_eq!(cursor.place, end);
}

#[test]
fn every_kind_reads_back() {
    let kinds = [
        ColumnKind::F64,
        ColumnKind::I32,
        ColumnKind::U8,
        ColumnKind::U32,
        ColumnKind::OptionalU32,
        ColumnKind::U64,
        ColumnKind::Text,
    ];
    let specs: Vec<ColumnSpec> = kinds
        .iter()
        .enumerate()
        .map(|(k, &kind)| ColumnSpec::new(format!("c{k}"), kind, "m"))
        .collect();
    let rows = |n: u32| {
        let each = move || 0..n;
        vec![
            Column::F64(each().map(|k| f64::from(k) / 3.0).collect()),
            Column::I32(each().map(|k| -(k as i32)).collect()),
            Column::U8(each().map(|k| k as u8).collect()),
            Column::U32(each().map(|k| u32::MAX - k).collect()),
            Column::OptionalU32(each().map(|k| (k % 3 > 0).then_some(k)).collect()),
            Column::U64(each().map(|k| u64::MAX - u64::from(k)).collect()),
            Column::Text(each().map(|k| "é".repeat(k as usize % 4)).collect()),
        ]
    };
    let mut file = Vec::new();
    let mut writer = ParquetWriter::new(specs, &mut file);
    for count in [5, 0, 3] {
        writer.push(&rows(count), &mut file).unwrap();
    }
    let wrong = writer.push(&rows(1)[1..], &mut file).unwrap_err();
    assert_eq!(wrong, "other columns than in the frames before");
    writer.finish(&mut file);
    let (footer, columns) = read(&file);
    assert_eq!(footer.get(3).integer(), 8);
    assert_eq!(
        footer.get(4).list().len(),
        2,
        "a frame without rows leaves no trace"
    );
    assert_eq!(footer.get(5).list()[0].get(1).text(), "unit.c0");
    let both: Vec<u32> = (0..5).chain(0..3).collect();
    let expect = |k: usize, bytes: &dyn Fn(u32) -> Option<Vec<u8>>| {
        let expected: Read = both.iter().map(|&row| bytes(row)).collect();
        assert_eq!(columns[k], (format!("c{k}"), expected));
    };
    expect(0, &|k| Some((f64::from(k) / 3.0).to_le_bytes().into()));
    expect(1, &|k| Some((-(k as i32)).to_le_bytes().into()));
    expect(2, &|k| Some(k.to_le_bytes().into()));
    expect(3, &|k| Some((u32::MAX - k).to_le_bytes().into()));
    expect(4, &|k| (k % 3 > 0).then(|| k.to_le_bytes().into()));
    expect(5, &|k| Some((u64::MAX - u64::from(k)).to_le_bytes().into()));
    expect(6, &|k| Some("é".repeat(k as usize % 4).into_bytes()));
}

#[test]
fn long_columns_are_cut_into_pages() {
    let count = PAGE_ROWS + 10;
    let mut file = Vec::new();
    let specs = vec![ColumnSpec::new("k", ColumnKind::U8, "1")];
    let mut writer = ParquetWriter::new(specs, &mut file);
    let values: Vec<u8> = (0..count).map(|k| k as u8).collect();
    writer.push(&[Column::U8(values)], &mut file).unwrap();
    writer.finish(&mut file);
    let (_, columns) = read(&file);
    let found = &columns[0].1;
    assert_eq!(found.len(), count);
    assert!(
        found
            .iter()
            .enumerate()
            .all(|(k, v)| v.as_ref().is_some_and(|v| v[0] == k as u8))
    );
}
