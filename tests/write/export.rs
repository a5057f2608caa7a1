//! The formats that hold aggregates: their content.

use crate::pack::models::two_boxes;
use meso_core::formats::{Format, SurfaceOptions};
use meso_core::saved;
use std::io::{self, Write};
use std::path::Path;

fn written(format: Format) -> Vec<u8> {
    let mut bytes = Vec::new();
    format.write(&two_boxes(), SurfaceOptions::default(), &mut bytes).unwrap();
    bytes
}

#[test]
fn the_extension_names_the_format_in_either_case() {
    assert_eq!(Format::from_path(Path::new("a/b.JSON")), Some(Format::Json));
    assert_eq!(Format::from_path(Path::new("b.tar.stl")), Some(Format::Stl));
    assert_eq!(Format::from_path(Path::new("b.Json.GZ")), Some(Format::JsonGz));
    assert_eq!(Format::from_path(Path::new("b.stp")), Some(Format::Step));
    assert!(
        Format::ALL
            .iter()
            .all(|format| { Format::from_path(&Path::new("a").with_extension(format.extension())) == Some(*format) })
    );
    assert_eq!(Format::from_path(Path::new("b.csv.gz")), None);
    assert_eq!(Format::from_path(Path::new("json")), None);
    assert_eq!(Format::from_path(Path::new("model.xyz")), None);
}

#[test]
fn an_stl_holds_every_triangle_with_its_outward_normal() {
    let bytes = written(Format::Stl);
    assert_eq!(bytes.len(), 84 + 50 * 24);
    assert!(!bytes.starts_with(b"solid"));
    assert_eq!(bytes[80..84], 24u32.to_le_bytes());
    let float = |at: usize| f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()));
    // Divergence theorem: a closed surface of outward triangles holds its volume.
    let volume: f64 = (0..24)
        .map(|t| {
            let corner = |c: usize| [0, 1, 2].map(|i| float(84 + 50 * t + 12 * (c + 1) + 4 * i));
            let [a, b, c] = [corner(0), corner(1), corner(2)];
            let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
            (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0
        })
        .sum();
    assert!((volume - 1343.0).abs() < 1e-2, "{volume}");
}

#[test]
fn a_compressed_model_reads_back_to_the_same() {
    let compressed = written(Format::JsonGz);
    assert!(compressed.len() < written(Format::Json).len());
    assert_eq!(saved::read(&compressed).unwrap(), saved::read(&written(Format::Json)).unwrap());
    let torn = saved::read(&compressed[..compressed.len() - 1]).unwrap_err().to_string();
    assert!(torn.starts_with("this is not a saved model of mesocrete"), "{torn}");
}

#[test]
fn every_entity_that_a_step_file_names_is_there() {
    let surfaces = SurfaceOptions { mortar: true, ..SurfaceOptions::default() };
    let mut bytes = Vec::new();
    Format::Step.write(&two_boxes(), surfaces, &mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let entities: Vec<&str> = text.lines().filter(|line| line.starts_with('#')).collect();
    for (number, line) in (1..).zip(&entities) {
        let (own, of) = line.split_once('=').unwrap();
        assert_eq!(own, format!("#{number}"));
        // A reader meets every entity before the entities that name it.
        let named = of.split('#').skip(1).map(|rest| rest.split(|c: char| !c.is_ascii_digit()).next().unwrap());
        assert!(named.map(|name| name.parse::<usize>().unwrap()).all(|name| name < number), "{line}");
    }
    let count = |of: &str| entities.iter().filter(|line| line.contains(&format!("={of}("))).count();
    assert_eq!([count("MANIFOLD_SOLID_BREP"), count("BREP_WITH_VOIDS"), count("CLOSED_SHELL")], [2, 1, 3]);
    assert_eq!([count("ADVANCED_FACE"), count("EDGE_CURVE"), count("ORIENTED_CLOSED_SHELL")], [18, 36, 2]);
}

#[test]
fn a_csv_has_one_row_per_aggregate() {
    let text = String::from_utf8(written(Format::Csv)).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 3);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()));
    let value = |row: usize, name: &str| -> f64 {
        let column = rows[0].iter().position(|heading| *heading == name).expect(name);
        rows[row][column].parse().unwrap()
    };
    assert_eq!([value(1, "id"), value(2, "id"), value(1, "vertices"), value(2, "faces")], [0.0, 1.0, 8.0, 6.0]);
    assert!((value(1, "volume_mm3") - 1000.0).abs() < 1e-9);
    assert!((value(1, "area_mm2") - 600.0).abs() < 1e-9);
    assert!((value(1, "size_mm") - 300f64.sqrt()).abs() < 1e-9);
    // Wadell's sphericity of a cube: (pi / 6)^(1/3).
    assert!((value(1, "sphericity") - (std::f64::consts::PI / 6.0).cbrt()).abs() < 1e-12);
    assert!((value(1, "centroid_y_mm") - (5.0 + 1.0 / 3.0)).abs() < 1e-9);
}

#[test]
fn a_vtu_declares_what_it_holds() {
    let bytes = written(Format::Vtu);
    let begin = bytes.windows(2).position(|w| w == b"\n_").unwrap() + 2;
    let header = std::str::from_utf8(&bytes[..begin]).unwrap();
    assert!(header.contains("NumberOfPoints=\"16\" NumberOfCells=\"12\""), "{header}");
    let mut at = begin;
    let mut sizes = Vec::new();
    while bytes[at] != b'\n' || !bytes[at + 1..].starts_with(b"</AppendedData>") {
        assert!(header.contains(&format!("offset=\"{}\"", at - begin)), "no array begins at {}", at - begin);
        let size = u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
        sizes.push(size);
        at += 8 + size;
    }
    // Points, connectivity, offsets, types, aggregate, class, phase, itz_thickness_mm.
    assert_eq!(sizes, [16 * 24, 48 * 4, 12 * 8, 12, 12 * 4, 12 * 4, 12, 12 * 8]);
}

/// Takes `room` bytes, then fails as a full disk does.
struct FullDisk {
    room: usize,
}

impl Write for FullDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.room == 0 {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        let taken = bytes.len().min(self.room);
        self.room -= taken;
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_writer_that_fails_anywhere_is_reported() {
    for format in Format::ALL {
        let length = written(format).len();
        for room in (0..length).step_by(11) {
            let error = format.write(&two_boxes(), SurfaceOptions::default(), FullDisk { room }).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::StorageFull, "{format:?} after {room} bytes");
        }
        assert!(format.write(&two_boxes(), SurfaceOptions::default(), FullDisk { room: length }).is_ok());
    }
}
