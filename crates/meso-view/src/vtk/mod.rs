//! The frame of every `.vtu` and `.vtp`: arrays declared first, then their bytes appended, raw or compressed.
//!
//! Little-endian, sizes counted in 64 bits. VTK, PyVista and meshio all read appended data; meshio wants the offsets
//! unpadded and in the order of the arrays, and one line break after the last. Raw arrays are streamed; compressed
//! ones are built before the first byte is written, because the declarations state where each begins.

pub mod mesh;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use meso_concrete::parallel;
use std::io::{self, BufWriter, Write};

/// How the arrays' bytes are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// As they are.
    #[default]
    Raw,
    /// By zlib, in blocks.
    Compressed,
}

impl Encoding {
    /// Compressed if `yes`, else raw.
    pub fn compressed(yes: bool) -> Self {
        if yes { Self::Compressed } else { Self::Raw }
    }
}

/// Level of zlib of a file, and of those of a series: a test waits for its frames.
const LEVELS: [u32; 2] = [4, 1];
/// Bytes that are compressed at a time.
const BLOCK: usize = 1 << 20;
/// Bytes that go out at a time.
const CHUNK: usize = 1 << 16;

/// The compressed bytes of arrays that are alike in all files of a series, once its first file is written.
#[derive(Clone, Debug, Default)]
pub struct Still(Vec<Vec<u8>>);

/// Writes the bytes of an array.
type Fill<'a> = Box<dyn Fn(&mut dyn Write) -> io::Result<()> + 'a>;

/// A declared array of a VTK file.
pub struct Array<'a> {
    kind: &'static str,
    name: &'a str,
    components: usize,
    bytes: usize,
    fill: Fill<'a>,
    /// Whether it is the same in all files of a series.
    is_still: bool,
}

impl<'a> Array<'a> {
    /// An array of `values()`, which are `count` in number and of VTK's type `kind`.
    pub fn new<const N: usize, I: Iterator<Item = [u8; N]>>(
        kind: &'static str,
        name: &'a str,
        count: usize,
        values: impl Fn() -> I + 'a,
    ) -> Self {
        let fill = move |out: &mut dyn Write| {
            let mut chunk = Vec::with_capacity(CHUNK + N);
            for value in values() {
                chunk.extend_from_slice(&value);
                if chunk.len() >= CHUNK {
                    out.write_all(&chunk)?;
                    chunk.clear();
                }
            }
            out.write_all(&chunk)
        };
        Self { kind, name, components: 1, bytes: N * count, fill: Box::new(fill), is_still: false }
    }

    /// Says that it is the same in all files of a series.
    pub fn still(self) -> Self {
        Self { is_still: true, ..self }
    }

    /// Groups the values into vectors of three.
    pub fn of_vectors(self) -> Self {
        self.in_groups_of(3)
    }

    /// Groups the values, `components` for each point or cell.
    pub fn in_groups_of(self, components: usize) -> Self {
        Self { components, ..self }
    }

    fn raw(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(&(self.bytes as u64).to_le_bytes())?;
        (self.fill)(out)
    }

    /// Number of blocks, size of a block, size of the last where it is not whole, sizes when compressed; the blocks.
    fn compressed(&self, level: u32) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::with_capacity(self.bytes);
        (self.fill)(&mut bytes)?;
        let blocks: Vec<&[u8]> = bytes.chunks(BLOCK).collect();
        let blocks = parallel::try_map(blocks.len(), |i| deflate(blocks[i], level))?;
        let head = [blocks.len(), BLOCK, bytes.len() % BLOCK];
        let sizes = head.into_iter().chain(blocks.iter().map(Vec::len));
        let mut out: Vec<u8> = sizes.flat_map(|size| (size as u64).to_le_bytes()).collect();
        blocks.iter().for_each(|block| out.extend_from_slice(block));
        Ok(out)
    }
}

/// Ends the file.
fn end(out: &mut impl Write) -> io::Result<()> {
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")?;
    out.flush()
}

fn deflate(block: &[u8], level: u32) -> io::Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(level));
    encoder.write_all(block)?;
    encoder.finish()
}

/// How cells are declared.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Cells of any type: an unstructured grid.
    Cells,
    /// Polygons, which need no types: poly data.
    Polygons,
}

/// An unstructured grid, or poly data.
pub struct Grid<'a> {
    /// Cells, or poly data.
    pub layout: Layout,
    /// Number of points of the grid.
    pub points: usize,
    /// Number of cells of the grid.
    pub cells: usize,
    /// Positions of the points.
    pub positions: Array<'a>,
    /// Connectivity, offsets and types; poly data leave out the last.
    pub topology: [Array<'a>; 3],
    /// Values at the points.
    pub point_data: Vec<Array<'a>>,
    /// A viewer shows the first.
    pub cell_data: Vec<Array<'a>>,
}

impl Grid<'_> {
    /// Writes the whole file.
    pub fn write(&self, encoding: Encoding, mut out: impl Write) -> io::Result<()> {
        self.write_to(encoding, &mut out)
    }

    /// Writes the whole file; compiled once, here.
    fn write_to(&self, encoding: Encoding, out: &mut dyn Write) -> io::Result<()> {
        let mut out = BufWriter::with_capacity(CHUNK, out);
        match encoding {
            Encoding::Raw => {
                let sizes: Vec<usize> = self.arrays().map(|array| 8 + array.bytes).collect();
                self.declare(&sizes, "", &mut out)?;
                self.arrays().try_for_each(|array| array.raw(&mut out))?;
            }
            Encoding::Compressed => self.compressed(LEVELS[0], &mut Still::default(), &mut out)?,
        }
        end(&mut out)
    }

    /// Writes the next file of a series, compressed; `still` is empty before the first one.
    pub fn write_next(&self, still: &mut Still, mut out: impl Write) -> io::Result<()> {
        let mut out = BufWriter::with_capacity(CHUNK, &mut out as &mut dyn Write);
        self.compressed(LEVELS[1], still, &mut out)?;
        end(&mut out)
    }

    /// Everything but the end. Arrays that are still are compressed where `still` is empty.
    fn compressed(&self, level: u32, still: &mut Still, out: &mut impl Write) -> io::Result<()> {
        let of = |is_still| self.arrays().filter(move |array| array.is_still == is_still);
        let compress = |array: &Array| array.compressed(level);
        if still.0.is_empty() {
            still.0 = of(true).map(compress).collect::<io::Result<_>>()?;
        }
        let others = of(false).map(compress).collect::<io::Result<Vec<_>>>()?;
        let mut next = [others.iter(), still.0.iter()];
        let stored: Vec<_> = self.arrays().filter_map(|array| next[usize::from(array.is_still)].next()).collect();
        let sizes: Vec<usize> = stored.iter().map(|bytes| bytes.len()).collect();
        self.declare(&sizes, " compressor=\"vtkZLibDataCompressor\"", out)?;
        stored.into_iter().try_for_each(|bytes| out.write_all(bytes))
    }

    fn arrays(&self) -> impl Iterator<Item = &Array<'_>> {
        std::iter::once(&self.positions).chain(self.shown()).chain(&self.point_data).chain(&self.cell_data)
    }

    /// The arrays of topology that the layout has.
    fn shown(&self) -> &[Array<'_>] {
        if self.layout == Layout::Cells { &self.topology } else { &self.topology[..2] }
    }

    /// Everything before the first array's bytes; each array begins where the one before it ends.
    fn declare(&self, sizes: &[usize], compressor: &str, out: &mut impl Write) -> io::Result<()> {
        let mut offset = 0;
        let mut declared = self.arrays().zip(sizes).map(|(array, size)| {
            let Array { kind, name, components, .. } = array;
            let line = format!(
                "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" \
                 offset=\"{offset}\"/>\n"
            );
            offset += size;
            line
        });
        let mut lines = |count: usize| declared.by_ref().take(count).collect::<String>();
        let (kind, count, cells) = match self.layout {
            Layout::Cells => ("UnstructuredGrid", "NumberOfCells", "Cells"),
            Layout::Polygons => ("PolyData", "NumberOfPolys", "Polys"),
        };
        writeln!(out, "<?xml version=\"1.0\"?>")?;
        write!(out, "<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" ")?;
        writeln!(out, "header_type=\"UInt64\"{compressor}>\n<{kind}>")?;
        writeln!(out, "<Piece NumberOfPoints=\"{}\" {count}=\"{}\">", self.points, self.cells)?;
        write!(out, "<Points>\n{}</Points>\n<{cells}>\n{}</{cells}>\n", lines(1), lines(self.shown().len()))?;
        if !self.point_data.is_empty() {
            write!(out, "<PointData>\n{}</PointData>\n", lines(self.point_data.len()))?;
        }
        write!(out, "<CellData Scalars=\"{}\">\n{}", self.cell_data[0].name, lines(self.cell_data.len()))?;
        write!(out, "</CellData>\n</Piece>\n</{kind}>\n<AppendedData encoding=\"raw\">\n_")
    }
}
