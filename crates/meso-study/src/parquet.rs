//! Tables as Apache Parquet files, format version 1: one row group, plain encoding, no compression.
//!
//! Written by hand: the crate `parquet`, without any of its features, adds 25 crates and 40 CPU seconds to a build, for a
//! file of some kB. The metadata is Thrift's compact protocol (parquet.thrift of apache/parquet-format); pyarrow reads the
//! files back in the tests.

use crate::table::{Column, Table, Values};
use std::io::{self, Write};

const MAGIC: &[u8] = b"PAR1";

/// Thrift's compact codes of types.
const I32: u8 = 5;
const I64: u8 = 6;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const STRUCT: u8 = 12;

/// Encodings of values, and of which of them are there.
const PLAIN: i64 = 0;
const RLE: i64 = 3;
const OPTIONAL: i64 = 1;
const UTF8: i64 = 0;

/// Writes `table` to `out`.
pub(crate) fn write(table: &Table, mut out: impl Write) -> io::Result<()> {
    out.write_all(MAGIC)?;
    let mut chunks = Vec::new();
    let mut offset = MAGIC.len();
    for column in &table.columns {
        let page = page(column);
        out.write_all(&page)?;
        chunks.push(Chunk { column, offset, bytes: page.len() });
        offset += page.len();
    }
    let footer = footer(table, &chunks);
    out.write_all(&footer)?;
    out.write_all(&(footer.len() as u32).to_le_bytes())?;
    out.write_all(MAGIC)
}

/// Where a column's page lies in the file.
struct Chunk<'a> {
    column: &'a Column,
    offset: usize,
    bytes: usize,
}

/// A column's only page: its header, which values are there, and these values.
fn page(column: &Column) -> Vec<u8> {
    let levels = levels(&present(&column.values));
    let mut data = (levels.len() as u32).to_le_bytes().to_vec();
    data.extend(levels);
    data.extend(plain(&column.values));
    let mut header = Thrift::default();
    header.number(1, I32, 0);
    header.number(2, I32, data.len() as i64);
    header.number(3, I32, data.len() as i64);
    header.structure(5, |page| {
        page.number(1, I32, column.values.len() as i64);
        page.number(2, I32, PLAIN);
        page.number(3, I32, RLE);
        page.number(4, I32, RLE);
    });
    let mut page = header.end();
    page.extend(data);
    page
}

fn present(values: &Values) -> Vec<bool> {
    match values {
        Values::Bool(values) => values.iter().map(Option::is_some).collect(),
        Values::Integer(values) => values.iter().map(Option::is_some).collect(),
        Values::Float(values) => values.iter().map(Option::is_some).collect(),
        Values::Text(values) => values.iter().map(Option::is_some).collect(),
    }
}

/// Runs of equal definition levels, one bit wide: 1 where there is a value.
fn levels(present: &[bool]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for run in present.chunk_by(|a, b| a == b) {
        varint(&mut bytes, (run.len() as u64) << 1);
        bytes.push(u8::from(run[0]));
    }
    bytes
}

/// The values that are there: little-endian, texts with their length, eight booleans a byte.
fn plain(values: &Values) -> Vec<u8> {
    match values {
        Values::Bool(values) => {
            let bits: Vec<bool> = values.iter().copied().flatten().collect();
            let byte = |bits: &[bool]| bits.iter().rev().fold(0, |byte, bit| byte << 1 | u8::from(*bit));
            bits.chunks(8).map(byte).collect()
        }
        Values::Integer(values) => values.iter().flatten().flat_map(|value| value.to_le_bytes()).collect(),
        Values::Float(values) => values.iter().flatten().flat_map(|value| value.to_le_bytes()).collect(),
        Values::Text(values) => {
            let bytes = |text: &String| [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
            values.iter().flatten().flat_map(bytes).collect()
        }
    }
}

/// Parquet's physical type.
fn kind(values: &Values) -> i64 {
    match values {
        Values::Bool(_) => 0,
        Values::Integer(_) => 2,
        Values::Float(_) => 5,
        Values::Text(_) => 6,
    }
}

/// `FileMetaData`.
fn footer(table: &Table, chunks: &[Chunk]) -> Vec<u8> {
    let mut meta = Thrift::default();
    meta.number(1, I32, 1);
    let root = |element: &mut Thrift| {
        element.text(4, "study");
        element.number(5, I32, table.columns.len() as i64);
    };
    let columns = table.columns.iter().map(|column| move |element: &mut Thrift| schema(element, column));
    #[allow(clippy::type_complexity, reason = "the closures borrow from here")]
    let mut elements: Vec<Box<dyn FnOnce(&mut Thrift) + '_>> = vec![Box::new(root)];
    elements.extend(columns.map(|write| Box::new(write) as Box<dyn FnOnce(&mut Thrift)>));
    meta.structures(2, elements);
    meta.number(3, I64, table.rows() as i64);
    meta.structures(4, [|group: &mut Thrift| row_group(group, table, chunks)]);
    meta.text(6, concat!("mesocrete ", env!("CARGO_PKG_VERSION")));
    meta.end()
}

/// `SchemaElement` of a column.
fn schema(element: &mut Thrift, column: &Column) {
    element.number(1, I32, kind(&column.values));
    element.number(3, I32, OPTIONAL);
    element.text(4, &column.name);
    if matches!(column.values, Values::Text(_)) {
        element.number(6, I32, UTF8);
        element.structure(10, |logical| logical.structure(1, |_| {}));
    }
}

fn row_group(group: &mut Thrift, table: &Table, chunks: &[Chunk]) {
    let columns = chunks.iter().map(|chunk| {
        move |element: &mut Thrift| {
            element.number(2, I64, chunk.offset as i64);
            element.structure(3, |meta| column_meta(meta, chunk));
        }
    });
    group.structures(1, columns.collect::<Vec<_>>());
    group.number(2, I64, chunks.iter().map(|chunk| chunk.bytes as i64).sum());
    group.number(3, I64, table.rows() as i64);
}

/// `ColumnMetaData`.
fn column_meta(meta: &mut Thrift, chunk: &Chunk) {
    meta.number(1, I32, kind(&chunk.column.values));
    meta.list(2, I32, 2, |bytes| [PLAIN, RLE].into_iter().for_each(|encoding| zigzag(bytes, encoding)));
    meta.list(3, BINARY, 1, |bytes| text(bytes, &chunk.column.name));
    meta.number(4, I32, 0);
    meta.number(5, I64, chunk.column.values.len() as i64);
    meta.number(6, I64, chunk.bytes as i64);
    meta.number(7, I64, chunk.bytes as i64);
    meta.number(9, I64, chunk.offset as i64);
}

/// One struct of Thrift's compact protocol while it is written.
#[derive(Default)]
struct Thrift {
    bytes: Vec<u8>,
    /// Number of the last field; fields come in ascending order.
    last: u8,
}

impl Thrift {
    /// A field's header: how far its number is from the last one's (below 16, in what is written here), and its type.
    fn field(&mut self, number: u8, kind: u8) {
        self.bytes.push((number - self.last) << 4 | kind);
        self.last = number;
    }

    fn number(&mut self, number: u8, kind: u8, value: i64) {
        self.field(number, kind);
        zigzag(&mut self.bytes, value);
    }

    fn text(&mut self, number: u8, value: &str) {
        self.field(number, BINARY);
        text(&mut self.bytes, value);
    }

    fn list(&mut self, number: u8, kind: u8, length: usize, write: impl FnOnce(&mut Vec<u8>)) {
        self.field(number, LIST);
        match length {
            0..15 => self.bytes.push((length as u8) << 4 | kind),
            _ => {
                self.bytes.push(0xf0 | kind);
                varint(&mut self.bytes, length as u64);
            }
        }
        write(&mut self.bytes);
    }

    fn structure(&mut self, number: u8, write: impl FnOnce(&mut Self)) {
        self.field(number, STRUCT);
        self.bytes.extend(Self::of(write));
    }

    fn structures<F: FnOnce(&mut Self)>(&mut self, number: u8, all: impl IntoIterator<Item = F>) {
        let all: Vec<Vec<u8>> = all.into_iter().map(Self::of).collect();
        self.list(number, STRUCT, all.len(), |bytes| bytes.extend(all.concat()));
    }

    fn of(write: impl FnOnce(&mut Self)) -> Vec<u8> {
        let mut inner = Self::default();
        write(&mut inner);
        inner.end()
    }

    /// The struct with its stop.
    fn end(mut self) -> Vec<u8> {
        self.bytes.push(0);
        self.bytes
    }
}

fn text(bytes: &mut Vec<u8>, text: &str) {
    varint(bytes, text.len() as u64);
    bytes.extend_from_slice(text.as_bytes());
}

fn zigzag(bytes: &mut Vec<u8>, value: i64) {
    varint(bytes, (value << 1 ^ value >> 63) as u64);
}

/// Seven bits a byte, the lowest first.
fn varint(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}
