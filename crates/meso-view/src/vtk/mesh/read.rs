//! Reads back the grids of a series that [`write_fields`](super::write_fields) wrote, and no others.
//!
//! The declarations are those of our own writer, word for word. Each block ends with zlib's checksum, so changed values are found.

use flate2::read::ZlibDecoder;
use std::io::Read;

/// Why a grid cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unread {
    /// Another program wrote it, or it was changed.
    #[error("it is no grid of mesocrete's own, or was written anew by another program")]
    Foreign,
    /// An array that it lacks.
    #[error("it has no array {0}")]
    Missing(&'static str),
    /// An array whose values end early, or are others than those written.
    #[error("the array {0} is damaged")]
    Damaged(&'static str),
}

/// A declared array.
struct Declared<'a> {
    kind: &'a str,
    name: &'a str,
    components: usize,
    offset: usize,
}

/// A grid that was read as far as its declarations.
pub struct Stored<'a> {
    /// Number of points.
    pub points: usize,
    /// Number of cells.
    pub cells: usize,
    arrays: Vec<Declared<'a>>,
    data: &'a [u8],
}

const BEGIN: &str = "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
                     header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n<Piece ";
const DATA: &[u8] = b"<AppendedData encoding=\"raw\">\n_";

/// The value of an attribute in a line.
fn attribute<'a>(line: &'a str, name: &str) -> Option<&'a str> {
    line.split_once(&format!(" {name}=\""))?.1.split('"').next()
}

fn number(line: &str, name: &str) -> Option<usize> {
    attribute(line, name)?.parse().ok()
}

impl<'a> Stored<'a> {
    /// Reads the declarations.
    ///
    /// # Errors
    /// A file that is no such grid.
    pub fn of(bytes: &'a [u8]) -> Result<Self, Unread> {
        Self::declared(bytes).ok_or(Unread::Foreign)
    }

    fn declared(bytes: &'a [u8]) -> Option<Self> {
        let end = bytes.windows(DATA.len()).position(|window| window == DATA)?;
        let head = str::from_utf8(&bytes[..end]).ok()?;
        let piece = format!(" {}", head.strip_prefix(BEGIN)?.lines().next()?);
        let array = |line| {
            let (kind, name) = (attribute(line, "type")?, attribute(line, "Name")?);
            Some(Declared {
                kind,
                name,
                components: number(line, "NumberOfComponents")?,
                offset: number(line, "offset")?,
            })
        };
        Some(Self {
            points: number(&piece, "NumberOfPoints")?,
            cells: number(&piece, "NumberOfCells")?,
            arrays: head.lines().filter(|line| line.starts_with("<DataArray")).map(array).collect::<Option<_>>()?,
            data: &bytes[end + DATA.len()..],
        })
    }

    /// Whether it has an array of a name.
    pub fn has(&self, name: &str) -> bool {
        self.arrays.iter().any(|array| array.name == name)
    }

    /// The values of an array, `components` for each of `count` points or cells, of `N` bytes each.
    ///
    /// # Errors
    /// An array that is missing, damaged, or of another type or number.
    pub fn values<const N: usize, T>(
        &self,
        (kind, name): (&str, &'static str),
        [components, count]: [usize; 2],
        of: impl Fn([u8; N]) -> T,
    ) -> Result<Vec<T>, Unread> {
        let array = self.arrays.iter().find(|array| array.name == name).ok_or(Unread::Missing(name))?;
        let bytes = components.checked_mul(count).and_then(|values| values.checked_mul(N));
        let is_fit = array.kind == kind && array.components == components;
        let bytes = bytes.filter(|_| is_fit).and_then(|bytes| unpacked(self.data.get(array.offset..)?, bytes));
        let bytes = bytes.ok_or(Unread::Damaged(name))?;
        Ok(bytes.as_chunks::<N>().0.iter().map(|value| of(*value)).collect())
    }

    /// The finite numbers of an array of `Float32`.
    ///
    /// # Errors
    /// As [`Stored::values`], and numbers that are not finite.
    pub fn floats(&self, name: &'static str, size: [usize; 2]) -> Result<Vec<f32>, Unread> {
        let values = self.values(("Float32", name), size, f32::from_le_bytes)?;
        if values.iter().all(|value| value.is_finite()) { Ok(values) } else { Err(Unread::Damaged(name)) }
    }
}

/// The blocks after their lengths, if they have `wanted` bytes in all.
fn unpacked(data: &[u8], wanted: usize) -> Option<Vec<u8>> {
    let length = |number: usize| {
        let bytes = data.get(8 * number..8 * number + 8)?;
        usize::try_from(u64::from_le_bytes(bytes.try_into().ok()?)).ok()
    };
    let blocks = length(0)?;
    let mut rest = data.get(blocks.checked_add(3)?.checked_mul(8)?..)?;
    let mut all = Vec::new();
    all.try_reserve_exact(wanted).ok()?;
    for block in 0..blocks {
        let (packed, after) = rest.split_at_checked(length(3 + block)?)?;
        // The file's own sizes are not believed.
        ZlibDecoder::new(packed).take((wanted - all.len()) as u64 + 1).read_to_end(&mut all).ok()?;
        if all.len() > wanted {
            return None;
        }
        rest = after;
    }
    (all.len() == wanted).then_some(all)
}

#[cfg(test)]
mod tests {
    use super::super::{self as mesh, Field};
    use super::*;
    use crate::vtk::Still;
    use meso_mesh::{CellKind, Mesh, Phase};

    fn file(values: &[f32]) -> Vec<u8> {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Into::into).to_vec();
        let mesh = Mesh::of(CellKind::Tetrahedron, points, vec![0, 1, 2, 3], vec![Phase::Aggregate], vec![0]);
        let mut bytes = Vec::new();
        let field = Field { name: "damage", components: 1, values };
        mesh::write_fields(&mesh, &[], &[field], &mut Still::default(), &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn a_grid_reads_back_and_changed_or_foreign_ones_are_refused() {
        let bytes = file(&[0.25]);
        let (mesh, stored) = mesh::read(&bytes).unwrap();
        assert_eq!((mesh.points.len(), mesh.phase[0], mesh.owner[0]), (4, Phase::Aggregate, 0));
        assert_eq!(stored.floats("damage", [1, 1]), Ok(vec![0.25]));
        assert_eq!(stored.floats("stress", [1, 1]), Err(Unread::Missing("stress")));
        assert_eq!(stored.floats("damage", [1, 2]), Err(Unread::Damaged("damage")));
        let refused = |bytes: &[u8]| mesh::read(bytes).err();
        assert_eq!(refused(b"<?xml version=\"1.0\"?>"), Some(Unread::Foreign));
        let text = String::from_utf8_lossy(&bytes).replace("UInt64", "UInt32");
        assert_eq!(refused(text.as_bytes()), Some(Unread::Foreign));
        assert!(refused(&bytes[..bytes.len() - 60]).is_some(), "cut");
        assert!(mesh::read(&file(&[f32::NAN])).unwrap().1.floats("damage", [1, 1]).is_err());
        let begin = bytes.windows(DATA.len()).position(|window| window == DATA).unwrap() + DATA.len();
        // A changed byte of positions and topology is found by zlib's checksum or by what the mesh can be.
        let changed = |at: usize| {
            let mut bytes = bytes.clone();
            bytes[at] ^= 0x10;
            mesh::read(&bytes).is_err()
        };
        assert!(changed(begin + 40) && changed(begin + 60));
    }
}
