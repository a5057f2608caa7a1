//! Label volumes of other programs.

use meso_core::import::volume::{Volume, VolumeError, Wanted, read, read_wanted};

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
    assert_eq!(axes, "an array of 4 axes is not read; remove its axes of length 1 by numpy.squeeze");
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

/// An entry of a directory: tag, kind, count, and four bytes of value or place.
type Entry = (u16, u16, u32, u32);

/// A TIFF of 2 x 2 pixels a page, little-endian: its first page has a description and two pixels a unit.
fn stack(description: &str, pages: &[[u8; 4]], others: &[Entry]) -> Vec<u8> {
    let mut text = description.as_bytes().to_vec();
    text.resize(text.len().div_ceil(2) * 2, 0);
    let (colours, rational) = (8 + text.len() as u32, 8 + text.len() as u32 + 12);
    let mut bytes = b"II*\0".to_vec();
    let first = rational + 8;
    bytes.extend(first.to_le_bytes());
    bytes.extend(text);
    bytes.extend([0; 12]);
    bytes.extend([2_u32.to_le_bytes(), 1_u32.to_le_bytes()].concat());
    for (number, page) in pages.iter().enumerate() {
        let own = [(254, 4, 1, 0), (256, 3, 1, 2), (257, 3, 1, 2), (258, 3, 1, 8), (259, 3, 1, 1), (262, 3, 1, 1)];
        let about = [(270, 2, description.len() as u32, 8), (282, 5, 1, rational), (283, 5, 1, rational)];
        let about = if number == 0 { &about[..] } else { &[] };
        let mut entries: Vec<Entry> =
            [&own[..], about, &[(278, 3, 1, 2), (279, 4, 1, 4), (320, 3, 6, colours)]].concat();
        entries.retain(|entry| others.iter().all(|other| other.0 != entry.0));
        entries.extend(others);
        let end = bytes.len() as u32 + 2 + 12 * (entries.len() as u32 + 1) + 4;
        entries.push((273, 4, 1, end));
        entries.sort_unstable();
        bytes.extend((entries.len() as u16).to_le_bytes());
        for (tag, kind, count, value) in entries {
            bytes.extend(
                [&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value.to_le_bytes()].concat(),
            );
        }
        bytes.extend((if number + 1 < pages.len() { end + 4 } else { 0 }).to_le_bytes());
        bytes.extend(page);
    }
    bytes
}

const TWO: [[u8; 4]; 2] = [[1, 2, 3, 4], [5, 6, 7, 8]];

/// A stack of 20 slices of 1 mm was 10 mm high; in ImageJ's files a missing spacing is one unit.
#[test]
fn the_depth_of_an_imagej_stack_is_one_unit_where_the_file_leaves_it_out() {
    for (description, spacing, says) in [
        ("ImageJ=1.54f\nimages=2\nslices=2\nunit=mm\n", Some([0.5, 0.5, 1.0]), "slices are 1 mm apart, pixels 0.5 mm"),
        ("ImageJ=1.54f\nimages=2\nslices=2\nunit=mm\nspacing=2.5\n", Some([0.5, 0.5, 2.5]), ""),
        ("ImageJ=1.54f\nimages=2\nslices=2\nunit=millimeter\nspacing=-0.5\n", Some([0.5, 0.5, 0.5]), ""),
        ("ImageJ=1.54f\nimages=2\nslices=2\nunit=\\u00B5m\nspacing=3\n", Some([5e-4, 5e-4, 3e-3]), ""),
        ("ImageJ=1.54f\nimages=2\nslices=2\nunit=micron\n", Some([5e-4, 5e-4, 1e-3]), "if it is 1 micron"),
        (
            "ImageJ=1.54f\nimages=2\nslices=2\nunit=furlong\n",
            None,
            "sizes in `furlong`, which is no length, so it is 1 mm",
        ),
        ("SCIFIO=0.46\nimages=2\nunit=mm\n", None, "no distance of its slices, so it is 1 mm"),
        ("", None, "2 pixels per inch as for a printer, and no distance of its slices, so it is 1 mm"),
        (
            "<OME><Image><Pixels SizeX=\"2\" SizeZ=\"2\" SizeC=\"1\" PhysicalSizeX=\"40\" PhysicalSizeY='0.05' \
             PhysicalSizeYUnit='mm' PhysicalSizeZ=\"0.1\" PhysicalSizeZUnit=\"mm\"/></Image></OME>",
            Some([0.04, 0.05, 0.1]),
            "",
        ),
        ("<OME><Pixels SizeZ='2' PhysicalSizeX='40' PhysicalSizeY='40'/></OME>", None, "no PhysicalSizeX"),
        ("{\"shape\": [2, 2, 2]}", None, "as for a printer"),
    ] {
        let volume: Volume = read("a.tif", &stack(description, &TWO, &[])).unwrap();
        assert_eq!((volume.counts, volume.labels.len()), ([2, 2, 2], 8), "{description}");
        let is_near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        let is_right = volume.spacing_mm.zip(spacing).map_or(volume.spacing_mm == spacing, |(a, b)| is_near(a, b));
        assert!(is_right, "{description}: {:?}", volume.spacing_mm);
        let said = volume.size_remark(false).unwrap_or_default();
        assert!(said.contains(says) && said.is_empty() == says.is_empty(), "{description}: {said}");
        assert_eq!(volume.size_remark(true), None);
    }
}

/// Two channels made a specimen of twice the height, and 20 grains of 2.
#[test]
fn channels_and_frames_are_no_slices() {
    for (description, says) in [
        (
            "ImageJ=1.54f\nimages=2\nchannels=2\nhyperstack=true\nunit=mm\n",
            "a stack of 2 channels is not read; save one",
        ),
        ("ImageJ=1.54f\nimages=2\nframes=2\n", "a stack of 2 frames is not read; save one frame"),
        ("ImageJ=1.54f\nimages=3\nslices=3\n", "a file of 2 pages whose description has 3 images"),
        ("<OME><Image><Pixels SizeC=\"2\" SizeZ=\"1\"/></Image></OME>", "a stack of 2 channels"),
        ("<ome:OME><ome:Pixels SizeT='2'/></ome:OME>", "a stack of 2 frames"),
        ("<OME><Pixels SizeZ='2'/><Pixels SizeZ='2'/></OME>", "a stack of 2 images"),
        ("{\"shape\": [2, 2, 2], \"axes\": \"CYX\"}", "an array of 2 x 2 x 2 values along 3 axes"),
        ("{\"shape\": [2, 2, 2, 2]}", "an array of 2 x 2 x 2 x 2 values along 4 axes"),
        ("{\"shape\": [3, 2, 2]}", "an array of 3 x 2 x 2 values of which the pages hold a part"),
        // The second page has no description, so that it may be of another array.
        ("{\"shape\": [2, 2]}", "an array of 2 x 2 values of which the pages hold a part"),
        ("ImageJ=1.54f\nimages=2\nslices=2\ncf=0\nc0=-32768.0\nc1=1.0\n", "a stack whose values mean -32768 + 1 times"),
        (
            "<OME><Pixels SizeZ='2'><TiffData IFD='1' FirstZ='0'/><TiffData IFD='0' FirstZ='1'/></Pixels></OME>",
            "a stack whose pages are not in the order of their slices",
        ),
    ] {
        let refused = read::<u8>("a.tif", &stack(description, &TWO, &[])).unwrap_err().to_string();
        assert!(refused.starts_with(says), "{description}: {refused}");
    }
    // imageio's `mimwrite` describes each page as an array of its own.
    let own = "{\"shape\": [2, 2]}";
    let pages: Volume = read("a.tif", &stack(own, &TWO, &[(270, 2, own.len() as u32, 8)])).unwrap();
    assert_eq!((pages.counts, labels(&pages)), ([2, 2, 2], vec![1, 2, 3, 4, 5, 6, 7, 8]));
    // Rows from below are a mirror image.
    let turned = read::<u8>("a.tif", &stack("", &TWO, &[(274, 3, 1, 4)])).unwrap_err().to_string();
    assert!(turned.starts_with("a page turned by the Orientation 4 is not read"), "{turned}");
    assert_eq!(read::<u8>("a.tif", &stack("", &TWO, &[(274, 3, 1, 1)])), read("a.tif", &stack("", &TWO, &[])));
    // A smaller copy of the stack is passed over; a page of slices is not read.
    let thumbnail = read::<u8>("a.tif", &stack("", &TWO, &[(254, 4, 1, 1)])).unwrap_err();
    assert_eq!(thumbnail, VolumeError::Empty);
    let deep = read::<u8>("a.tif", &stack("", &TWO, &[(32997, 3, 1, 7)])).unwrap_err().to_string();
    assert!(deep.starts_with("a page that holds 7 slices"), "{deep}");
}

#[test]
fn labels_of_a_palette_are_its_numbers() {
    let volume: Volume = read("a.tif", &stack("", &TWO, &[(262, 3, 1, 3)])).unwrap();
    assert_eq!(labels(&volume), [1, 2, 3, 4, 5, 6, 7, 8]);
}

/// Heads that claim more than there is: pages that share their pixels, a block of zeros, a header of numpy.
#[test]
fn memory_is_asked_before_it_is_taken() {
    let wanted = Wanted { array: None, most_bytes: Some(1_000_000) };
    let pages = stack("", &[[0; 4]; 9], &[(256, 4, 1, 15_000), (257, 4, 1, 15_000)]);
    let packed = "<DataArray type=\"UInt8\" Name=\"b\" format=\"appended\" offset=\"0\"/>";
    let large = vti("", packed, "<AppendedData>_").map_extent("0 2000 0 2000 0 2000");
    for (name, bytes) in [("a.tif", &pages), ("a.vti", &large)] {
        let refused = read_wanted::<u16>(name, bytes, &wanted).unwrap_err().to_string();
        assert!(refused.contains("voxels, which take about") && refused.ends_with("cut a part out"), "{refused}");
    }
    // Blocks that open to more than the image has are not opened to their end.
    let zlib = "AQAAAAAAAAAGAAAAAAAAAAAAAAAAAAAADgAAAAAAAAA=eJxjYGRiZGIAAAAaAAc=";
    let packed = format!("<DataArray type=\"UInt8\" Name=\"b\" format=\"binary\">{zlib}</DataArray>");
    let file =
        vti("header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"", &packed, "").map_extent("0 2 0 2 0 1");
    assert_eq!(read::<u8>("a.vti", &file).unwrap_err(), VolumeError::Cut("values"));
}

/// Changes a header.
trait Altered {
    fn altered(&self, from: &str, to: &str) -> Vec<u8>;

    fn map_extent(&self, extent: &str) -> Vec<u8> {
        self.altered("WholeExtent=\"0 3 0 2 0 1\"", &format!("WholeExtent=\"{extent}\""))
    }
}

impl Altered for Vec<u8> {
    fn altered(&self, from: &str, to: &str) -> Vec<u8> {
        let text = str::from_utf8(self).unwrap();
        assert!(text.contains(from));
        text.replace(from, to).into_bytes()
    }
}

/// A file's `vtkGhostType` was taken for its labels, and of several arrays the first without a word.
#[test]
fn the_array_of_labels_is_named_or_chosen() {
    let array = |name: &str, values: &str| {
        format!("<DataArray\ttype=\"Int64\" Name=\"{name}\" format=\"ascii\">{values}</DataArray>")
    };
    let labelled = array("labels", "0 1 2 1 2 0");
    let ghosts = vti("", &[array("vtkGhostType", "0 0 0 0 0 0"), labelled.clone()].concat(), "");
    let volume: Volume = read("a.vti", &ghosts).unwrap();
    assert_eq!((labels(&volume), &volume.array_note), (vec![0, 1, 2, 1, 2, 0], &None));
    let two = vti("", &[array("phase", "3 3 3 3 3 3"), labelled].concat(), "");
    let volume: Volume = read("a.vti", &two).unwrap();
    let note = "the file has 2 arrays, and `phase` was read; for array take one of `phase`, `labels`";
    assert_eq!((&volume.labels[..], volume.array_note.as_deref()), (&[3][..], Some(note)));
    let wanted = |name| Wanted { array: Some(name), most_bytes: None };
    let volume: Volume = read_wanted("a.vti", &two, &wanted("labels")).unwrap();
    assert_eq!((labels(&volume), volume.array_note), (vec![0, 1, 2, 1, 2, 0], None));
    let refused = read_wanted::<u8>("a.vti", &two, &wanted("label")).unwrap_err().to_string();
    assert_eq!(refused, "it has no array `label` of one value a voxel; take one of `phase`, `labels`");
    let refused = read_wanted::<u8>("a.npy", &two, &wanted("label")).unwrap_err().to_string();
    assert!(refused.starts_with("a named array is not read"), "{refused}");
    // Labels beyond the numbers that a real has exactly.
    let long = vti("", &array("labels", "9007199254740993 1 1 1 1 1"), "");
    assert_eq!(read::<u8>("a.vti", &long).unwrap().labels, [1, 9_007_199_254_740_993]);
    let beyond = npy("<u8", "(1, 2)", false, &[1_u64.to_le_bytes(), ((1_u64 << 63) + 1).to_le_bytes()].concat());
    assert_eq!(read::<u8>("a.npy", &beyond).unwrap_err(), VolumeError::Beyond { voxel: 1, label: (1 << 63) + 1 });
}

#[test]
fn an_image_of_vtk_that_is_turned_or_cut_into_pieces_is_refused() {
    let array = "<DataArray type=\"UInt8\" Name=\"b\" format=\"ascii\">0 1 2 1 2 0</DataArray>";
    let file = vti("", array, "");
    let spacing = "Spacing=\"0.5 0.5 0.25\"";
    let same = file.altered(spacing, &format!("{spacing} Direction=\"1 0 0 0 1 0 -0 0 1.0\""));
    assert_eq!(read::<u8>("a.vti", &same), read("a.vti", &file));
    for (to, says) in [
        ("Direction=\"-1 0 0 0 -1 0 0 0 1\"", "an image turned by the Direction `-1 0 0 0 -1 0 0 0 1` is not read"),
        ("Direction=\"1 0 0 0 1 0 0 0\"", "an image turned by the Direction"),
        ("Spacing=\"0.5 -0.5 0.25\"", "the Spacing `0.5 -0.5 0.25` is not read"),
    ] {
        let refused = read::<u8>("a.vti", &file.altered(spacing, to)).unwrap_err().to_string();
        assert!(refused.starts_with(says), "{refused}");
    }
    // Metres and micrometres are asked about: 1.5 mm is a specimen, 0.15 mm and 6 m are none.
    assert_eq!(read::<u8>("a.vti", &file).unwrap().size_remark(false), None);
    for (to, says) in [
        (
            "Spacing=\"0.05 0.05 0.025\"",
            "in mm its volume is 0.15 mm long; if it is in metres, a voxel has 50,50,25 mm",
        ),
        (
            "Spacing=\"2000 20 20\"",
            "in mm its volume is 6000 mm long; if it is in micrometres, a voxel has 2,0.02,0.02 mm",
        ),
    ] {
        let volume = read::<u8>("a.vti", &file.altered(spacing, to)).unwrap();
        assert!(volume.size_remark(false).is_some_and(|said| said.contains(says)), "{:?}", volume.size_remark(false));
        assert_eq!(volume.size_remark(true), None);
    }
    let piece = file.altered("<Piece>", "<Piece Extent=\"0 3 0 1 0 1\">");
    assert!(read::<u8>("a.vti", &piece).unwrap_err().to_string().starts_with("a piece of another extent"));
}
