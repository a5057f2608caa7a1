//! Rounded gravel, crushed rock, a user's own grains.

use crate::pack::folder::Folder;
use meso_core::aggregate::{Aggregate, Kind};
use meso_core::export::stl;
use meso_core::geometry::{BodyForm, Polyhedron, convex_hull};
use meso_core::math::{Aabb, Vec3};
use meso_core::spec::Spec;
use meso_core::{Silent, check, pack};

const SMALL: &str = "fraction = 0.3\nspecimen = { kind = 'cube', side_mm = 60 }\n";

fn bodies(shape: &str) -> Vec<Polyhedron> {
    let spec = Spec::from_toml(&format!("{SMALL}[shape]\n{shape}")).unwrap_or_else(|error| panic!("{error}"));
    packed(&spec)
}

fn packed(spec: &Spec) -> Vec<Polyhedron> {
    let model = pack(spec, &Silent).unwrap();
    assert!((model.report.fraction - 0.3).abs() < 0.005, "{}", model.report.fraction);
    assert_eq!(check::check(&model).findings, []);
    model.aggregates.into_iter().map(|aggregate| aggregate.body).collect()
}

/// Wadell's: the area of the ball of the same volume over the body's own.
fn sphericity(body: &Polyhedron) -> f64 {
    let ball = (36.0 * std::f64::consts::PI * body.volume() * body.volume()).cbrt();
    ball / body.area()
}

fn mean(bodies: &[Polyhedron], of: impl Fn(&Polyhedron) -> f64) -> f64 {
    bodies.iter().map(of).sum::<f64>() / bodies.len() as f64
}

fn longest(body: &Polyhedron) -> f64 {
    let v = body.vertices();
    v.iter().flat_map(|p| v.iter().map(move |q| (p - q).norm())).fold(0.0, f64::max)
}

#[test]
fn gravel_is_rounder_than_the_papers_polyhedra_and_crushed_rock_is_sharper() {
    let round = mean(&bodies("kind = 'rounded'"), sphericity);
    let paper = mean(&bodies(""), sphericity);
    let crushed = mean(&bodies("kind = 'crushed'"), sphericity);
    assert!(round > 0.9 && round > paper + 0.05 && crushed < paper, "{round} {paper} {crushed}");
}

#[test]
fn rounded_grains_of_equal_axes_are_spheres_as_far_as_their_corners_allow() {
    let one = "{ law = 'constant', value = 1 }";
    for ball in bodies(&format!("kind = 'rounded'\nvertices = [200, 200]\nelongation = {one}\nflatness = {one}")) {
        let radius = longest(&ball) / 2.0;
        let sphere = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        assert!(ball.volume() > 0.94 * sphere, "{} of {sphere}", ball.volume());
    }
}

#[test]
fn the_longest_axis_of_every_kind_lies_in_its_class() {
    for kind in ["polyhedron", "rounded"] {
        for body in bodies(&format!("kind = '{kind}'")) {
            // Axis ends are vertices, and no two points of an ellipsoid are farther apart.
            assert!((5.0 - 1e-6..20.0 + 1e-6).contains(&longest(&body)), "{kind}: {}", longest(&body));
        }
    }
}

fn cube_stl() -> Vec<u8> {
    let corners: Vec<Vec3> = (0..8).map(|k| Vec3::new(k as f64 % 2.0, (k / 2) as f64 % 2.0, (k / 4) as f64)).collect();
    let body = convex_hull(&corners).unwrap();
    let mut bytes = Vec::new();
    stl::write(
        &[Aggregate {
            id: 0,
            kind: Kind::Aggregate,
            own: None,
            class: 0,
            itz_thickness_mm: 0.0,
            shells: Vec::new(),
            body,
        }],
        &mut bytes,
    )
    .unwrap();
    bytes
}

/// A flat pyramid and the same folded inwards, which is not convex.
fn pyramid(tip: f64) -> String {
    let corner = |[x, y, z]: [f64; 3]| format!("vertex {x} {y} {z}\n");
    let base = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
    let (tip, bottom) = ([1.0, 1.0, tip], [1.0, 1.0, -1.0]);
    let sides = (0..4).flat_map(|k| {
        let (a, b) = (base[k], base[(k + 1) % 4]);
        [[a, b, tip], [b, a, bottom]]
    });
    let facets =
        sides.map(|f| format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", f.map(corner).concat()));
    format!("solid pyramid\n{}endsolid\n", facets.collect::<String>())
}

const TETRAHEDRON: &[u8] = b"[{\"name\": \"flint\", \"vertices\": [[0,0,0],[3,0,0],[0,2,0],[0,0,2]]}]";

fn library(files: &[(&str, &[u8])], name: &str) -> Result<Spec, String> {
    let text = format!("{SMALL}[shape]\nlibrary = '{name}'\n[grading]\nd_min_mm = 8\n");
    Spec::from_toml_with(&text, &mut Folder(files)).map_err(|error| error.to_string())
}

#[test]
fn a_users_grains_are_scaled_and_placed() {
    let cube = cube_stl();
    // Some programs write in capitals.
    let tip = pyramid(1.0).to_uppercase();
    let files = [("stones/b.STL", &cube[..]), ("stones/a.stl", tip.as_bytes()), ("stones/c.json", TETRAHEDRON)];
    let spec = library(&files, "stones").unwrap();
    let corners: Vec<usize> = spec.shape.grains.iter().map(|grain| grain.vertices().len()).collect();
    assert_eq!(corners, [6, 8, 4], "in the order of the files' names");
    let bodies = packed(&spec);
    for count in corners {
        assert!(bodies.iter().any(|body| body.vertices().len() == count), "no grain with {count} corners");
    }
    for body in &bodies {
        assert!((8.0 - 1e-6..20.0 + 1e-6).contains(&longest(body)), "{}", longest(body));
    }
}

#[test]
fn a_library_stands_in_the_saved_spec_so_that_the_model_can_be_made_again() {
    let spec = library(&[("flint.json", TETRAHEDRON)], "flint.json").unwrap();
    let again = Spec::from_value(&serde_json::to_value(&spec).unwrap()).unwrap();
    assert_eq!(again, spec);
}

#[test]
fn grains_in_json_may_be_bare_lists_of_vertices() {
    let bare = b"\xef\xbb\xbf[[[0,0,0],[3,0,0],[0,2,0],[0,0,2]]]";
    assert_eq!(library(&[("bare.json", bare)], "bare.json"), library(&[("flint.json", TETRAHEDRON)], "flint.json"));
}

#[test]
fn a_grain_without_a_closed_surface_is_rejected_by_name() {
    let (dented, cube) = (pyramid(-0.5), cube_stl());
    let open = dented.replacen("facet normal 0 0 0\nouter loop\nvertex 0 0 0\n", "outer loop\nvertex 0 0 1\n", 1);
    let beyond = b"[{\"vertices\": [[0,0,0],[3,0,0],[0,2,0],[0,0,2]], \"faces\": [[0,1,9]]}]";
    for (name, bytes, part) in [
        ("open.stl", open.as_bytes(), "open.stl: its surface is open"),
        (
            "short.stl",
            &cube[..600],
            "short.stl: this is not an STL file: it is no text that begins with `solid`, and as a binary file its count",
        ),
        ("empty.stl", b"solid empty\nendsolid empty\n", "empty.stl: it has no triangles"),
        ("flat.json", b"[{\"vertices\": [[0,0,0],[3,0,0],[0,2,0]]}]", "flat.json: grain 0: the points span 2"),
        ("far.json", beyond, "far.json: grain 0: a face names vertex 9 of 4"),
        ("none.json", b"[]", "it has no grains"),
        ("text.json", b"{}", "it is not a list of grains"),
        ("cut.json", b"[[[0,0,0],", "it is not JSON: EOF while parsing"),
        // The audit of new features: the last of two lists of vertices was taken.
        ("twice.json", b"[{\"vertices\": [], \"vertices\": []}]", "the key \"vertices\" is given twice in one object"),
        ("more.json", b"[] x", "it is not JSON: trailing characters"),
    ] {
        let path = format!("stones/{name}");
        let error = library(&[(&path, bytes)], "stones").unwrap_err();
        assert!(error.contains("shape.library is \"stones\": ") && error.contains(part), "{error}");
    }
    let error = library(&[("stones/readme.txt", b"")], "stones").unwrap_err();
    assert!(error.contains("the folder holds no file that ends in .stl, .ply, .obj, .off or .json"), "{error}");
}

/// The principal axes of a square pyramid had entries below 1e-60, so that its turned points had no hull and no volume.
#[test]
fn a_square_pyramid_has_its_volume_in_its_principal_axes() {
    let spec = library(&[("pyramid.stl", pyramid(0.0).as_bytes())], "pyramid.stl").unwrap();
    let volume = spec.shape.grains[0].relative_volume();
    assert!((volume - 4.0 / 3.0 / 8.0_f64.powf(1.5)).abs() < 1e-12, "{volume}");
}

#[test]
fn a_grain_with_dents_is_taken_as_it_is_and_its_hull_on_request() {
    let dented = pyramid(-0.5);
    let files = [("stones/dented.stl", dented.as_bytes())];
    let spec = library(&files, "stones").unwrap();
    // Half of its hull, which has a volume of 4/3 over the cube of its longest edge.
    let volume = spec.shape.grains[0].relative_volume();
    assert!(spec.shape.has_dents() && (volume - 2.0 / 3.0 / 8.0_f64.powf(1.5)).abs() < 1e-12, "{volume}");
    let again = Spec::from_value(&serde_json::to_value(&spec).unwrap()).unwrap();
    assert_eq!(again, spec);
    let text = format!("{SMALL}shape = {{ library = 'stones', hull = true }}\n");
    assert!(!Spec::from_toml_with(&text, &mut Folder(&files)).unwrap().shape.has_dents());
}

/// A vertex that no face names counted as a second part of the surface.
#[test]
fn vertices_without_faces_are_left_out() {
    let with = |more: &str| {
        let text = format!(
            "[{{\"vertices\": [[0,0,0],[3,0,0],[0,3,0],[0,0,3],[0.5,0.5,0.5]{more}], \"faces\": [[0,2,1],[0,1,3],[0,3,2],\
             [1,2,4],[2,3,4],[3,1,4]]}}]"
        );
        library(&[("a.json", text.as_bytes())], "a.json")
    };
    assert!(with("").unwrap().shape.has_dents());
    assert_eq!(with(",[99,0,0]"), with(""));
    assert_eq!(with(",[0.2,0.2,0.2]"), with(""));
}

#[test]
fn surfaces_that_cross_themselves_are_rejected_with_the_place() {
    let two = "[{\"vertices\": [[0,0,0],[3,0,0],[0,3,0],[0,0,3],[1,1,1],[-3,1,1],[1,-3,1],[1,1,-3]], \"faces\": \
        [[0,2,1],[0,1,3],[0,3,2],[1,2,3],[4,5,6],[4,7,5],[4,6,7],[5,7,6]]}]";
    let error = library(&[("two.json", two.as_bytes())], "two.json").unwrap_err();
    assert!(error.contains("grain 0: its surface crosses itself near ["), "{error}");
}

/// A stone with a dent: degree 2 makes a peanut.
const PEANUT: &str = "0 0 10 0\n1 0 0 0\n1 1 0 0\n2 0 4 0\n2 1 0.1 0.3\n2 2 0.4 -0.2\n2 -2 0.4 0.2\n";

fn peanut(options: &str) -> Result<Spec, String> {
    let text = format!(
        "fraction = 0.3\nspecimen = {{ kind = 'cube', side_mm = 60 }}\n[grading]\nd_min_mm = 8\nsize = 'sieve'\n{options}"
    );
    Spec::from_toml_with(&text, &mut Folder(&[("a.dat", PEANUT.as_bytes())])).map_err(|error| error.to_string())
}

#[test]
fn stones_of_harmonics_are_packed_with_their_dents_and_proved_apart() {
    for options in ["", "[placement]\nstrategy = 'take-and-place'\n", "[specimen]\n"] {
        let options = if options.starts_with("[spec") { "" } else { options };
        let spec = peanut(&format!("{options}[shape]\nkind = 'harmonics'\npath = 'a.dat'\ntriangles = 80\n")).unwrap();
        let model = pack(&spec, &Silent).unwrap();
        assert_eq!(check::check(&model).findings, [], "{options}");
        assert!((model.report.fraction - 0.3).abs() < 0.01, "{options}: {}", model.report.fraction);
        for body in model.aggregates.iter().map(|aggregate| &aggregate.body) {
            assert!(body.form() == BodyForm::Surface && body.volume() < 0.99 * body.hull().unwrap().volume());
        }
    }
}

/// Coefficients of a stone with eight dents between six bumps.
fn bumpy() -> String {
    let value = |at: (u32, u32)| [((0, 0), 10.0), ((4, 0), 2.0), ((4, 4), 1.195)].iter().find(|row| row.0 == at);
    let orders = (0..=4).flat_map(|n| (0..=n).map(move |m| (n, m)));
    orders.map(|(n, m)| format!("{n} {m} {} 0\n", value((n, m)).map_or(0.0, |row| row.1))).collect()
}

#[test]
fn stones_whose_hulls_would_wedge_are_moved_into_the_dents_of_each_other() {
    let text = "fraction = 0.5\nspecimen = { kind = 'cube', side_mm = 26, periodic = ['x', 'y', 'z'] }\n\
                grading = { d_min_mm = 8, d_max_mm = 12 }\n\
                shape = { kind = 'harmonics', path = 'a.dat', triangles = 120 }\n";
    let spec = Spec::from_toml_with(text, &mut Folder(&[("a.dat", bumpy().as_bytes())])).unwrap();
    let model = pack(&spec, &Silent).unwrap();
    assert_eq!(check::check(&model).findings, []);
    let hulls: f64 = model.aggregates.iter().map(|stone| stone.body.hull().unwrap().volume()).sum();
    // Balls of such a narrow grading jam at 0.64.
    assert!(hulls / 26.0_f64.powi(3) > 0.68, "{hulls}");
    assert!((model.report.fraction - 0.5).abs() < 0.01, "{}", model.report.fraction);
}

#[test]
fn coefficients_that_make_no_stone_are_refused_with_the_place() {
    let stone = |text: &str, options: &str| {
        let spec = format!("{SMALL}[shape]\nkind = 'harmonics'\npath = 'a.dat'\n{options}");
        Spec::from_toml_with(&spec, &mut Folder(&[("a.dat", text.as_bytes())])).unwrap_err().to_string()
    };
    assert!(stone("0 0 1 0\n1 0 x 0\n", "").contains("line 2: `1 0 x 0` is not a coefficient"));
    assert!(stone("0 0 1 0\n1 0 9 0\n1 1 0 0\n", "").contains("its radius is -"));
    assert!(stone(PEANUT, "degree = 0\n").contains("shape.degree is 0; it must be a whole number from 1 to 40"));
}

#[test]
fn the_outline_of_a_template_reaches_as_far_as_its_size() {
    let spec = library(&[("flint.json", TETRAHEDRON)], "flint.json").unwrap();
    let volume = spec.shape.grains[0].relative_volume();
    // 3 x 2 x 2 / 6 over the cube of the longest edge.
    assert!((volume - 2.0 / 13.0_f64.powf(1.5)).abs() < 1e-12, "{volume}");
    assert!(Aabb::around(spec.shape.grains[0].vertices()).size() == Vec3::new(3.0, 2.0, 2.0));
}

#[test]
fn the_number_of_aggregates_is_foreseen_for_every_kind() {
    for kind in ["polyhedron", "rounded", "crushed"] {
        let spec = Spec::from_toml(&format!("{SMALL}[shape]\nkind = '{kind}'")).unwrap();
        let (foreseen, placed) = (spec.estimated_aggregates(), packed(&spec).len() as f64);
        assert!((foreseen / placed - 1.0).abs() < 0.25, "{kind}: {foreseen} foreseen, {placed} placed");
    }
}
