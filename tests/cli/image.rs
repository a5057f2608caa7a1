//! `mesocrete image`: files by their extensions, and what cannot be asked.

use crate::command::Folder;

#[test]
fn one_run_writes_an_image_in_every_format_that_holds_it() {
    let folder = Folder::with_model();
    let flags = ["--voxel-size-mm", "2", "-o", "a.npy", "-o", "a.tif", "-o", "a.vti"];
    let run = folder.run(&[&["image", "small.json"][..], &flags].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.starts_with("phase of 20 x 20 x 20 voxels of 2 mm\nwrote a.npy\n"), "{}", run.stderr);
    let array = folder.read("a.npy");
    assert_eq!(array.len(), 128 + 8000);
    assert!(folder.read("a.vti").windows(8000).any(|window| *window == array[128..]));
    assert_eq!(&folder.read("a.tif")[..4], b"II*\0");
    let streamed = folder.run(&["image", "small.json", "--voxel-size-mm", "2", "-o", "-", "--threads", "1"]);
    assert_eq!(streamed.stdout, array);
}

#[test]
fn a_section_is_drawn_and_refusals_name_the_way_out() {
    let folder = Folder::with_model();
    let run = folder.run(&["image", "small.json", "--section", "z=20", "-qo", "s.png", "-o", "s.svg"]);
    assert_eq!((run.code, run.stderr.as_str()), (0, ""));
    assert_eq!(&folder.read("s.png")[..8], b"\x89PNG\r\n\x1a\n");
    assert!(folder.read("s.svg").starts_with(b"<svg xmlns="));
    for (flags, said) in [
        (&["-o", "x.png"][..], "x.png: it holds one section; add --section z=75, or use .npy, .tif or .vti"),
        (&["-o", "x.bmp"], "unknown image format; the extension must be one of .npy, .tif, .vti, .png, .svg"),
        (&["-o", "x.npy", "--section", "w=3"], "it must be an axis and a length in mm, as in z=75"),
        (&["-o", "x.npy", "--section", "z=41"], "--section is 41; it must lie within 0 and 40 mm"),
        (&["-o", "x.npy", "--voxel-size-mm", "0"], "--voxel-size-mm is 0; it must lie within"),
        (&["-o", "x.npy", "--box", "0,0,0,50,1,1"], "--box is [0.0, 0.0, 0.0] to [50.0, 1.0, 1.0]; its lower corner"),
        (&["-o", "x.npy", "--of", "itz"], "--of is only for --what share"),
        (&["-o", "-", "-o", "small.json"], "'small.json' for '--output <FILE>': unknown image format"),
    ] {
        let run = folder.run(&[&["image", "small.json"][..], flags].concat());
        assert_eq!(run.code, 2, "{flags:?}: {}", run.stderr);
        assert!(run.stderr.contains(said), "{flags:?}: {}", run.stderr);
    }
    assert_eq!(folder.names(), ["s.png", "s.svg", "small.json", "small.toml"]);
}
