//! The schema message: fields with their types, and metadata.
//!
//! Tables and their slots: Apache Arrow, `format/Schema.fbs` and `format/Message.fbs`.

use flatbuffers::{FlatBufferBuilder, TableFinishedWIPOffset, WIPOffset};

use super::flat::{Damaged, Flat, Table};

/// Metadata version 5 of Arrow 1.0 and later.
pub(super) const VERSION: i16 = 4;

/// Kinds of messages.
pub(super) const SCHEMA: u8 = 1;
pub(super) const RECORD_BATCH: u8 = 3;

/// Slots of a message.
pub(super) mod message {
    pub(in super::super) const VERSION: usize = 0;
    pub(in super::super) const KIND: usize = 1;
    pub(in super::super) const HEADER: usize = 2;
    pub(in super::super) const BODY_LENGTH: usize = 3;
    pub(in super::super) const METADATA: usize = 4;
}

/// Slots of a schema.
mod columns {
    pub(super) const ENDIANNESS: usize = 0;
    pub(super) const FIELDS: usize = 1;
    pub(super) const METADATA: usize = 2;
}

/// Slots of a field.
mod field {
    pub(super) const NAME: usize = 0;
    pub(super) const NULLABLE: usize = 1;
    pub(super) const TYPE_ID: usize = 2;
    pub(super) const TYPE: usize = 3;
    pub(super) const DICTIONARY: usize = 4;
    pub(super) const CHILDREN: usize = 5;
    pub(super) const METADATA: usize = 6;
}

/// What the byte before a field's type may say, by its number.
const TYPE_NAMES: [&str; 27] = [
    "none",
    "null",
    "int",
    "float",
    "binary",
    "utf8",
    "bool",
    "decimal",
    "date",
    "time",
    "timestamp",
    "interval",
    "list",
    "struct",
    "union",
    "fixed-size binary",
    "fixed-size list",
    "map",
    "duration",
    "large binary",
    "large utf8",
    "large list",
    "run-end encoded",
    "binary view",
    "utf8 view",
    "list view",
    "large list view",
];
const INT: u8 = 2;
const FLOAT: u8 = 3;
const UTF8: u8 = 5;

/// The precision of 64-bit floats.
const DOUBLE: i16 = 2;

/// A type that columns of frames can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::frames) enum FieldType {
    /// Whole numbers of so many bits.
    Int { bits: i32, signed: bool },
    /// 64-bit float.
    Double,
    /// Text with 32-bit offsets.
    Utf8,
}

/// A column as Arrow sees it. `T`: [`FieldType`], or for a field that was read possibly the name of a type that is none of these.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::frames) struct Field<T> {
    pub(in crate::frames) name: String,
    pub(in crate::frames) kind: T,
    pub(in crate::frames) nullable: bool,
    pub(in crate::frames) metadata: Metadata,
}

/// Keys and values, in the order of the file.
pub(in crate::frames) type Metadata = Vec<(String, String)>;

/// All columns of a file, and its metadata.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::frames) struct ArrowSchema<T> {
    pub(in crate::frames) fields: Vec<Field<T>>,
    pub(in crate::frames) metadata: Metadata,
}

/// A table that was written.
pub(super) type Written = WIPOffset<TableFinishedWIPOffset>;

/// The offset in a vtable that belongs to a slot.
pub(super) fn entry(slot: usize) -> u16 {
    4 + 2 * slot as u16
}

/// Writes a vector of tables; an offset of any kind is the same four bytes.
fn put_tables(builder: &mut FlatBufferBuilder<'_>, tables: &[Written]) -> Written {
    WIPOffset::new(builder.create_vector(tables).value())
}

/// Keys and values as a vector of tables.
pub(super) fn put_metadata<'t>(
    builder: &mut FlatBufferBuilder<'_>,
    metadata: impl IntoIterator<Item = (&'t str, &'t str)>,
) -> Written {
    let entries: Vec<Written> = metadata
        .into_iter()
        .map(|(key, value)| {
            let key = builder.create_string(key);
            let value = builder.create_string(value);
            let table = builder.start_table();
            builder.push_slot_always(entry(0), key);
            builder.push_slot_always(entry(1), value);
            builder.end_table(table)
        })
        .collect();
    put_tables(builder, &entries)
}

/// The same of metadata in memory, `None` if there are none.
fn put_entries(builder: &mut FlatBufferBuilder<'_>, metadata: &Metadata) -> Option<Written> {
    let entries = metadata.iter().map(|(key, value)| (&key[..], &value[..]));
    (!metadata.is_empty()).then(|| put_metadata(builder, entries))
}

/// Keys and values in a slot.
pub(super) fn metadata_of(table: &Table<'_>, slot: usize) -> Result<Metadata, Damaged> {
    let text = |entry: &Table<'_>, slot| Ok(entry.text(slot)?.unwrap_or_default().to_owned());
    let entries = table.tables(slot)?;
    let entries = entries
        .iter()
        .map(|entry| Ok((text(entry, 0)?, text(entry, 1)?)));
    entries.collect()
}

impl Field<FieldType> {
    fn put(&self, builder: &mut FlatBufferBuilder<'_>) -> Written {
        let metadata = put_entries(builder, &self.metadata);
        let name = builder.create_string(&self.name);
        // Some readers expect an empty list of children, not none.
        let (id, kind, children) = match self.kind {
            FieldType::Int { bits, signed } => {
                let children = put_tables(builder, &[]);
                let table = builder.start_table();
                builder.push_slot(entry(1), signed, false);
                builder.push_slot(entry(0), bits, 0);
                (INT, builder.end_table(table), children)
            }
            FieldType::Double => {
                let children = put_tables(builder, &[]);
                let table = builder.start_table();
                builder.push_slot(entry(0), DOUBLE, 0);
                (FLOAT, builder.end_table(table), children)
            }
            FieldType::Utf8 => {
                let table = builder.start_table();
                let kind = builder.end_table(table);
                (UTF8, kind, put_tables(builder, &[]))
            }
        };
        let table = builder.start_table();
        builder.push_slot_always(entry(field::NAME), name);
        builder.push_slot(entry(field::TYPE_ID), id, 0);
        builder.push_slot(entry(field::NULLABLE), self.nullable, false);
        builder.push_slot_always(entry(field::CHILDREN), children);
        builder.push_slot_always(entry(field::TYPE), kind);
        if let Some(metadata) = metadata {
            builder.push_slot_always(entry(field::METADATA), metadata);
        }
        builder.end_table(table)
    }
}

/// The type of a field, or the name of one that is no [`FieldType`].
fn type_of(field: &Table<'_>) -> Result<Result<FieldType, String>, Damaged> {
    if field.table(field::DICTIONARY)?.is_some() {
        return Ok(Err("dictionary".to_owned()));
    }
    let id = field.byte(field::TYPE_ID)?;
    let kind = field.table(field::TYPE)?.ok_or(Damaged)?;
    Ok(match id {
        INT => Ok(FieldType::Int {
            bits: kind.int(0)?,
            signed: kind.byte(1)? != 0,
        }),
        FLOAT => match kind.short(0)? {
            DOUBLE => Ok(FieldType::Double),
            0 => Err("float16".to_owned()),
            _ => Err("float32".to_owned()),
        },
        UTF8 => Ok(FieldType::Utf8),
        _ => Err(match TYPE_NAMES.get(usize::from(id)) {
            Some(name) => (*name).to_owned(),
            None => format!("number {id}"),
        }),
    })
}

impl ArrowSchema<FieldType> {
    /// The flatbuffer of the schema message.
    pub(super) fn encode(&self) -> Vec<u8> {
        let mut builder = FlatBufferBuilder::new();
        let fields: Vec<Written> = self
            .fields
            .iter()
            .map(|field| field.put(&mut builder))
            .collect();
        let fields = put_tables(&mut builder, &fields);
        let metadata = put_entries(&mut builder, &self.metadata);
        let table = builder.start_table();
        builder.push_slot_always(entry(columns::FIELDS), fields);
        if let Some(metadata) = metadata {
            builder.push_slot_always(entry(columns::METADATA), metadata);
        }
        let schema = builder.end_table(table);
        let table = builder.start_table();
        builder.push_slot(entry(message::VERSION), VERSION, 0);
        builder.push_slot(entry(message::KIND), SCHEMA, 0);
        builder.push_slot_always(entry(message::HEADER), schema);
        let message = builder.end_table(table);
        builder.finish(message, None);
        builder.finished_data().to_vec()
    }
}

impl ArrowSchema<Result<FieldType, String>> {
    /// The schema of the first message of a stream; the error says what was found.
    pub(super) fn decode(flatbuffer: &[u8]) -> Result<Self, String> {
        let flat = Flat::new(flatbuffer);
        let no_message = |Damaged| "no Arrow message".to_owned();
        let root = flat.root().map_err(no_message)?;
        if root.byte(message::KIND).map_err(no_message)? != SCHEMA {
            return Err("a first message that is no schema".to_owned());
        }
        if root.long(message::BODY_LENGTH).map_err(no_message)? != 0 {
            return Err("a schema message with a body".to_owned());
        }
        let schema = root.table(message::HEADER).map_err(no_message)?;
        let schema = schema.ok_or("a schema message without a schema")?;
        if schema.short(columns::ENDIANNESS).map_err(no_message)? != 0 {
            return Err("big-endian numbers".to_owned());
        }
        let read = || -> Result<Self, Damaged> {
            let mut fields = Vec::new();
            for field in schema.tables(columns::FIELDS)? {
                fields.push(Field {
                    name: field.text(field::NAME)?.unwrap_or_default().to_owned(),
                    kind: type_of(&field)?,
                    nullable: field.byte(field::NULLABLE)? != 0,
                    metadata: metadata_of(&field, field::METADATA)?,
                });
            }
            let metadata = metadata_of(&schema, columns::METADATA)?;
            Ok(Self { fields, metadata })
        };
        read().map_err(|Damaged| "a damaged schema".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use arrow_ipc::writer::StreamWriter;
    use arrow_schema::{DataType, Field as TheirField, Schema};
    use proptest::prelude::*;

    use super::*;
    use crate::frames::message::{CONTINUATION, END_OF_STREAM, parse_schema};

    fn int(bits: i32, signed: bool) -> FieldType {
        FieldType::Int { bits, signed }
    }

    /// Every type that a column can have, and what `arrow-schema` calls it.
    fn types() -> [(FieldType, DataType); 6] {
        [
            (FieldType::Double, DataType::Float64),
            (FieldType::Utf8, DataType::Utf8),
            (int(32, true), DataType::Int32),
            (int(8, false), DataType::UInt8),
            (int(32, false), DataType::UInt32),
            (int(64, false), DataType::UInt64),
        ]
    }

    fn theirs(schema: Schema) -> Vec<u8> {
        let writer = StreamWriter::try_new(Vec::new(), &schema).unwrap();
        writer.into_inner().unwrap()
    }

    /// The flatbuffer of the only message of a file.
    fn flatbuffer(file: &[u8]) -> &[u8] {
        &file[CONTINUATION.len() + 4..file.len() - END_OF_STREAM.len()]
    }

    fn entries() -> impl Strategy<Value = Metadata> {
        // In the order of keys, which is arrow-schema's.
        prop::collection::btree_map("[a-zµ_]{1,9}", "\\PC{0,20}", 0..4)
            .prop_map(|entries| entries.into_iter().collect())
    }

    proptest! {
        #[test]
        fn the_crate_arrow_ipc_writes_the_same_bytes(
            columns in prop::collection::vec(("\\PC{0,12}", 0usize..6, any::<bool>(), entries()), 0..9),
            metadata in entries(),
        ) {
            let mut own = ArrowSchema { fields: Vec::new(), metadata: metadata.clone() };
            let mut fields = Vec::new();
            for (name, k, nullable, metadata) in columns {
                let (kind, their_kind) = types()[k].clone();
                let field = TheirField::new(name.clone(), their_kind, nullable);
                fields.push(field.with_metadata(metadata.clone().into_iter().collect::<arrow_schema::Metadata>()));
                own.fields.push(Field { name, kind, nullable, metadata });
            }
            let schema = Schema::new_with_metadata(fields, metadata.into_iter().collect::<arrow_schema::Metadata>());
            let file = theirs(schema);
            let encoded = own.encode();
            prop_assert_eq!(&encoded[..], &flatbuffer(&file)[..encoded.len()]);
            let read = parse_schema(flatbuffer(&file)).unwrap();
            prop_assert_eq!(read.metadata, own.metadata);
            for (read, own) in read.fields.into_iter().zip(own.fields) {
                prop_assert_eq!(read.kind, Ok(own.kind));
                prop_assert_eq!(read.name, own.name);
                prop_assert_eq!(read.nullable, own.nullable);
                prop_assert_eq!(read.metadata, own.metadata);
            }
        }
    }

    #[test]
    fn other_types_have_their_names() {
        let others = [
            (DataType::Float32, "float32"),
            (DataType::Float16, "float16"),
            (DataType::Boolean, "bool"),
            (DataType::LargeUtf8, "large utf8"),
            (DataType::Utf8View, "utf8 view"),
            (DataType::Date32, "date"),
            (DataType::Null, "null"),
            (
                DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8)),
                "dictionary",
            ),
        ];
        for (kind, name) in others {
            let file = theirs(Schema::new(vec![TheirField::new("x", kind, true)]));
            let read = parse_schema(flatbuffer(&file)).unwrap();
            assert_eq!(read.fields[0].kind, Err(name.to_owned()));
        }
    }
}
