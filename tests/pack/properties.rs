//! Properties of gradings, specs and saved models, for whatever may be asked of them.

use crate::pack::models::{box_body, model_of};
use crate::property::{Share, holds};
use meso_core::aggregate::{
    AspectRatio, Curve, Fibres, Form, Grading, Itz, Shape, ShapeKind, SizeLaw, Standard, Voids,
};
use meso_core::check::check;
use meso_core::packing::{Placement, Strategy as Placing};
use meso_core::specimen::{Periodic, Specimen};
use meso_core::{Model, Silent, Spec, pack, saved};
use proptest::array::{uniform2, uniform3, uniform6};
use proptest::collection::vec;
use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
use proptest::option;
use proptest::prelude::*;
use proptest::sample::select;

/// A sieve table: openings that grow by a ratio, and shares that rise in whole steps, some of them by nothing.
fn sieves() -> impl Strategy<Value = Curve> {
    let rows = vec((1.05..3.0_f64, 0..=10_u32), 1..=7);
    (0.1..4.0_f64, rows, 1..=10_u32).prop_map(|(first, rows, last_rise)| {
        let (mut opening, mut risen) = (first, 0);
        let row = |(ratio, rise)| {
            let sieve = opening;
            (opening, risen) = (opening * ratio, risen + rise);
            (sieve, f64::from(risen))
        };
        let (sieves_mm, risen): (Vec<f64>, Vec<f64>) = rows.into_iter().chain([(1.0, last_rise)]).map(row).unzip();
        let whole = risen[risen.len() - 1];
        Curve::Sieves { sieves_mm, passing: risen.iter().map(|share| share / whole).collect() }
    })
}

/// `share` of the way from one length to another, in ratios.
fn between([low, high]: [f64; 2], share: f64) -> f64 {
    low * libm::pow(high / low, share)
}

#[test]
fn a_sieve_curve_meets_its_table_and_is_straight_between_its_sieves() {
    holds(500, &sieves(), |curve| {
        let Curve::Sieves { sieves_mm, passing } = &curve else { unreachable!("a table") };
        for (sieves, shares) in sieves_mm.windows(2).zip(passing.windows(2)) {
            let middle = ((sieves[0] * sieves[1]).sqrt(), (shares[0] + shares[1]) / 2.0);
            for (sieve, share) in [(sieves[0], shares[0]), middle, (sieves[1], shares[1])] {
                let found = curve.passing(sieve, 1.0);
                prop_assert!((found - share).abs() < 1e-14, "{} for {} at {} mm", found, share, sieve);
            }
        }
        Ok(())
    });
}

#[test]
fn the_classes_of_a_sieve_curve_take_no_less_than_nothing_and_all_of_it_together() {
    let cuts = vec(0.0..1.0_f64, 0..6);
    let rises = Share::default();
    holds(1000, &(sieves(), 0.0..0.9_f64, 0.1..1.0_f64, cuts), |(curve, from, length, cuts)| {
        let sieves = curve.sieves().expect("a table");
        let whole_range = [sieves[0], sieves[sieves.len() - 1]];
        // Beyond the coarsest sieve, too.
        let range = [from, from + length * (1.1 - from)].map(|share| between(whole_range, share));
        let [d_min_mm, d_max_mm] = range;
        let rise = curve.passing(d_max_mm, d_max_mm) - curve.passing(d_min_mm, d_max_mm);
        rises.count(rise > 0.0);
        let mut classes_mm: Vec<f64> = cuts.iter().chain(&[0.0, 1.0]).map(|cut| between(range, *cut)).collect();
        classes_mm.sort_by(f64::total_cmp);
        let grading = Grading { curve, d_min_mm, d_max_mm, classes_mm, ..Grading::default() };
        for (form, expected) in [(Form::Raw, rise), (Form::Normalised, 1.0)] {
            // A curve that does not rise between the sizes cannot be normalised.
            if form == Form::Normalised && rise == 0.0 {
                continue;
            }
            let classes = Grading { form, ..grading.clone() }.classes();
            prop_assert!(classes.iter().all(|class| class.share >= 0.0), "{:?}", classes);
            let sum: f64 = classes.iter().map(|class| class.share).sum();
            prop_assert!((sum - expected).abs() < 1e-12, "{} for {}: {:?}", sum, expected, classes);
        }
        Ok(())
    });
    assert!((0.7..1.0).contains(&rises.get()), "{} of the curves rise", rises.get());
}

fn length() -> impl Strategy<Value = f64> {
    25.0..200.0_f64
}

fn specimen() -> impl Strategy<Value = Specimen> {
    let periodic = || uniform3(any::<bool>()).prop_map(Periodic);
    prop_oneof![
        (length(), periodic()).prop_map(|(side_mm, periodic)| Specimen::Cube { side_mm, periodic }),
        (uniform3(length()), periodic()).prop_map(|(size_mm, periodic)| Specimen::Box { size_mm, periodic }),
        (length(), length()).prop_map(|(diameter_mm, height_mm)| Specimen::Cylinder { diameter_mm, height_mm }),
        length().prop_map(|diameter_mm| Specimen::Sphere { diameter_mm }),
        (uniform3(length()), uniform2(1.0..20.0)).prop_map(|([length_mm, width_mm, depth_mm], notch)| {
            let [notch_depth_mm, notch_width_mm] = notch;
            Specimen::NotchedPrism {
                length_mm,
                width_mm,
                depth_mm,
                notch_depth_mm,
                notch_width_mm,
                upper_notch_depth_mm: 0.0,
                notch_at_mm: 0.0,
            }
        }),
        vec(uniform3(length()), 4..8).prop_map(|vertices_mm| Specimen::Polyhedron { vertices_mm }),
    ]
}

fn grading() -> impl Strategy<Value = Grading> {
    let curve = prop_oneof![
        (0.2..1.0).prop_map(|exponent| Curve::Fuller { exponent }),
        (0.0..0.3).prop_map(|a| Curve::Bolomey { a }),
        sieves(),
        select(&Standard::ALL[..]).prop_map(|name| Curve::Standard { name }),
    ];
    let forms = (any::<bool>(), any::<bool>());
    (curve, 4.0..6.0, 8.0..20.0, forms).prop_map(|(curve, d_min_mm, d_max_mm, (raw, uniform))| Grading {
        curve,
        d_min_mm,
        d_max_mm,
        form: if raw { Form::Raw } else { Form::Normalised },
        classes_mm: vec![d_min_mm, (d_min_mm + d_max_mm) / 2.0, d_max_mm],
        size_law: if uniform { SizeLaw::Uniform } else { SizeLaw::VolumeUniform },
        ..Grading::default()
    })
}

fn shape() -> impl Strategy<Value = Shape> {
    let ratio = || {
        uniform3(0.05..=1.0).prop_map(|mut ratios: [f64; 3]| {
            ratios.sort_by(f64::total_cmp);
            let [min, mean, max] = ratios;
            AspectRatio::Normal { mean, sd: max - min, min, max }
        })
    };
    let kind = select(&[ShapeKind::Polyhedron, ShapeKind::Rounded, ShapeKind::Crushed][..]);
    (kind, 8..40_u32, 0..40_u32, ratio(), ratio()).prop_map(|(kind, fewest, more, elongation, flatness)| Shape {
        kind,
        vertices: [fewest, fewest + more],
        elongation,
        flatness,
        grains: Vec::new(),
        shells: Vec::new(),
    })
}

fn placement() -> impl Strategy<Value = Placement> {
    let strategy = select(&[Placing::Auto, Placing::TakeAndPlace, Placing::Rearrange][..]);
    let limits = (option::of(any::<u32>()), option::of(1e-3..1e9_f64));
    (strategy, limits, 0.0..1.0, uniform2(0.0..2.0)).prop_map(
        |(strategy, (attempts, time_limit_s), surplus, [min_gap_mm, wall_gap_mm])| Placement {
            strategy,
            attempts,
            surplus,
            min_gap_mm,
            wall_gap_mm,
            time_limit_s,
        },
    )
}

/// Specs of every option, most of which can be.
fn spec() -> impl Strategy<Value = Spec> {
    let voids = uniform2(1.0..4.0).prop_map(|d: [f64; 2]| [d[0].min(d[1]), d[0].max(d[1])]);
    let voids = (0.001..0.1, voids, option::of(grading())).prop_map(|(fraction, diameter_mm, grading)| Voids {
        fraction,
        diameter_mm: grading.is_none().then_some(diameter_mm),
        grading,
    });
    let fibres = (0.001..0.02, 0.2..1.0, 5.0..20.0).prop_map(|(fraction, diameter_mm, length_mm)| Fibres {
        fraction,
        diameter_mm,
        length_mm,
        orientation: None,
    });
    let itz = uniform2(0.0..1.0).prop_map(|t: [f64; 2]| Itz { thickness_mm: [t[0].min(t[1]), t[0].max(t[1])] });
    let whole = (any::<u64>(), 0.01..0.8, specimen(), grading(), shape(), itz, placement());
    (whole, option::of(voids), option::of(fibres)).prop_map(
        |((seed, fraction, specimen, grading, shape, itz, placement), voids, fibres)| Spec {
            seed,
            fraction,
            specimen,
            grading,
            shape,
            itz,
            placement,
            voids,
            fibres,
            phases: Vec::new(),
        },
    )
}

#[test]
fn a_spec_written_as_toml_or_json_is_read_back_equal_or_refused_as_it_was() {
    let possible = Share::default();
    holds(1000, &spec(), |spec| {
        let expected = spec.validate().map(|()| spec.clone());
        let from_json = Spec::from_value(&serde_json::to_value(&spec)?);
        prop_assert_eq!(&from_json, &expected);
        let from_toml = Spec::from_toml(&toml::to_string(&spec)?);
        // It knows the line of a fault, too.
        prop_assert_eq!(from_toml.map_err(|error| error.key), expected.map_err(|error| error.key));
        possible.count(from_json.is_ok());
        Ok(())
    });
    assert!(possible.get() > 0.3, "{} of the specs can be", possible.get());
}

/// Lines of specs, good and bad, and whatever else a hand types.
fn line() -> impl Strategy<Value = String> {
    const GOOD: [&str; 12] = [
        "seed = 7",
        "fraction = 0.3",
        "specimen = { kind = 'cube', side_mm = 60 }",
        "[specimen]",
        "kind = 'sphere'",
        "diameter_mm = 80",
        "[grading]",
        "d_max_mm = 16",
        "curve = { kind = 'fuller' }",
        "[itz]",
        "thickness_mm = [0, 0.5]",
        "[voids]",
    ];
    const KEYS: [&str; 12] = [
        "seed",
        "fraction",
        "specimen",
        "kind",
        "size_mm",
        "periodic",
        "grading.curve",
        "classes_mm",
        "itz",
        "placement.attempts",
        "fibres",
        "x",
    ];
    prop_oneof![
        4 => select(&GOOD[..]).prop_map(str::to_owned),
        2 => (select(&KEYS[..]), value()).prop_map(|(key, value)| format!("{key} = {value}")),
        1 => any::<String>(),
    ]
}

/// A value of TOML, lists and tables of values among them.
fn value() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        any::<i64>().prop_map(|number| number.to_string()),
        any::<f64>().prop_map(|number| format!("{number:e}")),
        any::<bool>().prop_map(|truth| truth.to_string()),
        any::<String>().prop_map(|text| format!("{text:?}")),
        select(&["nan", "-inf", "2026-01-01", "'cube'", "'fuller'", "''"][..]).prop_map(str::to_owned),
    ];
    leaf.prop_recursive(3, 12, 4, |inner| {
        let key = select(&["kind", "side_mm", "fraction", "a"][..]);
        let table = vec((key, inner.clone()).prop_map(|(key, value)| format!("{key} = {value}")), 0..4);
        prop_oneof![
            vec(inner, 0..4).prop_map(|values| format!("[{}]", values.join(", "))),
            table.prop_map(|entries| format!("{{ {} }}", entries.join(", "))),
        ]
    })
}

#[test]
fn any_text_is_a_valid_spec_or_an_error_of_one_line_that_names_one_of_its_own() {
    let read = Share::default();
    holds(10_000, &vec(line(), 0..6), |lines| {
        let text = lines.join("\n");
        let spec = Spec::from_toml(&text);
        read.count(spec.is_ok());
        match spec {
            Ok(spec) => prop_assert_eq!(spec.validate(), Ok(())),
            Err(error) => {
                prop_assert!(!error.message.is_empty() && !error.to_string().contains('\n'), "{}", error);
                let last = text.split('\n').count();
                prop_assert!(error.line.is_none_or(|line| (1..=last).contains(&line)), "{} of {} lines", error, last);
            }
        }
        Ok(())
    });
    assert!((0.05..0.7).contains(&read.get()), "{} of the texts are specs", read.get());
}

fn written(model: &Model) -> Vec<u8> {
    let mut bytes = Vec::new();
    saved::write(model, &mut bytes).expect("memory takes all");
    bytes
}

/// Any number that a coordinate may be: of every magnitude up to 2e6 mm, subnormal or 0 of either sign.
fn coordinate() -> impl Strategy<Value = f64> {
    (POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO).prop_map(|x| x % 2e6)
}

#[test]
fn bodies_of_any_coordinates_are_read_back_from_a_file_to_the_last_bit() {
    let corners = |body: [f64; 6]| {
        let [x, y, z, u, v, w] = body;
        box_body([x, y, z], [u, v, w])
    };
    holds(1000, &vec(uniform6(coordinate()).prop_map(corners), 0..5), |bodies| {
        let model = model_of(bodies);
        let bytes = written(&model);
        let again = saved::read(&bytes)?;
        prop_assert_eq!(written(&again), bytes);
        let bits = |model: &Model| -> Vec<[u64; 3]> {
            let vertices = model.aggregates.iter().flat_map(|aggregate| aggregate.body.vertices());
            vertices.map(|v| <[f64; 3]>::from(*v).map(f64::to_bits)).collect()
        };
        prop_assert_eq!(bits(&again), bits(&model));
        Ok(())
    });
}

#[test]
fn a_tiny_packing_is_sound_and_the_same_bytes_after_a_file() {
    let specimens = prop_oneof![
        (22.0..28.0).prop_map(|side| format!("{{ kind = 'cube', side_mm = {side} }}")),
        (22.0..28.0).prop_map(|side| format!("{{ kind = 'cube', side_mm = {side}, periodic = ['x', 'z'] }}")),
        (24.0..30.0).prop_map(|diameter| format!("{{ kind = 'sphere', diameter_mm = {diameter} }}")),
    ];
    let kinds = select(&["polyhedron", "rounded", "crushed"][..]);
    let voids = select(&["", "[voids]\nfraction = 0.01\ndiameter_mm = [2, 3]\n"][..]);
    holds(16, &(specimens, kinds, voids, any::<u64>(), 0.05..0.3), |(specimen, kind, voids, seed, fraction)| {
        let text = format!(
            "seed = {seed}\nfraction = {fraction}\nspecimen = {specimen}\ngrading = {{ d_max_mm = 10 }}\n\
             shape = {{ kind = '{kind}' }}\nitz = {{ thickness_mm = [0, 0.3] }}\n{voids}"
        );
        let model = pack(&Spec::from_toml(&text)?, &Silent)?;
        prop_assert!(check(&model).is_sound(), "{:?}", check(&model).findings);
        let bytes = written(&model);
        let again = saved::read(&bytes)?;
        prop_assert_eq!(written(&again), bytes);
        prop_assert_eq!(again, model);
        Ok(())
    });
}
