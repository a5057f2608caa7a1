//! Voxel images against a look at every voxel by every half-space.

use crate::pack::models;
use meso_core::aggregate::{Aggregate, Kind};
use meso_core::formats::ImageFormat;
use meso_core::geometry::Plane;
use meso_core::gjk;
use meso_core::images::Images;
use meso_core::import::volume;
use meso_core::math::{Aabb, Vec3};
use meso_core::spec::Spec;
use meso_core::specimen::Container;
use meso_core::voxel_image::{ImageOptions, Quantity, Region, ShareOf, VoxelImage, Voxels};
use meso_core::{Model, Silent, pack};
use std::io::Cursor;

const CUBE: &str = "fraction = 0.4\n[specimen]\nkind = \"cube\"\nside_mm = 30\n";
const PERIODIC: &str = "fraction = 0.4\n[specimen]\nkind = \"cube\"\nside_mm = 30\nperiodic = [\"x\", \"y\", \"z\"]\n";
const CYLINDER: &str = "fraction = 0.3\n[specimen]\nkind = \"cylinder\"\ndiameter_mm = 40\nheight_mm = 33\n";
const DOGBONE: &str = "fraction = 0.2\n[specimen]\nkind = \"dogbone\"\nlength_mm = 120\nwidth_mm = 50\nthickness_mm = 25\n\
                       neck_width_mm = 30\nradius_mm = 40\n";
const FURTHER: &str = "fraction = 0.25\n[specimen]\nkind = \"cube\"\nside_mm = 30\n[voids]\nfraction = 0.02\n\
                       diameter_mm = [1.0, 3.0]\n[fibres]\nfraction = 0.01\nlength_mm = 12\ndiameter_mm = 1.2\n";

fn packed(spec: &str) -> Model {
    pack(&Spec::from_toml(spec).unwrap(), &Silent).unwrap()
}

fn image(model: &Model, options: ImageOptions) -> (VoxelImage, Voxels) {
    let image = VoxelImage::new(model, &options).unwrap();
    let layers = image.counts()[2];
    let values = image.layers(0..layers);
    (image, values)
}

/// How far a point is above the highest face plane, mm.
fn height(body: &Aggregate, x: &Vec3) -> f64 {
    body.body.planes().map(|plane| plane.normal.dot(x) - plane.offset).fold(f64::NEG_INFINITY, f64::max)
}

/// Every voxel's centre, in the order of the array.
fn centres(image: &VoxelImage, h: f64) -> Vec<Vec3> {
    let [nx, ny, nz] = image.counts();
    let at = |i: usize, axis: usize| image.corner_mm()[axis] + (i as f64 + 0.5) * h;
    let voxels = (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (i, j, k))));
    voxels.map(|(i, j, k)| Vec3::new(at(i, 0), at(j, 1), at(k, 2))).collect()
}

/// A body with its box and its half-spaces.
type Solid<'a> = (&'a Aggregate, Aabb, Vec<Plane>);

/// Phase and grain of a point, by every half-space of every body near it.
fn look(container: &dyn Container, bodies: &[Solid], x: &Vec3) -> (u8, i32) {
    let height = |planes: &[Plane]| planes.iter().map(|p| p.normal.dot(x) - p.offset).fold(f64::NEG_INFINITY, f64::max);
    let near = bodies.iter().filter(|(_, aabb, _)| aabb.distance(x) == 0.0);
    let mut holding = near.map(|(body, _, planes)| (body, height(planes)));
    let Some((body, height)) = holding.find(|(_, height)| *height <= 0.0) else {
        return if container.contains(x) { (0, -1) } else { (255, -2) };
    };
    let phase = match body.kind {
        Kind::Aggregate if height > -body.itz_thickness_mm => 1,
        Kind::Aggregate => 2,
        Kind::Void => 3,
        Kind::Fibre => 4,
    };
    (phase, body.id as i32)
}

#[test]
fn every_voxel_has_the_phase_and_the_grain_of_the_half_spaces_around_its_centre() {
    let mut seen = std::collections::BTreeSet::new();
    for spec in [CUBE, PERIODIC, CYLINDER, DOGBONE, FURTHER] {
        let model = packed(spec);
        let shown = Images::Whole.of(&model.bodies(), &model.spec.specimen);
        let shown: Vec<Solid> = shown.iter().map(|b| (b, b.body.aabb(), b.body.planes().collect())).collect();
        let container = model.spec.specimen.container();
        let options = ImageOptions { voxel_size_mm: 0.75, ..ImageOptions::default() };
        let (frame, Voxels::Label(phases)) = image(&model, options) else { panic!("phases are labels") };
        let (_, Voxels::Id(grains)) = image(&model, ImageOptions { quantity: Quantity::Grain, ..options }) else {
            panic!("grains are ids")
        };
        for (number, centre) in centres(&frame, options.voxel_size_mm).iter().enumerate() {
            let expected = look(&*container, &shown, centre);
            assert_eq!((phases[number], grains[number]), expected, "at {centre} of {spec}");
        }
        seen.extend(phases);
    }
    assert_eq!(seen.into_iter().collect::<Vec<_>>(), [0, 1, 2, 3, 4, 255]);
}

#[test]
fn shares_add_up_to_the_fraction_and_the_shells() {
    for spec in [CUBE, PERIODIC, CYLINDER] {
        let model = packed(spec);
        let sum = |of: ShareOf, h: f64| {
            let options = ImageOptions { voxel_size_mm: h, quantity: Quantity::Share, of, region: Region::Whole };
            let (_, Voxels::Real(shares)) = image(&model, options) else { panic!("shares are reals") };
            assert!(shares.iter().all(|share| (-1e-5..=1.0 + 1e-5).contains(share)));
            shares.iter().map(|&share| f64::from(share)).sum::<f64>() * h.powi(3)
        };
        let whole: f64 = model.aggregates.iter().map(|aggregate| aggregate.body.volume()).sum();
        let cores: f64 = model.aggregates.iter().map(|a| a.core().unwrap().map_or(0.0, |core| core.volume())).sum();
        for h in [0.75, 1.5, 15.0] {
            assert!((sum(ShareOf::Aggregate, h) / whole - 1.0).abs() < 1e-5, "{spec} at {h}");
        }
        assert!((sum(ShareOf::Core, 0.75) / cores - 1.0).abs() < 1e-5);
        assert!((sum(ShareOf::Itz, 0.75) / (whole - cores) - 1.0).abs() < 1e-4);
        assert_eq!(sum(ShareOf::Fibre, 0.75), 0.0);
    }
}

/// The aggregates and their images within `reach` of the specimen, each with its box.
fn solids_around(model: &Model, reach: f64) -> Vec<(Aggregate, Aabb)> {
    let (period, domain) = (model.spec.specimen.period(), model.spec.specimen.aabb().grown(reach));
    let images = model.aggregates.iter().flat_map(|a| {
        let shifts = period.shifts(&a.body.aabb(), &domain);
        shifts.into_iter().map(|shift| Aggregate { body: a.body.translated(&shift), ..a.clone() })
    });
    let with_box = |image: Aggregate| {
        let aabb = image.body.aabb();
        (image, aabb)
    };
    images.map(with_box).collect()
}

/// Negative inside.
fn signed_distance(body: &Aggregate, x: &Vec3) -> f64 {
    match height(body, x) {
        height if height <= 0.0 => height,
        _ => gjk::distance(&[*x], body.body.vertices()).unwrap(),
    }
}

#[test]
fn distances_are_those_of_the_nearest_body_and_negative_inside() {
    for spec in [PERIODIC, CYLINDER] {
        let model = packed(spec);
        let options = ImageOptions { voxel_size_mm: 3.0, quantity: Quantity::Distance, ..ImageOptions::default() };
        let (frame, Voxels::Real(distances)) = image(&model, options) else { panic!("distances are reals") };
        let container = model.spec.specimen.container();
        let images = solids_around(&model, 20.0);
        let mut inside = 0;
        for (centre, distance) in centres(&frame, options.voxel_size_mm).iter().zip(distances) {
            if !container.contains(centre) {
                assert!(distance.is_nan());
                continue;
            }
            let expected = images.iter().fold(f64::INFINITY, |least, (body, aabb)| {
                // No body is nearer than its box.
                if aabb.distance(centre) <= least.max(0.0) { least.min(signed_distance(body, centre)) } else { least }
            });
            assert!((f64::from(distance) - expected).abs() < 1e-5, "{distance} for {expected} at {centre}");
            inside += usize::from(distance < 0.0);
        }
        assert!(inside > 100, "{inside}");
    }
}

#[test]
fn a_box_and_a_section_are_parts_of_the_whole() {
    let model = packed(CUBE);
    let options = ImageOptions::default();
    let (_, Voxels::Label(whole)) = image(&model, options) else { panic!("phases are labels") };
    let part = Region::Box { min: [4.0, 7.0, 10.0], max: [9.0, 19.0, 20.0] };
    let (boxed, Voxels::Label(values)) = image(&model, ImageOptions { region: part, ..options }) else {
        panic!("phases are labels")
    };
    assert_eq!(boxed.counts(), [5, 12, 10]);
    let at = |i: usize, j: usize, k: usize| whole[(k * 30 + j) * 30 + i];
    assert!((0..600).all(|n| values[n] == at(4 + n % 5, 7 + n / 5 % 12, 10 + n / 60)));
    for axis in 0..3 {
        let section = ImageOptions { region: Region::Section { axis, at: 12.5 }, ..options };
        let (shown, Voxels::Label(values)) = image(&model, section) else { panic!("phases are labels") };
        assert_eq!(shown.shape(), [30, 30]);
        let expected = |n: usize| {
            let mut place = [n % 30, n / 30, 0];
            place = [[12, place[0], place[1]], [place[0], 12, place[1]], [place[0], place[1], 12]][axis];
            at(place[0], place[1], place[2])
        };
        assert!((0..900).all(|n| values[n] == expected(n)), "axis {axis}");
    }
}

#[test]
fn an_image_is_the_same_in_slabs_and_on_any_number_of_threads() {
    let model = packed(CYLINDER);
    for quantity in [Quantity::Phase, Quantity::Share] {
        let options = ImageOptions { quantity, ..ImageOptions::default() };
        let (image, whole) = image(&model, options);
        let layers = image.counts()[2];
        let single: Vec<u8> = (0..layers).flat_map(|k| image.layers(k..k + 1).bytes().into_owned()).collect();
        assert_eq!(*whole.bytes(), single[..]);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        assert_eq!(pool.install(|| image.layers(0..layers)), whole);
    }
}

#[test]
fn files_hold_the_values_behind_their_headers() {
    let model = packed(CUBE);
    let (image, values) = image(&model, ImageOptions { voxel_size_mm: 2.0, ..ImageOptions::default() });
    let written = |format: ImageFormat| {
        let mut out = Cursor::new(Vec::new());
        format.write_file(&image, &model, Region::Whole, &Silent, &mut out).unwrap();
        out.into_inner()
    };
    let array = written(ImageFormat::Npy);
    assert_eq!((array.len() - 15 * 15 * 15) % 64, 0);
    assert!(array.ends_with(&values.bytes()));
    let header = String::from_utf8_lossy(&array[..128]);
    assert!(header.contains("'descr': '|u1', 'fortran_order': False, 'shape': (15, 15, 15)"), "{header}");
    assert!(written(ImageFormat::Vti).windows(values.len()).any(|window| *window == *values.bytes()));
    assert_eq!(&written(ImageFormat::Tif)[..4], b"II*\0");
}

#[test]
fn an_image_is_read_again_as_a_label_volume() {
    let text = "fraction = 0.4\n[specimen]\nkind = \"box\"\nsize_mm = [30, 20, 25]\n";
    let model = packed(text);
    let (image, values) = image(&model, ImageOptions { voxel_size_mm: 2.5, ..ImageOptions::default() });
    for (name, format) in [("a.tif", ImageFormat::Tif), ("a.npy", ImageFormat::Npy), ("a.vti", ImageFormat::Vti)] {
        let mut out = Cursor::new(Vec::new());
        format.write_file(&image, &model, Region::Whole, &Silent, &mut out).unwrap();
        let volume = volume::read::<u8>(name, &out.into_inner()).unwrap();
        let labels: Vec<u8> = volume.of.iter().map(|number| volume.labels[usize::from(*number)] as u8).collect();
        assert_eq!((volume.counts, &labels[..]), ([12, 8, 10], &*values.bytes()), "{name}");
        let spacing = volume.spacing_mm.map(|spacing| spacing.map(|h| (h * 1e6).round() / 1e6));
        assert_eq!(spacing, (name != "a.npy").then_some([2.5; 3]), "{name}");
    }
}

#[test]
fn an_option_that_an_image_cannot_meet_is_named() {
    let model = packed(PERIODIC);
    let error = |options: ImageOptions| VoxelImage::new(&model, &options).err().map(|error| error.to_string());
    let usual = ImageOptions::default();
    assert!(
        error(ImageOptions { voxel_size_mm: 0.0, ..usual }).unwrap().starts_with("voxel_size_mm is 0; it must lie")
    );
    assert!(error(ImageOptions { voxel_size_mm: f64::NAN, ..usual }).is_some());
    let uneven = error(ImageOptions { voxel_size_mm: 0.7, ..usual }).unwrap();
    assert!(
        uneven.contains("it must divide the period of 30 mm, as 0.7142857142857143 and 0.6976744186046512 do"),
        "{uneven}"
    );
    let beyond = Region::Box { min: [0.0; 3], max: [31.0; 3] };
    assert!(error(ImageOptions { region: beyond, ..usual }).unwrap().contains("box is"));
    assert!(error(ImageOptions { region: Region::Section { axis: 2, at: 30.1 }, ..usual }).is_some());
    assert!(ImageFormat::Png.check(&usual).is_err());
    let ids = ImageOptions { quantity: Quantity::Grain, region: Region::Section { axis: 2, at: 3.0 }, ..usual };
    assert!(ImageFormat::Svg.check(&ids).is_err());
    let section = Region::Section { axis: 2, at: 3.0 };
    let boxes = models::two_boxes();
    let (image, _) = image(&boxes, ImageOptions { region: section, ..usual });
    ImageFormat::Png.write(&image, &boxes, section, &Silent, Vec::new()).unwrap();
}
