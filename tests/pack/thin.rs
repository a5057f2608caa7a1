//! Grains with dents whose parts are thin: every one has a point inside, an ITZ that is there, and a file that is read back.

use crate::pack::folder::Folder;
use meso_core::check::check;
use meso_core::geometry::{Polyhedron, TriangleMesh};
use meso_core::math::Vec3;
use meso_core::{Model, Silent, Spec, pack, saved};
use std::fmt::Write;

/// A prism over a polygon of the plane x y, as an OBJ.
fn prism(polygon: &[[f64; 2]], thickness: f64) -> String {
    let (mut text, count) = (String::new(), polygon.len());
    for z in [0.0, thickness] {
        polygon.iter().for_each(|[x, y]| writeln!(text, "v {x} {y} {z}").unwrap());
    }
    let face =
        |corners: Vec<usize>| format!("f {}\n", corners.iter().map(ToString::to_string).collect::<Vec<_>>().join(" "));
    text += &face((1..=count).rev().collect());
    text += &face((count + 1..=2 * count).collect());
    (0..count).for_each(|i| {
        let next = (i + 1) % count;
        text += &face(vec![i + 1, next + 1, count + next + 1, count + i + 1]);
    });
    text
}

fn plate_in_an_angle() -> Vec<[f64; 2]> {
    vec![[0.0, 0.0], [20.0, 0.0], [20.0, 6.0], [6.0, 6.0], [6.0, 20.0], [0.0, 20.0]]
}

fn wire_in_a_u(wide: f64) -> Vec<[f64; 2]> {
    let inner = 20.0 - wide;
    vec![[0.0, 0.0], [20.0, 0.0], [20.0, 8.0], [inner, 8.0], [inner, wide], [wide, wide], [wide, 8.0], [0.0, 8.0]]
}

fn open_ring(wide: f64) -> Vec<[f64; 2]> {
    let arc = |radius: f64| {
        (0..12)
            .map(move |k| f64::from(k) * std::f64::consts::PI / 6.5)
            .map(move |a| [radius * a.cos(), radius * a.sin()])
    };
    arc(10.0).chain(arc(10.0 - wide).collect::<Vec<_>>().into_iter().rev()).collect()
}

fn zigzag(wide: f64) -> Vec<[f64; 2]> {
    let along = |y: f64| (0..7).map(move |k| [3.0 * f64::from(k), y + if k % 2 == 0 { 0.0 } else { 4.0 }]);
    along(0.0).chain(along(wide).collect::<Vec<_>>().into_iter().rev()).collect()
}

/// The packing of a library of one grain, as it is read back.
fn packed(obj: &str, itz: &str) -> Model {
    let text = format!(
        "fraction = 0.003\nspecimen = {{ kind = 'cube', side_mm = 60 }}\ngrading = {{ d_min_mm = 20, d_max_mm = 22 }}\n\
         shape = {{ library = 'thin.obj' }}\nitz = {{ thickness_mm = {itz} }}\n"
    );
    let spec = Spec::from_toml_with(&text, &mut Folder(&[("thin.obj", obj.as_bytes())])).unwrap();
    let mut bytes = Vec::new();
    saved::write(&pack(&spec, &Silent).unwrap(), &mut bytes).unwrap();
    saved::read(&bytes).unwrap()
}

/// The cases of `thin_grains.py`: the ITZ was -1.55, -1.91 and -5.36 mm.
#[test]
fn thin_grains_with_dents_have_the_itz_that_is_there() {
    for (name, polygon, thickness) in [
        ("an angle of 0.3 mm", plate_in_an_angle(), 0.3),
        ("an angle of 0.04 mm", plate_in_an_angle(), 0.04),
        ("a U of 0.25 mm", wire_in_a_u(0.25), 0.25),
        ("an open ring of 0.2 mm", open_ring(0.2), 0.2),
        ("an angle of 1 mm, which held", plate_in_an_angle(), 1.0),
    ] {
        let obj = prism(&polygon, thickness);
        let model = packed(&obj, "[0, 0]");
        assert!(!model.aggregates.is_empty() && model.aggregates.iter().all(|grain| grain.itz_thickness_mm == 0.0));
        assert_eq!(check(&model).findings, [], "{name}");
        let (model, thin) = (packed(&obj, "[0.001, 0.001]"), packed(&obj, "[4, 4]"));
        let is_drawn = model.aggregates.iter().all(|grain| grain.itz_thickness_mm == 0.001);
        let is_limited =
            |grain: &meso_core::aggregate::Aggregate| grain.itz_thickness_mm > 0.0 && grain.itz_thickness_mm < 0.5;
        assert!(is_drawn && thin.aggregates.iter().all(is_limited), "{name}");
        assert_eq!([check(&model).findings, check(&thin).findings], [vec![], vec![]], "{name}");
    }
}

/// The point that is found in a plate lies well inside, however thin the plate is, and whatever its direction.
#[test]
fn the_deepest_point_that_is_found_lies_well_inside_a_thin_body() {
    for thickness in [1.0, 0.3, 0.01, 1e-4, 1e-7] {
        for turn in [Vec3::zeros(), Vec3::new(0.3, -0.8, 0.5)] {
            let corners = |z: f64| plate_in_an_angle().into_iter().map(move |[x, y]| Vec3::new(x, y, z));
            let rotation = meso_core::math::Rotation::from_scaled_axis(turn);
            let vertices: Vec<Vec3> = corners(0.0).chain(corners(thickness)).map(|v| rotation * v).collect();
            let cap = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
            let under = cap.map(|[a, b, c]| [a, c, b]);
            let over = cap.map(|t| t.map(|corner| corner + 6));
            let sides = (0..6).flat_map(|i| [[i, (i + 1) % 6, (i + 1) % 6 + 6], [i, (i + 1) % 6 + 6, i + 6]]);
            let triangles: Vec<[u32; 3]> = under.into_iter().chain(over).chain(sides).collect();
            let body = Polyhedron::of_surface(&TriangleMesh { vertices, triangles });
            let (middle, depth) = body.skin(0.0).deepest();
            let share = depth / (0.5 * thickness);
            assert!((0.5..=1.0 + 1e-6).contains(&share) && body.contains(&middle), "{thickness}: {depth}");
        }
    }
}

#[test]
fn a_model_that_no_reader_takes_is_not_written() {
    let honest = packed(&prism(&zigzag(0.2), 5.0), "[0, 0]");
    let refused = |change: fn(&mut Model)| {
        let mut model = honest.clone();
        change(&mut model);
        let mut bytes = Vec::new();
        let error = saved::write(&model, &mut bytes).unwrap_err().to_string();
        assert!(bytes.is_empty() && saved::write_compressed(&model, Vec::new()).is_err());
        assert_eq!(model.accept().unwrap_err().to_string(), error);
        error
    };
    assert_eq!(honest.accept(), Ok(()));
    let itz = refused(|model| model.aggregates[0].itz_thickness_mm = -0.316);
    assert_eq!(itz, "aggregate 0: its itz_thickness_mm is -0.316; it must be 0 or more");
    assert!(refused(|model| model.aggregates[0].itz_thickness_mm = f64::NAN).contains("is NaN"));
    assert!(refused(|model| model.aggregates[1].id = 7).contains("its id is 7"));
    assert!(refused(|model| model.aggregates[1].class = 900).contains("its class is 900"));
    let far = |model: &mut Model| {
        model.aggregates[0].body = model.aggregates[0].body.translated(&Vec3::x_axis().scale(f64::NAN));
    };
    assert!(refused(far).contains("vertex 0 is farther"));
    assert!(refused(|model| model.report.fraction = f64::NAN).contains("a figure of the report is no number"));
    assert!(refused(|model| model.report.classes[0].fraction = f64::INFINITY).contains("is no number"));
    assert!(refused(|model| drop(model.aggregates.pop())).contains("report speaks of"));
}
