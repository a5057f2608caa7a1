//! Surfaces and stones as other programs and scanners leave them: specks, nested bodies, folders as published, OFF and PLY.

use crate::pack::folder::{Folder, Heard};
use meso_core::Spec;
use std::fmt::Write;

/// Number of grains of a library, and the remarks.
fn read(name: &str, files: &[(&str, &[u8])], options: &str) -> Result<(usize, String), String> {
    let mut heard = Heard(Folder(files), Vec::new());
    let text = format!("shape = {{ path = '{name}'{options} }}");
    let spec = Spec::from_toml_with(&text, &mut heard).map_err(|error| error.to_string())?;
    Ok((spec.shape.grains.len(), heard.1.join("; ")))
}

fn library(name: &str, bytes: &[u8]) -> Result<(usize, String), String> {
    read(name, &[(name, bytes)], "")
}

/// Corners and triangles of a box, turned outwards.
fn block(at: [f64; 3], size: f64) -> Vec<[[f64; 3]; 3]> {
    let corner = |bits: usize| [0, 1, 2].map(|axis| at[axis] + if bits >> axis & 1 == 1 { size } else { 0.0 });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|t| t.map(corner)).collect()
}

type Triangles = Vec<[[f64; 3]; 3]>;

fn stl(triangles: &Triangles) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        triangle.as_flattened().iter().for_each(|x| bytes.extend((*x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn obj(triangles: &Triangles) -> Vec<u8> {
    let mut text = String::new();
    triangles.as_flattened().iter().for_each(|[x, y, z]| writeln!(text, "v {x} {y} {z}").unwrap());
    (0..triangles.len()).for_each(|k| writeln!(text, "f {} {} {}", 3 * k + 1, 3 * k + 2, 3 * k + 3).unwrap());
    text.into_bytes()
}

fn off(triangles: &Triangles) -> Vec<u8> {
    let mut text = format!("OFF\n{} {} 0\n", 3 * triangles.len(), triangles.len());
    triangles.as_flattened().iter().for_each(|[x, y, z]| writeln!(text, "{x} {y} {z}").unwrap());
    (0..triangles.len()).for_each(|k| writeln!(text, "3 {} {} {}", 3 * k, 3 * k + 1, 3 * k + 2).unwrap());
    text.into_bytes()
}

fn ply(triangles: &Triangles) -> Vec<u8> {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        3 * triangles.len(),
        triangles.len()
    );
    triangles.as_flattened().iter().for_each(|[x, y, z]| writeln!(text, "{x} {y} {z}").unwrap());
    (0..triangles.len()).for_each(|k| writeln!(text, "3 {} {} {}", 3 * k, 3 * k + 1, 3 * k + 2).unwrap());
    text.into_bytes()
}

type Format = (&'static str, fn(&Triangles) -> Vec<u8>);

const FORMATS: [Format; 4] = [("a.stl", stl), ("a.obj", obj), ("a.off", off), ("a.ply", ply)];

/// The case `bugs_debris.obj`: half of the grains were copies of a speck of 5e-8 of the stone's volume.
#[test]
fn specks_beside_a_stone_are_dropped_and_bodies_counted() {
    let stone = block([0.0; 3], 10.0);
    let speck = |k: usize| block([20.0 + 2.0 * k as f64, 1.0, 3.0], 0.05);
    let one = [stone.clone(), speck(0)].concat();
    let nine = (0..9).map(speck).fold(stone.clone(), |all, speck| [all, speck].concat());
    let first = [speck(0), stone.clone(), speck(1)].concat();
    // A twelfth of the edge is 6e-4 of the volume; an eighth is 2e-3, and a grain.
    let (small, large) =
        ([stone.clone(), block([30.0; 3], 10.0 / 12.0)].concat(), [stone.clone(), block([30.0; 3], 1.25)].concat());
    for (name, write) in FORMATS {
        let found = |triangles: &Triangles| library(name, &write(triangles)).unwrap();
        let dropped = |bodies: usize, specks: usize| {
            format!(
                "{name}: it has {bodies} bodies: {specks} below 0.001 of the volume of the largest were dropped, as scans have \
                 specks; 1 left"
            )
        };
        assert_eq!(found(&stone), (1, String::new()));
        assert_eq!(found(&one), (1, dropped(2, 1)));
        assert_eq!(found(&nine), (1, dropped(10, 9)));
        assert_eq!(found(&first), (1, dropped(3, 2)));
        assert_eq!(found(&small), (1, dropped(2, 1)));
        assert_eq!(found(&large), (2, format!("{name}: it has 2 bodies, and each is a grain of equal right")));
        let hull = read(name, &[(name, &write(&nine))], ", hull = true").unwrap();
        assert_eq!(hull, (1, dropped(10, 9)));
    }
}

/// A speck above a specimen would be what the plates of a test meet first.
#[test]
fn specks_beside_a_specimen_are_dropped_and_its_bodies_counted() {
    let specimen = block([0.0; 3], 40.0);
    let hollow: Triangles = block([10.0; 3], 1.0).into_iter().map(|[a, b, c]| [a, c, b]).collect();
    let speck = block([20.0, 20.0, 60.0], 0.5);
    for (name, write) in FORMATS {
        let found = |triangles: &Triangles| {
            let bytes = write(triangles);
            let files: [(&str, &[u8]); 1] = [(name, &bytes)];
            let mut heard = Heard(Folder(&files), Vec::new());
            let text = format!("specimen = {{ kind = 'mesh', file = '{name}' }}");
            let specimen = Spec::from_toml_with(&text, &mut heard).unwrap().specimen;
            (specimen.volume(), specimen.aabb().size().z, heard.1.join("; "))
        };
        let dropped = format!(
            "{name}: it has 2 bodies: 1 below 0.001 of the volume of the largest were dropped, as scans have specks; 1 left"
        );
        assert_eq!(found(&specimen), (64_000.0, 40.0, String::new()));
        assert_eq!(found(&[specimen.clone(), speck.clone()].concat()), (64_000.0, 40.0, dropped.clone()));
        assert_eq!(found(&[speck.clone(), specimen.clone(), hollow.clone()].concat()), (63_999.0, 40.0, dropped));
        let two = [specimen.clone(), block([50.0, 0.0, 0.0], 20.0)].concat();
        let said = format!("{name}: it has 2 bodies, which are one specimen together");
        assert_eq!(found(&two), (72_000.0, 40.0, said));
    }
}

#[test]
fn a_body_within_another_is_refused_with_the_numbers_of_both() {
    let outer = block([0.0; 3], 10.0);
    let pairs = [
        ([outer.clone(), block([3.0; 3], 4.0)].concat(), [0, 1]),
        ([block([3.0; 3], 4.0), outer.clone()].concat(), [1, 0]),
        ([block([40.0; 3], 9.0), outer.clone(), block([1.0; 3], 2.0)].concat(), [1, 2]),
    ];
    for (name, write) in FORMATS {
        for (triangles, [outer, inner]) in &pairs {
            let error = library(name, &write(triangles)).unwrap_err();
            assert!(
                error.contains(&format!("body {inner} of ")) && error.contains(&format!("within body {outer};")),
                "{error}"
            );
        }
        let beside = [outer.clone(), block([10.5, 0.0, 0.0], 9.0)].concat();
        assert_eq!(library(name, &write(&beside)).unwrap().0, 2);
    }
}

const STONE: &str = "0 0 18 0\n2 0 0.5 0\n2 2 0.25 -0.125\n";

/// The case `bugs_vcctl`: a set as it is published, with tables beside the stones.
#[test]
fn a_folder_of_stones_is_read_as_it_is_published() {
    let harmonics = |files: &[(&str, &[u8])]| read("set", files, ", kind = 'harmonics'");
    let (stone, tables) = (STONE.as_bytes(), ("set/bin2D.dat", &b"   0.0   0.0   0.0   0.0   0.0\n"[..]));
    let (count, remarks) = harmonics(&[
        ("set/A-anm-00001.dat", stone),
        ("set/A-anm-00002.dat", stone),
        tables,
        ("set/README.txt", b"Stones of a quarry.\n"),
        ("set/length-stats.dat", b"mean length 18.2\n"),
    ])
    .unwrap();
    assert_eq!(count, 2);
    let over = "set: 3 file(s) that begin with no coefficient, n m Re Im, were passed over: README.txt, bin2D.dat, length-stats.dat";
    assert!(remarks.ends_with(over) && remarks.contains("3 coefficients that it leaves out count as 0"), "{remarks}");
    let none = harmonics(&[tables]).unwrap_err();
    assert!(none.starts_with("line 1: shape.path is \"set\": none of its files begins with a coefficient"), "{none}");
    // A stone with a fault is no table.
    let broken = harmonics(&[("set/a.dat", stone), ("set/b.dat", b"0 0 18 0\n1 0 x 0\n")]).unwrap_err();
    assert!(broken.contains("shape.path is \"set\": b.dat: line 2"), "{broken}");
    let alone = read("b.dat", &[("b.dat", b"mean length 18.2\n")], ", kind = 'harmonics'").unwrap_err();
    assert!(alone.contains("shape.path is \"b.dat\""), "{alone}");
}

const CUBE: &str = "0 0 0\n0 0 60\n0 60 0\n0 60 60\n60 0 0\n60 0 60\n60 60 0\n60 60 60\n";
const SIDES: &str = "4 0 1 3 2\n4 4 6 7 5\n4 0 4 5 1\n4 2 3 7 6\n4 0 2 6 4\n4 1 5 7 3\n";

/// The case `bugs_modelnet.off`, and other numbers free of lines: all are a cube.
#[test]
fn off_is_read_with_its_numbers_wherever_they_stand() {
    let flat = |text: &str| text.replace('\n', " ");
    let with = |end: &str, text: &str| text.lines().map(|line| format!("{line} {end}\n")).collect::<String>();
    let halves: String = CUBE.lines().map(|line| format!("{}\n", line.replacen(' ', "\n", 1))).collect();
    for text in [
        format!("OFF8 6 12\n{CUBE}{SIDES}"),
        format!("off8 6\n{CUBE}{SIDES}"),
        format!("COFF8 6 12\n{}{SIDES}", with("255 0 0 255", CUBE)),
        format!("OFF 8 6 12\n{}\n{SIDES}", flat(CUBE)),
        format!("OFF\n8 6 12\n{}{}\n", flat(CUBE), flat(SIDES)),
        format!("OFF 8 6 12 {}{}", flat(CUBE), flat(SIDES)),
        format!("OFF\n8 6 12\n{halves}{SIDES}"),
        format!("OFF\n8 6 12\n{}\n{}", flat(CUBE), with("255 0 0", SIDES)),
        format!("4OFF\n8 6 12\n{}{SIDES}", with("1", CUBE)),
        format!("4OFF\n8 6 12\n{}{SIDES}", with("0.5", CUBE)),
        format!("4OFF 8 6 12\n{}{SIDES}", flat(&with("1", CUBE))),
        // MeshLab's order, and all that Geomview has.
        format!("NCOFF\n8 6 12\n{}{SIDES}", with("255 0 0 255 0 0 1", CUBE)),
        format!("CNOFF8 6 12\n{}{SIDES}", with("0 0 1 255 0 0 255", CUBE)),
        format!("STOFF\n8 6 12\n{}{SIDES}", with("0.5 0.5", CUBE)),
        format!("STCN4OFF\n8 6 12\n{}{SIDES}", with("1 0 0 1 1 0 0 1 0.5 0.5", CUBE)),
        format!("C4OFF\n8 6 12\n{}{SIDES}", with("0.25 1 0 0 1", CUBE)),
    ] {
        let mut heard = Heard(Folder(&[("a.off", text.as_bytes())]), Vec::new());
        let spec =
            Spec::from_toml_with("shape = { library = 'a.off' }", &mut heard).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert!((spec.shape.grains[0].relative_volume() - 3.0_f64.powf(-1.5)).abs() < 1e-9, "{text}");
    }
    for (text, said) in [
        (format!("nOFF\n3\n8 6 12\n{CUBE}{SIDES}"), "it is an nOFF, of any number of dimensions"),
        (format!("4nOFF\n3\n8 6 12\n{CUBE}{SIDES}"), "it is an nOFF, of any number of dimensions"),
        (format!("8 6 12\n{CUBE}{SIDES}"), "it must begin with OFF"),
        (format!("44OFF\n8 6 12\n{CUBE}{SIDES}"), "it must begin with OFF"),
        (format!("XOFF\n8 6 12\n{CUBE}{SIDES}"), "it must begin with OFF"),
        (format!("SOFF\n8 6 12\n{CUBE}{SIDES}"), "it must begin with OFF"),
        (format!("4OFF\n8 6 12\n{}{SIDES}", with("0", CUBE)), "is not a vertex"),
        (format!("OFF\n8 6 12\n{}", flat(CUBE)), "it ends within its vertices"),
        (format!("OFF\n8 6 12\n{}4 0 1 3", flat(CUBE)), "it ends within its vertices"),
    ] {
        let error = library("a.off", text.as_bytes()).unwrap_err();
        assert!(error.contains(said), "{text}: {error}");
    }
}

/// The case `bugs_strip.ply`, as text and as bytes of either order.
#[test]
fn strips_of_triangles_are_read() {
    let head = |format: &str, element: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
             {element}property list int int vertex_indices\nend_header\n"
        )
    };
    let corners: Vec<f32> = CUBE.split_whitespace().map(|word| word.parse().unwrap()).collect();
    // A triangle a strip; a face a strip; one strip, whose corners are given twice where it goes from face to face.
    let single = [0, 1, 3, -1, 0, 3, 2, -1, 4, 6, 7, -1, 4, 7, 5, -1, 0, 4, 5, -1, 0, 5, 1, -1];
    let rest = [2, 3, 7, -1, 2, 7, 6, -1, 0, 2, 6, -1, 0, 6, 4, -1, 1, 5, 7, -1, 1, 7, 3, -1];
    let faces = [0, 1, 2, 3, -1, 4, 6, 5, 7, -1, 0, 4, 1, 5, -1, 2, 3, 6, 7, -1, 0, 2, 4, 6, -1, 1, 5, 3, 7, -1];
    let one = [0, 1, 2, 3, 3, 4, 4, 6, 5, 7, 7, 0, 0, 4, 1, 5, 5, 2, 2, 3, 6, 7, 7, 0, 0, 2, 4, 6, 6, 1, 1, 5, 3, 7];
    for strip in [[single, rest].concat(), faces.to_vec(), one.to_vec()] {
        let numbers: Vec<String> = strip.iter().map(ToString::to_string).collect();
        let text = head("ascii", "element tristrips 1\n") + CUBE + &format!("{} {}\n", strip.len(), numbers.join(" "));
        let binary = |is_big: bool| {
            let format = if is_big { "binary_big_endian" } else { "binary_little_endian" };
            let mut bytes = head(format, "element tristrips 1\n").into_bytes();
            let mut put = |little: [u8; 4]| {
                bytes.extend(if is_big { [little[3], little[2], little[1], little[0]] } else { little });
            };
            corners.iter().for_each(|x| put(x.to_le_bytes()));
            put((strip.len() as i32).to_le_bytes());
            strip.iter().for_each(|corner: &i32| put(corner.to_le_bytes()));
            bytes
        };
        for bytes in [text.into_bytes(), binary(false), binary(true)] {
            assert_eq!(library("a.ply", &bytes), Ok((1, String::new())));
        }
    }
    let grid = head("ascii", "element range_grid 1\n") + CUBE + "1 0\n";
    let error = library("a.ply", grid.as_bytes()).unwrap_err();
    assert!(error.contains("its elements are vertex, range_grid"), "{error}");
}
