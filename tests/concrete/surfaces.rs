//! Surface files as other programs write them: STL, PLY, OBJ and OFF, as specimens and as grains.

use meso_core::aggregate::Reduction;
use meso_core::check::check;
use meso_core::geometry::convex_hull;
use meso_core::math::{Vec3, longest_distance};
use meso_core::packing::ReducedGrain;
use meso_core::spec::{Files, Spec};
use meso_core::specimen::Specimen;
use meso_core::{Silent, pack, saved};
use std::io;

type Facet = [[f64; 3]; 3];

/// One file of any name, and the remarks about it.
struct One {
    bytes: Vec<u8>,
    remarks: Vec<String>,
}

impl Files for One {
    fn read(&mut self, _: &str) -> io::Result<Vec<u8>> {
        Ok(self.bytes.clone())
    }

    fn list(&mut self, _: &str) -> io::Result<Vec<String>> {
        Err(io::Error::other("Not a directory"))
    }

    fn remark(&mut self, _: &str, remark: &str) {
        self.remarks.push(remark.to_owned());
    }
}

fn read(text: &str, bytes: Vec<u8>) -> Result<(Spec, String), String> {
    let mut files = One { bytes, remarks: Vec::new() };
    let spec = Spec::from_toml_with(text, &mut files).map_err(|error| error.to_string())?;
    Ok((spec, files.remarks.join("; ")))
}

const GRADING: &str = "fraction = 0.1\n[grading]\nd_min_mm = 4\nd_max_mm = 8\n";

/// Volume of the specimen in a file, mm3, and the remarks.
fn specimen(name: &str, bytes: Vec<u8>) -> Result<(f64, String), String> {
    let text = format!("{GRADING}[specimen]\nkind = 'mesh'\nfile = '{name}'\n");
    read(&text, bytes).map(|(spec, remarks)| (spec.specimen.volume(), remarks))
}

/// Number of grains in a file.
fn grains(name: &str, options: &str, bytes: Vec<u8>) -> Result<usize, String> {
    read(&format!("{GRADING}[shape]\nlibrary = '{name}'\n{options}"), bytes).map(|(spec, _)| spec.shape.grains.len())
}

const CUBE: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn cube_corner(k: usize, low: f64, side: f64) -> [f64; 3] {
    [k & 1, k >> 1 & 1, k >> 2].map(|bit| low + side * bit as f64)
}

/// A cube from `low` to `low + side` in each direction.
fn cube(low: f64, side: f64) -> Vec<Facet> {
    let corner = |k: usize| cube_corner(k, low, side);
    CUBE.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|t| t.map(corner)).collect()
}

/// An upright prism of `n` sides about the z axis.
fn cylinder(n: usize, radius: f64, height: f64) -> Vec<Facet> {
    let at = |k: usize, z: f64| {
        let angle = std::f64::consts::TAU * (k % n) as f64 / n as f64;
        [radius * angle.cos(), radius * angle.sin(), z]
    };
    let side = |k: usize| {
        let [a, b, c, d] = [at(k, 0.0), at(k + 1, 0.0), at(k + 1, height), at(k, height)];
        [[a, b, c], [a, c, d], [[0.0; 3], b, a], [[0.0, 0.0, height], d, c]]
    };
    (0..n).flat_map(side).collect()
}

fn prism_volume(n: usize, radius: f64, height: f64) -> f64 {
    n as f64 / 2.0 * radius * radius * (std::f64::consts::TAU / n as f64).sin() * height
}

fn stl_text(facets: &[Facet], name: &[u8]) -> Vec<u8> {
    let mut text = [b"solid ", name, b"\n"].concat();
    for facet in facets {
        text.extend(b"facet normal 0 0 0\nouter loop\n");
        for [x, y, z] in facet {
            text.extend(format!("vertex {x:e} {y:e} {z:e}\n").as_bytes());
        }
        text.extend(b"endloop\nendfacet\n");
    }
    [&text[..], b"endsolid ", name, b"\n"].concat()
}

fn stl_binary(facets: &[Facet], header: &[u8]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend((facets.len() as u32).to_le_bytes());
    for facet in facets {
        bytes.extend([0; 12]);
        facet.iter().flatten().for_each(|x| bytes.extend((*x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Every number times 1 + noise, or plus noise, by a generator of its own.
fn noisy(facets: &[Facet], noise: impl Fn(f64, f64) -> f64) -> Vec<Facet> {
    let mut state = 1_u64;
    let mut share = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
    };
    facets.iter().map(|facet| facet.map(|corner| corner.map(|x| noise(x, share())))).collect()
}

fn assert_volume(found: Result<(f64, String), String>, volume: f64, within: f64, remark: &str, case: &str) {
    let (found, remarks) = found.unwrap_or_else(|error| panic!("{case}: {error}"));
    assert!((found / volume - 1.0).abs() < within, "{case}: {found} for {volume}");
    let is_quiet = !["joined", "dropped", "ignored"].iter().any(|word| remarks.contains(word));
    assert!(remarks.contains(remark) && (!remark.is_empty() || is_quiet), "{case}: {remarks:?}");
}

/// The cases cyl_e16.stl and cyl_f32ulp.stl, and noise of other sizes.
#[test]
fn corners_that_differ_in_their_last_digits_are_joined() {
    let volume = prism_volume(24, 30.0, 60.0);
    let round = cylinder(24, 30.0, 60.0);
    for size in [1e-18, 1e-16, 1e-15, 1e-12, 1e-9, 1e-6, 1e-5] {
        let facets = noisy(&round, |x, share| x + size * share);
        assert_volume(specimen("a.stl", stl_text(&facets, b"")), volume, 1e-5, "joined", &format!("text, {size}"));
    }
    let ulp = |x: f64, share: f64| f64::from(if share > 0.6 { (x as f32).next_up() } else { x as f32 });
    assert_volume(specimen("a.stl", stl_binary(&noisy(&round, ulp), b"")), volume, 1e-5, "joined", "one ulp of f32");
    let far: Vec<Facet> = round.iter().map(|f| f.map(|[x, y, z]| [x + 3000.0, y - 2000.0, z])).collect();
    assert_volume(specimen("a.stl", stl_binary(&noisy(&far, ulp), b"")), volume, 1e-4, "joined", "far from the origin");
    assert_eq!(grains("a.stl", "", stl_text(&noisy(&round, |x, share| x + 1e-9 * share), b"")), Ok(1));
}

#[test]
fn holes_and_seams_wider_than_the_tolerance_stay_open() {
    let mut facets = cylinder(24, 30.0, 60.0);
    facets.pop();
    let error = specimen("a.stl", stl_text(&noisy(&facets, |x, share| x + 1e-12 * share), b"")).unwrap_err();
    assert!(error.contains("its surface is open: 3 edge(s)"), "{error}");
    let wide = noisy(&cylinder(24, 30.0, 60.0), |x, share| x + 0.01 * share);
    let error = specimen("a.stl", stl_text(&wide, b"")).unwrap_err();
    assert!(error.contains("its surface is open"), "{error}");
}

#[test]
fn corners_are_joined_only_where_no_edge_gets_a_third_triangle() {
    // Two cubes nearer to each other than the tolerance, each open nowhere: nothing is to be joined.
    let (low, high) = (cube(0.0, 20.0), cube(20.00001, 20.0));
    let (volume, remarks) = specimen("a.stl", stl_text(&[low, high].concat(), b"")).unwrap();
    assert!((volume - 16000.0).abs() < 1e-6 && !remarks.contains("joined"), "{volume} {remarks}");
}

/// A cube whose first triangle is split at the middle of an edge, which a triangle of no area closes.
fn sliver(turn: f64, middle: [f64; 3]) -> Vec<Facet> {
    let mut facets = cube(0.0, 60.0);
    let [a, b, c] = facets[0];
    let m = [0, 1, 2].map(|k| (a[k] + b[k]) / 2.0 + middle[k]);
    facets[0] = [a, m, c];
    facets.extend([[m, b, c], [a, b, m]]);
    let (sine, cosine) = turn.sin_cos();
    facets.iter().map(|f| f.map(|[x, y, z]| [cosine * x - sine * y, sine * x + cosine * y, z])).collect()
}

/// The case sl_edge.stl, turned, as text and binary.
#[test]
fn triangles_without_area_are_removed() {
    for turn in [0.0, 0.3, 0.5, 1.1, 2.2] {
        let facets = sliver(turn, [0.0; 3]);
        assert_volume(specimen("a.stl", stl_text(&facets, b"")), 216_000.0, 1e-9, "", &format!("text, {turn}"));
        assert_volume(specimen("a.stl", stl_binary(&facets, b"")), 216_000.0, 1e-6, "", &format!("binary, {turn}"));
        assert_eq!(grains("a.stl", "", stl_text(&facets, b"")), Ok(1), "{turn}");
    }
    let (_, remarks) = specimen("a.stl", stl_text(&sliver(0.0, [0.0; 3]), b"")).unwrap();
    assert!(remarks.contains("1 triangle(s) without area were removed"), "{remarks}");
}

#[test]
fn facets_written_twice_count_once_and_opposite_ones_not_at_all() {
    let cube = cube(0.0, 60.0);
    let turned = |[a, b, c]: Facet| [a, c, b];
    let shifted = |[a, b, c]: Facet| [b, c, a];
    let extra: [(&str, Vec<Facet>); 5] = [
        ("one twice", vec![cube[3]]),
        ("one three times", vec![cube[3], cube[3]]),
        ("from another corner", vec![shifted(cube[5])]),
        ("all twice", cube.clone()),
        ("a fin of two sides", vec![[cube[0][0], cube[0][1], [30.0; 3]], turned([cube[0][0], cube[0][1], [30.0; 3]])]),
    ];
    for (case, extra) in extra {
        assert_volume(
            specimen("a.stl", stl_text(&[cube.clone(), extra].concat(), b"")),
            216_000.0,
            1e-12,
            "dropped",
            case,
        );
    }
}

/// A closed band of `count` quadrilaterals about the z axis that turns over once, or not at all: a pipe.
fn band(count: usize, turns: bool) -> Vec<Facet> {
    let at = |k: usize, side: f64| {
        let angle = std::f64::consts::TAU * k as f64 / count as f64;
        let tilt = if turns { angle / 2.0 } else { std::f64::consts::FRAC_PI_2 };
        let radius = 20.0 + 5.0 * side * tilt.cos();
        [radius * angle.cos(), radius * angle.sin(), 5.0 * side * tilt.sin()]
    };
    let pair = |k: usize| {
        let [a, b] = [at(k, -1.0), at(k, 1.0)];
        let (c, d) = match (k + 1 == count, turns) {
            (false, _) => (at(k + 1, -1.0), at(k + 1, 1.0)),
            (true, false) => (at(0, -1.0), at(0, 1.0)),
            (true, true) => (at(0, 1.0), at(0, -1.0)),
        };
        [[a, b, d], [a, d, c]]
    };
    (0..count).flat_map(pair).collect()
}

#[test]
fn triangles_that_face_the_other_way_than_their_neighbours_are_turned() {
    let round = cylinder(24, 30.0, 60.0);
    let volume = prism_volume(24, 30.0, 60.0);
    for wrong in [&[5][..], &[0, 1, 2, 40], &(0..60).collect::<Vec<_>>()] {
        let mut facets = round.clone();
        wrong.iter().for_each(|&t| facets[t].swap(1, 2));
        let count = wrong.len().min(round.len() - wrong.len());
        let remark = format!("{count} triangle(s) that faced the other way than their neighbours were turned");
        assert_volume(specimen("a.stl", stl_text(&facets, b"")), volume, 1e-9, &remark, &remark);
        assert_eq!(grains("a.stl", "", stl_text(&facets, b"")), Ok(1), "{remark}");
    }
    // A band has ends, whether it has one side or two.
    for (turns, said) in [(false, "its surface is open"), (true, "two of opposite sides, meet in the edge")] {
        let error = grains("a.stl", "", stl_text(&band(30, turns), b"")).unwrap_err();
        assert!(error.contains(said), "{error}");
    }
}

/// The case latin1.stl, and other encodings.
#[test]
fn names_of_solids_may_be_in_any_encoding() {
    let names: [&[u8]; 7] = [
        b"Pr\xfcfk\xf6rper",
        b"\xca\xd4\xbc\xfe",
        b"\x93\xfa\x96{",
        "Prüfkörper".as_bytes(),
        b"vertex 1",
        b"my solid",
        b"\xff\xff",
    ];
    for name in names {
        let text = stl_text(&cube(0.0, 60.0), name);
        assert_volume(specimen("a.stl", text.clone()), 216_000.0, 1e-12, "", &format!("{name:?}"));
        assert_eq!(grains("a.stl", "", text), Ok(1), "{name:?}");
    }
    let text = String::from_utf8(stl_text(&cube(0.0, 60.0), b"a")).unwrap();
    let wide = |bytes: fn(u16) -> [u8; 2], mark: bool| -> Vec<u8> {
        let mark = mark.then_some('\u{feff}').into_iter().collect::<String>() + &text;
        mark.encode_utf16().flat_map(bytes).collect()
    };
    for (order, mark) in [
        (u16::to_le_bytes as fn(u16) -> [u8; 2], true),
        (u16::to_be_bytes, true),
        (u16::to_le_bytes, false),
        (u16::to_be_bytes, false),
    ] {
        let error = specimen("a.stl", wide(order, mark)).unwrap_err();
        assert!(error.contains("it is text in UTF-16; save it as ASCII or UTF-8"), "{error}");
    }
}

#[test]
fn text_is_read_word_by_word() {
    let text = String::from_utf8(stl_text(&cube(0.0, 60.0), b"a")).unwrap();
    let (cr, crlf, one, tabs) =
        (text.replace('\n', "\r"), text.replace('\n', "\r\n"), text.replace('\n', " "), text.replace(' ', "\t\t"));
    let (broken, capitals) = (text.replace("vertex ", "vertex\n"), text.to_uppercase());
    for text in [cr, crlf, one, tabs, broken, capitals, format!("\u{feff}{text}"), format!("\n\n  {text}\n\n")] {
        assert_volume(specimen("a.stl", text.into_bytes()), 216_000.0, 1e-12, "", "text");
    }
    for (bad, line) in
        [("vertex 1 2", 3), ("vertex 1 2 x", 3), ("vertex 1 2 3 4", 3), ("vertex 1,5 2 3", 3), ("vertex", 3)]
    {
        let text = format!("solid a\nfacet normal 0 0 1\n{bad}\nvertex 0 0 1\n");
        let error = specimen("a.stl", text.into_bytes()).unwrap_err();
        assert!(
            error.contains(&format!("line {line}: `vertex")) && error.contains("is not a vertex of three numbers"),
            "{error}"
        );
    }
}

/// The case bin_tail.stl, and other lengths.
#[test]
fn binary_files_may_be_a_few_bytes_longer_than_their_count() {
    let headers: [&[u8]; 3] = [b"solid cube", b"exported", b"\0\0\0"];
    for header in headers {
        for tail in [0, 1, 2, 4, 49] {
            let mut bytes = stl_binary(&cube(0.0, 60.0), header);
            bytes.extend(vec![7; tail]);
            let remark = if tail == 0 { "" } else { "after its 12 triangles were ignored" };
            assert_volume(specimen("a.stl", bytes), 216_000.0, 1e-12, remark, &format!("{header:?} {tail}"));
        }
        let mut uncounted = stl_binary(&cube(0.0, 60.0), header);
        uncounted[80..84].fill(0);
        assert_volume(specimen("a.stl", uncounted), 216_000.0, 1e-12, "its length says 12", "a count of 0");
        let whole = stl_binary(&cube(0.0, 60.0), header);
        for length in [whole.len() - 1, whole.len() - 50, 100] {
            let error = specimen("a.stl", whole[..length].to_vec()).unwrap_err();
            let part = format!("its count, at byte 80, is 12 triangles, which take 684 bytes; it has {length}");
            assert!(error.contains(&part), "{error}");
        }
    }
}

/// The case two_solids.stl, and other ways to write several bodies.
#[test]
fn several_bodies_in_a_file_are_several_grains() {
    let bodies = [cube(0.0, 5.0), cube(20.0, 3.0), cube(40.0, 8.0)];
    let all = bodies.concat();
    let blocks: Vec<u8> = bodies.iter().flat_map(|body| stl_text(body, b"body")).collect();
    let unnamed: Vec<u8> = bodies.iter().flat_map(|body| stl_text(body, b"")).collect();
    // One block for each side of each cube.
    let sides: Vec<u8> = all.chunks(2).flat_map(|side| stl_text(side, b"side")).collect();
    // Bodies of blocks of their own may touch.
    let touching: Vec<u8> =
        [cube(0.0, 5.0), cube(5.0, 5.0), cube(10.0, 2.0)].iter().flat_map(|body| stl_text(body, b"")).collect();
    for (case, bytes) in [
        ("blocks", blocks),
        ("unnamed", unnamed),
        ("sides", sides),
        ("touching", touching),
        ("one block", stl_text(&all, b"all")),
        ("binary", stl_binary(&all, b"")),
        ("one line", stl_text(&all, b"a b").iter().map(|&b| if b == b'\n' { b' ' } else { b }).collect()),
    ] {
        assert_eq!(grains("a.stl", "", bytes), Ok(3), "{case}");
    }
    assert_eq!(grains("a.ply", "", ply(&all, "ascii")), Ok(3));
    assert_eq!(grains("a.obj", "", obj(&all)), Ok(3));
}

fn moved(facets: Vec<Facet>, [x, y, z]: [f64; 3]) -> Vec<Facet> {
    facets.iter().map(|facet| facet.map(|corner| [corner[0] + x, corner[1] + y, corner[2] + z])).collect()
}

fn turned(facets: &[Facet]) -> Vec<Facet> {
    facets.iter().map(|&[a, b, c]| [a, c, b]).collect()
}

#[test]
fn bodies_that_touch_in_a_corner_an_edge_or_a_face_are_several_grains() {
    let read_all = |facets: &[Facet]| {
        [
            grains("a.stl", "", stl_text(facets, b"")),
            grains("a.stl", "hull = true\n", stl_binary(facets, b"")),
            grains("a.ply", "", ply(facets, "binary_big_endian")),
            grains("a.obj", "", obj(facets)),
            grains("a.off", "", off(facets)),
        ]
    };
    for by in [[5.0, 5.0, 5.0], [5.0, -5.0, 0.0], [0.0, 5.0, 0.0]] {
        let two = [cube(0.0, 5.0), moved(cube(0.0, 5.0), by)].concat();
        assert_eq!(read_all(&two), [const { Ok(2) }; 5], "{by:?}");
        assert_eq!(read_all(&turned(&two)), [const { Ok(2) }; 5], "{by:?}");
    }
    // One body whose own parts meet in an edge, which no grain may: cubes at two corners of an arch.
    let parts = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
    let all: Vec<Facet> = parts.iter().flat_map(|at| moved(cube(0.0, 1.0), *at)).collect();
    let same = |p: &Facet, q: &Facet| p.iter().all(|corner| q.contains(corner));
    let is_inner = |p: &Facet| all.iter().filter(|q| same(p, q)).count() > 1;
    // Faces between two cubes have the same diagonals, since opposite sides of a cube have.
    let arch: Vec<Facet> = all.iter().filter(|facet| !is_inner(facet)).copied().collect();
    let error = grains("a.stl", "", stl_text(&arch, b"")).unwrap_err();
    assert!(error.contains("meet in the edge from [1.0, 1.0, ") && arch.len() == 44, "{} {error}", arch.len());
}

#[test]
fn a_hollow_is_filled_with_a_remark_and_a_body_within_it_is_refused() {
    let library = |facets: &[Facet], options: &str| {
        let text = format!("{GRADING}[shape]\nlibrary = 'a.stl'\n{options}");
        read(&text, stl_text(facets, b"")).map(|(spec, remarks)| (spec.shape.grains.len(), remarks))
    };
    let hollow = [turned(&cube(2.0, 4.0)), cube(0.0, 10.0)].concat();
    for options in ["", "hull = true\n"] {
        let (count, remarks) = library(&hollow, options).unwrap();
        assert_eq!((count, remarks.as_str()), (1, "1 hollow(s), 6.40 % of the volume, were filled"), "{options}");
    }
    let (count, remarks) = library(&turned(&hollow), "").unwrap();
    assert!(count == 1 && remarks.contains("were turned; 1 hollow(s)"), "{remarks}");
    let within = [hollow.clone(), cube(3.0, 1.0)].concat();
    let error = library(&within, "").unwrap_err();
    assert!(error.contains("body 2 of 3, counted from 0, lies within body 1"), "{error}");
    let inward = [hollow.clone(), turned(&cube(20.0, 1.0))].concat();
    let error = library(&inward, "").unwrap_err();
    assert!(error.contains("body 2 of 3, counted from 0: it encloses -1 mm3; its triangles must be"), "{error}");
}

/// An upright prism over an L, its sides and ends polygons, by their corners.
fn angle() -> (Vec<[f64; 3]>, Vec<Vec<usize>>) {
    let outline = [[0.0, 0.0], [60.0, 0.0], [60.0, 20.0], [20.0, 20.0], [20.0, 60.0], [0.0, 60.0]];
    let vertices = [0.0, 30.0].iter().flat_map(|z| outline.map(|[x, y]| [x, y, *z])).collect();
    let sides = (0..6).map(|k| vec![k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6]);
    (vertices, sides.chain([(0..6).rev().collect(), (6..12).collect()]).collect())
}

#[test]
fn concave_polygons_are_divided_within_their_outline_wherever_they_begin() {
    let (vertices, mut faces) = angle();
    let rows: String = vertices.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    for _ in 0..6 {
        faces.iter_mut().for_each(|face| face.rotate_left(1));
        let listed = |from: usize, begin: &dyn Fn(usize) -> String| -> String {
            let row = |face: &Vec<usize>| {
                let corners: Vec<String> = face.iter().map(|corner| (corner + from).to_string()).collect();
                format!("{}{}\n", begin(face.len()), corners.join(" "))
            };
            faces.iter().map(row).collect()
        };
        let counted = listed(0, &|count| format!("{count} "));
        let obj =
            format!("{}{}", rows.lines().map(|l| format!("v {l}\n")).collect::<String>(), listed(1, &|_| "f ".into()));
        let head = "ply\nformat ascii 1.0\nelement vertex 12\nproperty float x\nproperty float y\nproperty float z\n\
                    element face 8\nproperty list uchar int vertex_indices\nend_header\n";
        for (name, text) in [
            ("a.obj", obj),
            ("a.off", format!("OFF\n12 8 0\n{rows}{counted}")),
            ("a.ply", format!("{head}{rows}{counted}")),
            ("a.json", format!("[{{\"vertices\": {vertices:?}, \"faces\": {faces:?}}}]")),
        ] {
            let text_of_spec = format!("{GRADING}[shape]\nlibrary = '{name}'\n");
            let (spec, remarks) =
                read(&text_of_spec, text.clone().into_bytes()).unwrap_or_else(|e| panic!("{name}: {e}"));
            let stone = &spec.shape.grains[0];
            // Between corners 60, 60 and 30 mm apart; the hull of an L has a cut corner.
            let expected = 60_000.0 / (3600.0_f64 + 3600.0 + 900.0).powf(1.5);
            assert!(stone.dents().is_some() && (stone.relative_volume() / expected - 1.0).abs() < 1e-9, "{name}");
            assert_eq!(remarks, "", "{name}");
            if name != "a.json" {
                assert_volume(specimen(name, text.into_bytes()), 60_000.0, 1e-9, "", name);
            }
        }
    }
    let bent = "v 0 0 0\nv 1 0 0\nv 1 1 0.3\nv 0 1 0\nv 0.5 0.5 2\nf 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
    let (_, remarks) = read(&format!("{GRADING}[shape]\nlibrary = 'a.obj'\n"), bent.into()).unwrap();
    assert!(remarks.contains("1 polygon(s) are not plane, by up to 4.9 %"), "{remarks}");
}

/// An egg of some 24,000 triangles with a dent, which its hull has not.
fn egg() -> Vec<Facet> {
    let (rows, columns) = (100, 120);
    let corner = |row: usize, column: usize| {
        let (polar, around) = (
            std::f64::consts::PI * row as f64 / rows as f64,
            std::f64::consts::TAU * (column % columns) as f64 / columns as f64,
        );
        let u = [polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos()];
        let dent = 1.0 - 0.3 * (-12.0 * (1.0 - u[0])).exp();
        if row.is_multiple_of(rows) {
            [0.0, 0.0, 10.0 * u[2]]
        } else {
            [7.0 * u[0] * dent, 6.0 * u[1] * dent, 10.0 * u[2] * dent]
        }
    };
    let square = |(row, column): (usize, usize)| {
        let [a, b, c, d] =
            [corner(row, column), corner(row + 1, column), corner(row + 1, column + 1), corner(row, column + 1)];
        [[a, b, c], [a, c, d]]
    };
    let all = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))).flat_map(square);
    all.filter(|[a, b, c]| a != b && b != c && c != a).collect()
}

#[test]
fn remarks_about_one_of_several_bodies_have_its_number() {
    let remarks = |options: &str, bytes: Vec<u8>| {
        let text = format!("{GRADING}[shape]\nlibrary = {options}\n");
        read(&text, bytes).unwrap().1
    };
    let (small, scan) = (cube(20.0, 4.0), egg());
    let within = "it has 2 bodies, and each is a grain of equal right; body 1 of 2, counted from 0: ";
    let said = remarks("'a.stl'", stl_binary(&[&small[..], &scan].concat(), b""));
    assert!(said.starts_with(within) && said.contains(" triangles became "), "{said}");
    let said = remarks("'a.stl'\nhull = true", stl_binary(&[&small[..], &scan].concat(), b""));
    assert!(said.starts_with(within) && said.contains(" corners of its hull became "), "{said}");
    // A hollow counts as a body of the file.
    let three = [&cube(0.0, 30.0)[..], &turned(&cube(1.0, 2.0)), &moved(scan.clone(), [60.0, 0.0, 0.0])].concat();
    let said = remarks("'a.stl'", stl_binary(&three, b""));
    assert!(said.contains("hollow(s)") && said.contains("; body 2 of 3, counted from 0: "), "{said}");
    // One solid of a text, mended: a triangle that stands there twice.
    let twice = [&small[..], &small[..1]].concat();
    let solids = [stl_text(&cube(0.0, 5.0), b"a"), stl_text(&twice, b"b")].concat();
    let said = remarks("'a.stl'", solids);
    let mended = "body 1 of 2, counted from 0: 1 triangle(s) that stood there twice were dropped; ";
    assert!(said.starts_with(mended), "{said}");
    assert!(!remarks("'a.stl'", stl_text(&twice, b"b")).contains("body"));
    let (vertices, faces) = indexed(&scan);
    let said = remarks(
        "'a.json'",
        format!(
            "[[[0,0,0],[1,0,0],[0,1,0],[0,0,1]], {{\"name\": \"egg\", \"vertices\": {vertices:?}, \"faces\": {faces:?}}}]"
        )
        .into_bytes(),
    );
    assert!(said.starts_with("egg: ") && said.contains(" triangles became "), "{said}");
}

#[test]
fn the_report_and_the_saved_spec_have_what_a_reduction_cost() {
    let scan = egg();
    let text = |options: &str| {
        format!(
            "fraction = 0.1\nspecimen = {{ kind = 'cube', side_mm = 30 }}\n[grading]\nd_min_mm = 4\nd_max_mm = 8\n\
             [shape]\nlibrary = 'a.stl'\n{options}"
        )
    };
    let two = stl_binary(&[&cube(20.0, 4.0)[..], &scan].concat(), b"");
    let volume =
        |mesh: &[Facet]| mesh.iter().map(|t| t.map(Vec3::from)).map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum::<f64>();
    for (options, is_hull) in [("tolerance = 0.01", false), ("hull = true", true)] {
        let (spec, said) = read(&text(options), two.clone()).unwrap();
        let model = pack(&spec, &Silent).unwrap();
        let [ReducedGrain { grain, reduction }] = model.report.reduced[..] else {
            panic!("{:?}", model.report.reduced)
        };
        assert!(said.contains(&format!("its volume changed by {:+.2} %", 100.0 * reduction.volume_change)), "{said}");
        assert_eq!((grain, reduction.distance), (1, if is_hull { 0.005 } else { 0.01 }));
        let template = &spec.shape.grains[1];
        if !is_hull {
            let length = longest_distance(template.vertices());
            let left = template.relative_volume() * length.powi(3) / volume(&scan) - 1.0;
            assert!((left - reduction.volume_change).abs() < 1e-6, "{left} {reduction:?}");
            assert_eq!(reduction.scanned_triangles, scan.len());
        }
        let Reduction { scanned_triangles, triangles, volume_change, .. } = reduction;
        assert!(triangles < scanned_triangles / 10 && volume_change.abs() < 0.05, "{reduction:?}");
        let mut bytes = Vec::new();
        saved::write(&model, &mut bytes).unwrap();
        let read = saved::read(&bytes).unwrap();
        assert!(read.spec == spec && read.report.reduced == model.report.reduced);
        assert!(check(&read).is_sound(), "{:?}", check(&read).findings);
        let sentence = read.report.cost_of_reductions().unwrap();
        assert!(sentence.starts_with("scans in fewer triangles, 1 of the library's grains: within "), "{sentence}");
    }
    let (spec, _) = read(&text(""), stl_binary(&cube(20.0, 4.0), b"")).unwrap();
    let report = pack(&spec, &Silent).unwrap().report;
    assert!(report.reduced.is_empty() && report.cost_of_reductions().is_none());
}

#[test]
fn shares_in_remarks_have_no_digits_of_rounding() {
    for (share, percent) in [("0.0007", "0.07"), ("0.0029", "0.29")] {
        let text = format!("{GRADING}[shape]\nlibrary = 'a.stl'\ntolerance = {share}\n");
        let said = read(&text, stl_binary(&egg(), b"")).unwrap().1;
        assert!(said.contains(&format!("mm away ({percent} % of its length)")), "{said}");
    }
    let error = read(&GRADING.replace("0.1", "55.3"), Vec::new()).unwrap_err();
    assert!(error.contains("for 55.3 % write 0.553"), "{error}");
}

/// One cube in every format of surfaces that is read, by its ending.
fn in_all_formats() -> [(&'static str, Vec<u8>); 7] {
    let facets = cube(0.0, 5.0);
    [
        ("stl", stl_text(&facets, b"a")),
        ("stl", stl_binary(&facets, b"solid")),
        ("ply", ply(&facets, "ascii")),
        ("ply", ply(&facets, "binary_little_endian")),
        ("obj", obj(&facets)),
        ("off", off(&facets)),
        ("json", b" [[[0,0,0],[1,0,0],[0,1,0],[0,0,1]]]".to_vec()),
    ]
}

#[test]
fn a_file_named_as_another_format_is_refused_with_the_name_that_it_needs() {
    for (own, bytes) in in_all_formats() {
        for said in ["stl", "ply", "obj", "off", "json"] {
            let found = grains(&format!("a.{said}"), "", bytes.clone());
            if said == own {
                assert_eq!(found, Ok(1), "{own}");
                continue;
            }
            let error = found.unwrap_err();
            assert!(error.ends_with(&format!(" file does; let its name end in .{own}")), "{own} as {said}: {error}");
            let harmonics = grains("a.dat", "kind = 'harmonics'\n", bytes.clone()).unwrap_err();
            let other = ", which is not read here: name one that ends in .dat, .anm or .txt";
            assert!(harmonics.ends_with(other), "{own}: {harmonics}");
            if own != "json" && said != "json" {
                let error = specimen(&format!("a.{said}"), bytes.clone()).unwrap_err();
                assert!(error.ends_with(&format!("let its name end in .{own}")), "{own} as {said}: {error}");
            }
        }
    }
    for (bytes, words) in [
        (&b"\x1f\x8b\x08\0"[..], "it begins as a gzip file does; unpack it first"),
        (b"PK\x03\x04", "it begins as a ZIP file does; unpack it first"),
        (b"glTF\x02\0\0\0", "it begins as a glTF file does, which is not read here: name one that ends in .stl, "),
        (b"0 0 29.2 0\n1 1 0.1 0\n", "it begins as a harmonics file does, which is not read here"),
        (b"\x93NUMPY\x01\0", "it begins as a NumPy file does, which is not read here"),
    ] {
        for ending in ["stl", "ply", "obj", "off", "json"] {
            let error = grains(&format!("a.{ending}"), "", bytes.to_vec()).unwrap_err();
            assert!(error.contains(words), "{ending}: {error}");
        }
    }
    // Files of unknown content, and damaged ones of the named format, have the errors of their format.
    for bytes in [&b"solid a\nfacet"[..], b"hello", b""] {
        let error = grains("a.stl", "", bytes.to_vec()).unwrap_err();
        assert!(!error.contains("it begins as"), "{error}");
    }
}

#[test]
fn the_hull_of_a_scan_has_few_corners_and_small_hulls_keep_theirs() {
    let scan = egg();
    assert!(scan.len() > 20_000);
    let stone = |options: &str| {
        let text = format!("{GRADING}[shape]\nlibrary = 'a.stl'\nhull = true\n{options}");
        let (mut spec, remarks) = read(&text, stl_binary(&scan, b"")).unwrap();
        (spec.shape.grains.remove(0), remarks)
    };
    let (whole, said) = stone("tolerance = 0\n");
    assert_eq!(said, "");
    let (usual, said) = stone("");
    assert!(
        said.contains(" corners of its hull became ") && said.contains("nowhere more than 0.100 mm away (0.5 % of"),
        "{said}"
    );
    assert!(whole.vertices().len() > 9000 && usual.vertices().len() < 700, "{}", usual.vertices().len());
    let [before, after] = [&whole, &usual].map(|stone| convex_hull(stone.vertices()).unwrap().volume());
    let lost = 1.0 - after / before;
    assert!(said.contains(&format!("its volume changed by {:+.2} %", -100.0 * lost)) && lost < 0.025, "{lost} {said}");
    assert!(usual.vertices().iter().all(|corner| whole.vertices().contains(corner)));
    let (rough, _) = stone("tolerance = 0.05\n");
    assert!(rough.vertices().len() < 100 && rough.relative_volume() < usual.relative_volume());
    // A list of vertices is a hull, too.
    let (vertices, _) = indexed(&scan);
    let corners = |options: &str| {
        let text = format!("{GRADING}[shape]\nlibrary = 'a.json'\n{options}");
        read(&text, format!("[{vertices:?}]").into_bytes()).unwrap().0.shape.grains[0].vertices().len()
    };
    assert!(corners("tolerance = 0.05\n") < 100 && corners("tolerance = 0\n") > 9000);
    let round = cylinder(24, 30.0, 60.0);
    let text = format!("{GRADING}[shape]\nlibrary = 'a.stl'\nhull = true\n");
    let (spec, said) = read(&text, stl_text(&round, b"")).unwrap();
    assert_eq!((spec.shape.grains[0].vertices().len(), said.as_str()), (48, ""));
}

#[test]
fn a_nearly_flat_stone_is_refused_by_its_name_and_thickness() {
    let slab = |thickness: f64| -> Vec<Facet> {
        cube(0.0, 10.0).iter().map(|facet| facet.map(|[x, y, z]| [x, y, z * thickness / 10.0])).collect()
    };
    let two = |thickness: f64| [cube(20.0, 4.0), slab(thickness)].concat();
    let error = grains("a.stl", "", stl_text(&two(0.001), b"")).unwrap_err();
    let part = "body 1 of 2, counted from 0: it is nearly flat, 7.1e-5 of its length thick, and a grain needs 0.001";
    assert!(error.contains(part), "{error}");
    assert_eq!(grains("a.stl", "", stl_text(&two(0.02), b"")), Ok(2));
    // Thin ones make for many grains.
    let text = "fraction = 0.1\n[specimen]\nkind = 'cube'\nside_mm = 2000\n[grading]\nd_min_mm = 4\nd_max_mm = 8\n[shape]\nlibrary = 'a.stl'\n";
    let error = read(text, stl_text(&slab(0.02), b"")).unwrap_err();
    assert!(error.contains("; grain 0 of the library, counted from 0, is 1.4e-3 of its length thick"), "{error}");
}

#[test]
fn grains_that_are_not_convex_count_as_their_hulls_on_request() {
    let mut dented = cube(0.0, 10.0);
    // The middle of a side, pushed in.
    let [a, b, c] = dented.remove(0);
    let [_, _, d] = dented.remove(0);
    dented.extend([[a, b], [b, c], [c, d], [d, a]].map(|[p, q]| [p, q, [5.0, 5.0, 2.0]]));
    let two = [dented.clone(), cube(30.0, 4.0)].concat();
    let dents = |options: &str| {
        let text = format!("{GRADING}[shape]\nlibrary = 'a.stl'\n{options}");
        let (spec, _) = read(&text, stl_text(&two, b"")).unwrap();
        spec.shape.grains.iter().map(|grain| grain.dents().is_some()).collect::<Vec<_>>()
    };
    assert_eq!((dents(""), dents("hull = true\n")), (vec![true, false], vec![false, false]));
    for bytes in [stl_text(&two, b""), stl_binary(&two, b"")] {
        assert_eq!(grains("a.stl", "hull = true\n", bytes), Ok(2));
    }
    assert_eq!(grains("a.ply", "hull = true\n", ply(&two, "ascii")), Ok(2));
    assert_eq!(grains("a.off", "hull = true\n", off(&dented)), Ok(1));
    let inward: Vec<Facet> = two.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let (spec, remarks) = read(&format!("{GRADING}[shape]\nlibrary = 'a.stl'\n"), stl_text(&inward, b"")).unwrap();
    assert!(spec.shape.grains.len() == 2 && remarks.contains("clockwise seen from outside; they were turned"));
    let open = b"[{\"vertices\": [[0,0,0],[3,0,0],[0,2,0],[0,0,2]], \"faces\": [[0,2,1]]}]";
    assert_eq!(grains("a.json", "hull = true\n", open.to_vec()), Ok(1));
    let error = grains("a.stl", "hull = 1\n", stl_text(&two, b"")).unwrap_err();
    assert!(error.contains("shape.hull is 1; it must be true or false"), "{error}");
    let error = read("[shape]\nhull = true\n", Vec::new()).unwrap_err();
    assert!(error.contains("shape.hull counts only for a library"), "{error}");
}

/// Vertices and triangles, shared.
fn indexed(facets: &[Facet]) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let mut vertices: Vec<[f64; 3]> = Vec::new();
    let mut index = |corner: &[f64; 3]| {
        vertices.iter().position(|v| v == corner).unwrap_or_else(|| {
            vertices.push(*corner);
            vertices.len() - 1
        })
    };
    let triangles = facets.iter().map(|facet| [index(&facet[0]), index(&facet[1]), index(&facet[2])]).collect();
    (vertices, triangles)
}

fn ply(facets: &[Facet], form: &str) -> Vec<u8> {
    let (vertices, triangles) = indexed(facets);
    let mut bytes = format!(
        "ply\nformat {form} 1.0\ncomment by hand\nelement vertex {}\nproperty uchar red\nproperty double x\nproperty float y\nproperty double z\n\
         property list uchar short tags\nelement face {}\nproperty list uint int vertex_index\nproperty uchar grey\nelement edge 1\n\
         property int vertex1\nend_header\n",
        vertices.len(),
        triangles.len()
    )
    .into_bytes();
    if form == "ascii" {
        vertices.iter().for_each(|[x, y, z]| bytes.extend(format!("7 {x} {y} {z} 2 -1 5\n").as_bytes()));
        triangles.iter().for_each(|[a, b, c]| bytes.extend(format!("3 {a} {b} {c} 9\n").as_bytes()));
        bytes.extend(b"3\n");
        return bytes;
    }
    let mut push = |little: &[u8]| match form {
        "binary_little_endian" => bytes.extend(little),
        _ => bytes.extend(little.iter().rev()),
    };
    for [x, y, z] in vertices {
        push(&[7]);
        push(&x.to_le_bytes());
        push(&(y as f32).to_le_bytes());
        push(&z.to_le_bytes());
        push(&[2]);
        push(&(-1_i16).to_le_bytes());
        push(&5_i16.to_le_bytes());
    }
    for triangle in triangles {
        push(&3_u32.to_le_bytes());
        triangle.iter().for_each(|&corner| push(&(corner as i32).to_le_bytes()));
        push(&[9]);
    }
    push(&3_i32.to_le_bytes());
    bytes
}

fn obj(facets: &[Facet]) -> Vec<u8> {
    let (vertices, triangles) = indexed(facets);
    let mut text = "# by hand\nmtllib a.mtl\no body\nvn 0 0 1\n".to_owned();
    vertices.iter().for_each(|[x, y, z]| text += &format!("v {x} {y} {z} 1.0\n"));
    triangles.iter().for_each(|[a, b, c]| text += &format!("f {} {}/1/1 {}//1\n", a + 1, b + 1, c + 1));
    text.into_bytes()
}

fn off(facets: &[Facet]) -> Vec<u8> {
    let (vertices, triangles) = indexed(facets);
    let mut text = format!("OFF # by hand\n\n{} {} 0\n", vertices.len(), triangles.len());
    vertices.iter().for_each(|[x, y, z]| text += &format!("{x} {y} {z}\n"));
    triangles.iter().for_each(|[a, b, c]| text += &format!("3 {a} {b} {c} 255 0 0\n"));
    text.into_bytes()
}

#[test]
fn specimens_and_grains_are_read_from_ply_obj_and_off() {
    let round = cylinder(12, 20.0, 40.0);
    let (volume, text) = (prism_volume(12, 20.0, 40.0), |bytes: Vec<u8>| String::from_utf8(bytes).unwrap());
    let quads = CUBE.iter().map(|f| format!("4 {} {} {} {}\n", f[0], f[1], f[2], f[3])).collect::<String>();
    let corners: String = (0..8).map(|k| cube_corner(k, 0.0, 60.0).map(|x| x.to_string()).join(" ") + "\n").collect();
    let back = |f: &[usize; 4]| {
        format!("f {}\\\n {} {} {}\n", f[0] as i32 - 8, f[1] as i32 - 8, f[2] as i32 - 8, f[3] as i32 - 8)
    };
    let backwards = format!(
        "{}{}",
        corners.lines().map(|l| format!("V {l}\n")).collect::<String>(),
        CUBE.iter().map(back).collect::<String>().replace("\\\n", " \\\n")
    );
    let cases: [(&str, Vec<u8>, f64); 12] = [
        ("a.ply", ply(&round, "ascii"), volume),
        ("a.PLY", ply(&round, "binary_little_endian"), volume),
        ("a.ply", ply(&round, "binary_big_endian"), volume),
        ("a.ply", text(ply(&round, "ascii")).replace('\n', "\r\n").into_bytes(), volume),
        ("a.ply", text(ply(&round, "ascii")).replace('\n', "\r").into_bytes(), volume),
        ("a.obj", obj(&round), volume),
        ("a.obj", text(obj(&round)).replace('\n', "\r\n").into_bytes(), volume),
        ("a.obj", backwards.into_bytes(), 216_000.0),
        ("a.off", off(&round), volume),
        ("a.Off", format!("OFF 8 6 12\n{corners}{quads}").into_bytes(), 216_000.0),
        (
            "a.off",
            format!("\u{feff}COFF\n8 6 12\n{}{quads}", corners.replace('\n', " 1 0 0 1\n")).into_bytes(),
            216_000.0,
        ),
        ("a.off", text(off(&round)).replace('\n', "\r").into_bytes(), volume),
    ];
    for (i, (name, bytes, volume)) in cases.into_iter().enumerate() {
        assert_volume(specimen(name, bytes.clone()), volume, 1e-6, "", &format!("{i}: {name}"));
        assert_eq!(grains(name, "", bytes), Ok(1), "{i}: {name}");
    }
}

#[test]
fn broken_ply_obj_and_off_are_refused_with_the_reason() {
    let cut = |bytes: Vec<u8>, less: usize| bytes[..bytes.len() - less].to_vec();
    let cube = cube(0.0, 60.0);
    let head =
        "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nelement face 4000000000\nend_header\n0\n";
    for (name, bytes, part) in [
        ("a.ply", cut(ply(&cube, "binary_big_endian"), 40), "it ends within its faces"),
        ("a.ply", head.into(), "it ends within its vertices"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex x\n".to_vec(), "line 3 of its header, `element vertex x`"),
        ("a.ply", b"solid a\n".to_vec(), "it must begin with a line `ply`"),
        ("a.ply", b"ply\nformat utf8 1.0\nend_header\n".to_vec(), "its format is not ascii"),
        ("a.ply", b"ply\nformat ascii 1.0\n".to_vec(), "has no end_header"),
        ("a.obj", b"v 0 0 0\nf 1 2 3\n".to_vec(), "names vertex 1 of 1"),
        ("a.obj", b"v 0 0\n".to_vec(), "line 1: `v 0 0` is not a vertex of three numbers"),
        ("a.obj", b"v 0 0 0\nf 0 1 1\n".to_vec(), "line 2: `f 0 1 1` is not a face of whole numbers"),
        ("a.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec(), "is not finite"),
        ("a.obj", b"".to_vec(), "it has no triangles"),
        ("a.off", b"4OFF\n".to_vec(), "it ends within its head"),
        ("a.off", b"6OFF\n".to_vec(), "it must begin with OFF"),
        ("a.off", b"OFF BINARY\n".to_vec(), "it is binary; save it as text"),
        ("a.off", b"OFF\n4 4\n0 0 0\n".to_vec(), "it ends within its vertices"),
        ("a.off", b"OFF\n1 1 0\n0 0 0\n3 0 0 7\n".to_vec(), "names vertex 7 of 1"),
        ("a.off", b"OFF\n1 1 0\n0 0 0\n3 0 0\n".to_vec(), "line 4: `3 0 0` is not a face"),
        ("a.step", b"ISO-10303-21;\n".to_vec(), "its name must end in .stl, .ply, .obj or .off"),
        ("a.step", stl_text(&cube, b""), "it begins as an STL file does; let its name end in .stl"),
        ("part", stl_text(&cube, b""), "it begins as an STL file does; let its name end in .stl"),
    ] {
        let error = specimen(name, bytes).unwrap_err();
        assert!(error.contains(part), "{name}: {error}");
    }
    let error = grains("a.step", "", Vec::new()).unwrap_err();
    assert!(error.contains("a file of grains ends in .stl, .ply, .obj, .off or .json"), "{error}");
}

/// The case far_overlap.stl, and other faults far from the origin.
#[test]
fn faults_are_located_in_the_frame_of_the_file() {
    let far = |facets: Vec<Facet>| -> Vec<Facet> {
        facets.iter().map(|f| f.map(|[x, y, z]| [x + 1000.0, y + 2000.0, z + 3000.0])).collect()
    };
    let inverted: Vec<Facet> = cube(20.0, 20.0);
    let open: Vec<Facet> = cube(0.0, 60.0)[1..].to_vec();
    for (facets, part) in [
        (
            far([cube(0.0, 60.0), cube(30.0, 60.0)].concat()),
            "are not the surface of a body: its surface crosses itself near (10",
        ),
        (far([cube(0.0, 60.0), inverted].concat()), "at (1020, 2020, 3020), is nested the wrong way"),
        (far(open), "the first from [1000.0, 2000.0, 3000.0]"),
    ] {
        let error = specimen("a.stl", stl_text(&facets, b"")).unwrap_err();
        assert!(error.contains(part), "{error}");
        let (vertices, triangles) = indexed(&facets);
        let text =
            format!("{GRADING}[specimen]\nkind = 'mesh'\nvertices_mm = {vertices:?}\ntriangles = {triangles:?}\n");
        let error = read(&text, Vec::new()).unwrap_err();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn the_report_has_the_origin_of_a_specimen_that_was_moved() {
    let far: Vec<Facet> =
        cube(0.0, 30.0).iter().map(|f| f.map(|[x, y, z]| [x + 1000.0, y - 2000.0, z + 0.5])).collect();
    let text = format!("{GRADING}[specimen]\nkind = 'mesh'\nfile = 'a.stl'\n");
    let (spec, remarks) = read(&text, stl_text(&far, b"")).unwrap();
    assert!(remarks.contains("its lowest corner, (1000, -2000, 0.5) mm, is the origin of the packing"), "{remarks}");
    let model = meso_core::pack(&spec, &meso_core::Silent).unwrap();
    assert_eq!(model.report.specimen.origin_mm, Some([1000.0, -2000.0, 0.5]));
    let mut bytes = Vec::new();
    meso_core::saved::write(&model, &mut bytes).unwrap();
    assert_eq!(meso_core::saved::read(&bytes).unwrap().report.specimen.origin_mm, model.report.specimen.origin_mm);
    let (spec, remarks) = read(&text, stl_text(&cube(0.0, 30.0), b"")).unwrap();
    assert_eq!((spec.specimen.origin(), remarks.as_str()), (None, ""));
}

#[test]
fn a_scale_turns_other_units_into_millimetres() {
    for (side, scale, volume) in [
        (0.15, "1000", 3_375_000.0),
        (6.0, "25.4", 3_539_605.824),
        (60.0, "1", 216_000.0),
        (150_000.0, "0.001", 3_375_000.0),
        (15.0, "10.0", 3_375_000.0),
    ] {
        let text = format!("{GRADING}[specimen]\nkind = 'mesh'\nfile = 'a.stl'\nscale = {scale}\n");
        let (spec, _) = read(&text, stl_text(&cube(0.0, side), b"")).unwrap();
        assert!((spec.specimen.volume() / volume - 1.0).abs() < 1e-9, "{side}");
        assert!(matches!(spec.specimen, Specimen::Mesh { .. }));
    }
    for (side, hint) in [
        (0.15, "looks like metres: give specimen.scale = 1000"),
        (6.0, "looks like inches: give specimen.scale = 25.4"),
    ] {
        let error = specimen("a.stl", stl_text(&cube(0.0, side), b"")).unwrap_err();
        assert!(error.contains("grading.d_max_mm is 8 but") && error.contains(hint), "{error}");
    }
    for (scale, part) in [
        ("0", "specimen.scale is 0; the accepted range"),
        ("'m'", "it must be a number: 1000 for metres"),
        ("nan", "specimen.scale is nan"),
    ] {
        let text = format!("{GRADING}[specimen]\nkind = 'mesh'\nfile = 'a.stl'\nscale = {scale}\n");
        let error = read(&text, stl_text(&cube(0.0, 60.0), b"")).unwrap_err();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn a_correct_file_keeps_its_corners_bit_by_bit() {
    let facets = cylinder(24, 30.0, 60.0);
    let text = format!("{GRADING}[specimen]\nkind = 'mesh'\nfile = 'a.stl'\n");
    let (spec, _) = read(&text, stl_text(&facets, b"")).unwrap();
    let Specimen::Mesh { vertices_mm, triangles, .. } = &spec.specimen else { panic!("a mesh") };
    let found: Vec<Facet> = triangles.iter().map(|t| t.map(|i| vertices_mm[i as usize])).collect();
    assert_eq!(found, facets);
    assert!(vertices_mm.iter().all(|v| Vec3::from(*v).norm() < 100.0));
}
