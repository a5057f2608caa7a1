//! Label volumes of other programs.

use meso_core::import::volume::{Volume, VolumeError, read};

/// A file of `numpy.save`.
fn npy(descr: &str, shape: &str, fortran: bool, data: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
    [b"\x93NUMPY\x01\0", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), data].concat()
}

/// A cell array of 3 x 2 x 1 voxels by VTK's writer.
fn vti(attributes: &str, array: &str, rest: &str) -> Vec<u8> {
    format!(
        "<?xml version=\"1.0\"?><VTKFile type=\"ImageData\" byte_order=\"LittleEndian\" {attributes}>\
         <ImageData WholeExtent=\"0 3 0 2 0 1\" Origin=\"0 0 0\" Spacing=\"0.5 0.5 0.25\"><Piece><CellData Scalars=\"b\">\
         <DataArray type=\"Float64\" Name=\"a\" NumberOfComponents=\"3\" format=\"ascii\">0.5</DataArray>{array}\
         </CellData></Piece></ImageData>{rest}</VTKFile>"
    )
    .into_bytes()
}

fn labels(volume: &Volume) -> Vec<i64> {
    volume.of.iter().map(|number| volume.labels[usize::from(*number)]).collect()
}

#[test]
fn arrays_of_numpy_have_any_type_and_order() {
    let values = [5_i64, -2, 7, 7, 5, -2];
    let little: Vec<u8> = values.iter().flat_map(|value| (*value as i16).to_le_bytes()).collect();
    let big: Vec<u8> = values.iter().flat_map(|value| (*value as f64).to_be_bytes()).collect();
    for (bytes, counts) in [
        (npy("<i2", "(1, 2, 3)", false, &little), [3, 2, 1]),
        (npy(">f8", "(2, 3)", false, &big), [3, 2, 1]),
        (npy("<i2", "(3, 2, 1)", true, &little), [1, 2, 3]),
    ] {
        let volume = read::<u8>("a.NPY", &bytes).unwrap();
        assert_eq!((volume.counts, &volume.labels[..], volume.spacing_mm), (counts, &[-2, 5, 7][..], None));
        let expected = if counts[0] == 3 { values } else { [5, 7, -2, 5, 7, -2] };
        assert_eq!(labels(&volume), expected);
    }
}

#[test]
fn image_data_of_vtk_is_text_base64_or_compressed() {
    let tag = |format: &str| format!("<DataArray type=\"UInt8\" Name=\"b\" format=\"{format}\"");
    // Six bytes after their length; the second text encodes the length alone, as some writers do.
    let joined = format!("{}>BgAAAAABAgECAA==</DataArray>", tag("binary"));
    let apart = format!("{}>BgAAAA==AAECAQIA</DataArray>", tag("binary"));
    let zlib = "AQAAAAAAAAAGAAAAAAAAAAAAAAAAAAAADgAAAAAAAAA=eJxjYGRiZGIAAAAaAAc=";
    let packed = format!("{}>{zlib}</DataArray>", tag("binary"));
    let appended = format!("{} offset=\"0\"/>", tag("appended"));
    for bytes in [
        vti("", &format!("{}>0 1 2\n1 2 0 </DataArray>", tag("ascii")), ""),
        vti("", &joined, ""),
        vti("header_type=\"UInt32\"", &apart, ""),
        vti("header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"", &packed, ""),
        vti("", &appended, "<AppendedData encoding=\"raw\">_\u{6}\0\0\0\0\u{1}\u{2}\u{1}\u{2}\0</AppendedData>"),
        vti("", &appended, "<AppendedData encoding=\"base64\">_BgAAAAABAgECAA==</AppendedData>"),
    ] {
        let volume = read::<u8>("a.vti", &bytes).unwrap();
        assert_eq!((volume.counts, volume.spacing_mm), ([3, 2, 1], Some([0.5, 0.5, 0.25])));
        assert_eq!(labels(&volume), [0, 1, 2, 1, 2, 0]);
    }
}

#[test]
fn files_that_hold_no_labels_are_refused_with_a_reason() {
    let refused = |name: &str, bytes: &[u8]| read::<u8>(name, bytes).unwrap_err();
    assert_eq!(refused("a.raw", b""), VolumeError::Ending);
    assert_eq!(refused("a.npy", b"PK"), VolumeError::Begin("a file of numpy.save"));
    assert_eq!(refused("a.tif", b"PK\0\0\0\0\0\0"), VolumeError::Begin("a TIFF file"));
    assert_eq!(refused("a.vti", b"<VTKFile type='PolyData'>"), VolumeError::Begin("VTK image data"));
    let array = npy("|u1", "(2, 3)", false, &[1; 6]);
    for (name, bytes, words) in [
        ("a.tif", &array[..], "a NumPy file does; let its name end in .npy"),
        ("a.raw", &array, "a NumPy file does; let its name end in .npy"),
        ("a.npy", b"II*\0\x08\0\0\0", "a TIFF file does; let its name end in .tif"),
        ("a.tif", b"<VTKFile type='ImageData'>", "a VTK image file does; let its name end in .vti"),
        ("a.npy", b"\x1f\x8b\x08", "a gzip file does; unpack it first"),
        (
            "a.npy",
            b"ply\nformat",
            "a PLY file does, which is not read here: name one that ends in .tif, .tiff, .npy or .vti",
        ),
    ] {
        assert_eq!(refused(name, bytes).to_string(), format!("it begins as {words}"), "{name}");
    }
    assert_eq!(refused("a.npy", &npy("|u1", "(2, 3)", false, &[1; 5])), VolumeError::Cut("values"));
    assert_eq!(refused("a.npy", &npy("|u1", "(0, 3)", false, &[])), VolumeError::Empty);
    let axes = refused("a.npy", &npy("|u1", "(1, 1, 2, 3)", false, &[1; 6])).to_string();
    assert!(axes.starts_with("an array of 4 axes is not read; save integers"), "{axes}");
    assert!(refused("a.npy", &npy("<c8", "(2, 3)", false, &[1; 48])).to_string().starts_with("the type `<c8`"));
    let grey: Vec<u8> = (0..300_u16).flat_map(u16::to_le_bytes).collect();
    assert_eq!(refused("a.npy", &npy("<u2", "(3, 100)", false, &grey)), VolumeError::Many { most: 256 });
    assert_eq!(read::<u16>("a.npy", &npy("<u2", "(3, 100)", false, &grey)).unwrap().labels.len(), 300);
    let real: Vec<u8> = [1.0_f32, 0.5].into_iter().flat_map(f32::to_le_bytes).collect();
    let said = refused("a.npy", &npy("<f4", "(1, 2)", false, &real)).to_string();
    assert_eq!(said, "voxel 1, counted from 0, has the value 0.5; labels are integers: segment the image first");
    let huge = vti("", "<DataArray type=\"UInt8\" Name=\"b\" format=\"appended\" offset=\"9\"/>", "<AppendedData>_");
    assert_eq!(refused("a.vti", &huge), VolumeError::Cut("values"));
}

/// A mask of 10 x 2 pixels, one bit each: rows begin with a byte of their own. With eight bits it has 2 x 2 pixels.
fn mask(photometric: u16, bits: u16) -> Vec<u8> {
    let mut bytes = b"II*\0\x08\0\0\0\x08\0".to_vec();
    let end = 10 + 8 * 12 + 4;
    let width = if bits == 1 { 10 } else { 2 };
    for (tag, value) in
        [(256, width), (257, 2), (258, bits), (259, 1), (262, photometric), (273, end), (278, 2), (279, 4)]
            as [(u16, u16); 8]
    {
        bytes.extend([tag.to_le_bytes(), 3_u16.to_le_bytes(), [1, 0], [0, 0], value.to_le_bytes(), [0, 0]].concat());
    }
    bytes.extend([0, 0, 0, 0, 0b1000_0001, 0b0100_0000, 0, 0b1000_0000]);
    bytes
}

/// Masks of one bit, as tifffile and Pillow write arrays of booleans, were pages with too few values.
#[test]
fn a_mask_of_one_bit_has_two_labels() {
    let volume: Volume = read("mask.tif", &mask(1, 1)).unwrap();
    assert_eq!((volume.counts, &volume.labels[..]), ([10, 2, 1], &[0, 1][..]));
    assert_eq!(volume.of, [1, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0]);
    let grey: Volume = read("grey.tif", &mask(1, 8)).unwrap();
    assert_eq!((grey.counts, &grey.labels[..]), ([2, 2, 1], &[0, 64, 128, 129][..]));
    for bits in [1, 8] {
        let refused = read::<u8>("mask.tif", &mask(0, bits)).unwrap_err().to_string();
        assert!(refused.starts_with("a page whose zeros are white is not read"), "{refused}");
    }
}
