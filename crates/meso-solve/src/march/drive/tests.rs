//! Bodies without plates against rigid-body mechanics, strains told to every node against Hooke's law, and a run that is
//! made to diverge.

use crate::dice::dice;
use crate::march::frame::Frame;
use crate::march::response::Ended;
use crate::march::run::Run;
use meso_collision::math::{Aabb, Mat3, Vec3};
use meso_concrete::specimen::Specimen;
use meso_concrete::watch::{Silent, Stage, Watch};
use meso_element::LawName;
use meso_mesh::materials::{Elastic, Materials};
use meso_mesh::{self as mesh, Mesh, MeshOptions, Method, Phase, Tools};
use meso_trial::Sample;
use meso_trial::{Control, Drive, Rule, Side, Smoothing, Speed, SupportSpec, Test};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A specimen of mortar and its mesh; tetrahedra are irregular: their inner nodes are moved by up to 0.2 mm.
struct Body {
    smoothing: Smoothing,
    specimen: Specimen,
    options: MeshOptions,
    mesh: Mesh,
}

impl Body {
    fn of(specimen: Specimen, method: Method) -> Self {
        let options = MeshOptions { method, element_size_mm: 2.0, itz: mesh::ItzForm::None, ..MeshOptions::default() };
        let mut mesh = mesh::build((&[], &specimen), &options, &Tools::default()).unwrap();
        if method != Method::VOXEL {
            let inner: Vec<bool> = (0..mesh.points.len()).map(|node| is_inner(&mesh, node)).collect();
            let mut state = 1_u64;
            for (point, _) in mesh.points.iter_mut().zip(&inner).filter(|(_, inner)| **inner) {
                *point += Vec3::from_fn(|_, _| 0.2 * dice(&mut state));
            }
        }
        Self { smoothing: Smoothing::None, specimen, options, mesh }
    }

    fn cuboid(method: Method) -> Self {
        Self::of(Specimen::cuboid([10.0, 12.0, 14.0]), method)
    }

    /// Tetrahedra, their patches, and boxes.
    fn all() -> [Self; 3] {
        let smoothed = Self { smoothing: Smoothing::Edges, ..Self::cuboid(Method::FITTED) };
        [Self::cuboid(Method::FITTED), smoothed, Self::cuboid(Method::VOXEL)]
    }

    /// The case in words, for messages of failures.
    fn name(&self) -> String {
        format!("{:?}, smoothing {:?}", self.options.method, self.smoothing)
    }

    /// Boxes of aggregate, which bend.
    fn stone() -> Self {
        let mut body = Self::cuboid(Method::VOXEL);
        body.mesh.phase.fill(Phase::Aggregate);
        body
    }

    fn run(&self, law: LawName) -> Run<'_> {
        let sample = Sample::of(&self.mesh, &self.specimen, &self.options);
        let test = Test { law, smoothing: Some(self.smoothing), ..Test::default() };
        Run::new(sample, &Materials::default(), &test).unwrap()
    }

    /// A run that no plate can touch.
    fn free(&self, law: LawName) -> Run<'_> {
        let mut run = self.run(law);
        run.supports.contacts.clear();
        run
    }
}

/// Whether a node lies within the mesh's bounding box, off its faces.
fn is_inner(mesh: &Mesh, node: usize) -> bool {
    let aabb = Aabb::around(&mesh.points);
    let p = mesh.points[node];
    (0..3).all(|axis| p[axis] > aabb.min[axis] + 1e-9 && p[axis] < aabb.max[axis] - 1e-9)
}

/// Places of the engine's nodes, mm.
fn places(run: &Run) -> Vec<Vec3> {
    run.order.iter().map(|&node| run.sample.mesh.points[node as usize]).collect()
}

/// Gives every node the displacement `of` its place.
fn displace(run: &mut Run, of: impl Fn(Vec3) -> Vec3) {
    let places = places(run);
    run.nodes.displacement.iter_mut().zip(places).for_each(|(u, place)| *u = of(place).into());
}

/// Forces with which the elements resist, N, from the impulse that they give to nodes at rest in one step.
fn forces(run: &mut Run) -> Vec<Vec3> {
    run.advance().unwrap();
    let dt = run.outline.dt;
    run.nodes.velocity.iter().zip(&run.nodes.mass).map(|(&v, m)| -Vec3::from(v) * (*m / dt)).collect()
}

fn stresses(run: &Run) -> Vec<[f64; 6]> {
    Frame::new(run, 1).cells(|point| point.stress).into_iter().map(|stress| stress.map(f64::from)).collect()
}

/// Hooke's law, MPa.
fn hooke(elastic: &Elastic, gradient: &Mat3) -> Mat3 {
    let strain = 0.5 * (gradient + gradient.transpose());
    let (e, nu) = (elastic.youngs_modulus_mpa, elastic.poisson_ratio);
    (e / (1.0 + nu)) * (strain + Mat3::identity() * (nu / (1.0 - 2.0 * nu) * strain.trace()))
}

/// Largest difference between a cell's stress and `expected`, MPa.
fn off(run: &Run, expected: &Mat3) -> f64 {
    let expected = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)].map(|at| expected[at]);
    let apart = |stress: [f64; 6]| (0..6).map(|i| (stress[i] - expected[i]).abs()).fold(0.0, f64::max);
    stresses(run).into_iter().map(apart).fold(0.0, f64::max)
}

#[test]
fn a_body_in_free_fall_keeps_its_shape_to_the_last_bit() {
    let bodies = Body::all();
    let laws = [LawName::Cdp, LawName::Cdpm2, LawName::Meso];
    for (body, law) in bodies.iter().flat_map(|body| laws.map(|law| (body, law))) {
        let method = body.name();
        let mut run = body.free(law);
        let (gravity, dt, steps) = (9810.0, run.outline.dt, 300);
        for _ in 0..steps {
            run.nodes.velocity.iter_mut().for_each(|v| v[2] -= gravity * dt);
            run.advance().unwrap();
        }
        let first = run.nodes.displacement[0];
        assert!(run.nodes.displacement.iter().all(|u| *u == first), "{method} {law:?}");
        // The sum of the steps' speeds: g dt2 (1 + 2 + ... + n).
        let fallen = gravity * dt * dt * f64::from(steps * (steps + 1)) / 2.0;
        assert!(first[0] == 0.0 && first[1] == 0.0 && (first[2] / -fallen - 1.0).abs() < 1e-12, "{first:?}");
        let moving = 0.5 * run.outline.masses[1] * (gravity * dt * f64::from(steps)).powi(2);
        assert!((run.state.kinetic / moving - 1.0).abs() < 1e-12 && run.state.internal == 0.0, "{:?}", run.state);
        assert!(stresses(&run).iter().flatten().all(|s| *s == 0.0));
    }
}

/// About the axis (1, 2, 2) / 3.
#[test]
fn the_impulse_of_supports_in_real_time_is_the_change_of_momentum() {
    for body in Body::all() {
        let bar = |modulus, speed| Drive::bar([modulus, 7.85e-9], None, Speed::Steady(speed));
        let mass = Drive::Mass { mass_kg: 0.01, speed_m_per_s: 3.0 };
        let of = |name, on, rule, drive| SupportSpec { rule, drive: Some(drive), ..SupportSpec::new(name, on) };
        let supports = vec![
            of("input", Side::ZMin, Rule::Plate, bar(2.1e5, 2.0)),
            of("output", Side::ZMax, Rule::Plate, bar(7e4, 0.0)),
            of("striker", Side::XMin, Rule::Plate, mass),
        ];
        let test = Test {
            supports,
            law: LawName::Elastic,
            control: Some(Control::Steady),
            smoothing: Some(body.smoothing),
            duration_s: Some(1e-4),
            ..Test::default()
        };
        let mut run =
            Run::new(Sample::of(&body.mesh, &body.specimen, &body.options), &Materials::default(), &test).unwrap();
        let [mut along, mut across] = [0.0; 2];
        for _ in 0..run.steps() {
            run.state.since_row = Default::default();
            run.advance().unwrap();
            let [input, output, striker, ..] = run.state.since_row.forces;
            along += run.outline.dt * (input + output);
            across += run.outline.dt * striker;
        }
        let momentum = |k: usize| run.nodes.mass.iter().zip(&run.nodes.velocity).map(|(m, v)| m * v[k]).sum::<f64>();
        let [x, z] = [momentum(0), momentum(2)];
        assert!((along / z - 1.0).abs() < 1e-6, "{}: {along} {z}", body.name());
        // A mass gives what it loses.
        let lost = 1e-5 * (3e3 - run.state.held[2][1]);
        assert!((across / lost - 1.0).abs() < 1e-9, "{}: {across} {lost}", body.name());
        assert!((across / x - 1.0).abs() < 1e-6, "{}: {across} {x}", body.name());
        let state = &run.state;
        let off = state.external - state.internal - state.kinetic - state.friction;
        assert!(off.abs() < 1e-3 * state.external, "{}: {off} of {}", body.name(), state.external);
    }
}

fn turn(angle: f64) -> [Mat3; 2] {
    let n = Vec3::new(1.0, 2.0, 2.0) / 3.0;
    let cross = n.cross_matrix();
    let rotation = Mat3::identity() + cross * angle.sin() + cross * cross * (1.0 - angle.cos());
    [cross * angle, rotation - Mat3::identity()]
}

#[test]
fn a_small_rotation_costs_nothing_and_a_finite_one_strains_by_its_cosine_less_1() {
    for body in Body::all() {
        let method = body.name();
        let [small, finite] = turn(0.01);
        let mut run = body.free(LawName::Elastic);
        displace(&mut run, |x| small * x);
        // Displacements of 0.2 mm in f32 over 1 mm: strains of 2e-8. Gradients of 16 bits strain by 4e-5 of the rotation.
        let most = 26_000.0 * if method.contains("Fitted") { 0.01 * 4e-5 } else { 5e-8 };
        assert!(off(&run, &Mat3::zeros()) < most, "{method} {}", off(&run, &Mat3::zeros()));
        // sym(R) - 1 = (cos t - 1) (1 - n n^T): small strains take a finite rotation for a shrinkage.
        displace(&mut run, |x| finite * x);
        let expected = hooke(&Materials::default().mortar, &finite);
        let size = expected.amax();
        assert!(size > 1.0 && off(&run, &expected) < 2e-3 * size + most, "{method} {} of {size}", off(&run, &expected));
        // Forces of a turned body have neither resultant nor moment.
        let forces = forces(&mut run);
        let largest = forces.iter().map(|f| f.norm()).fold(0.0, f64::max);
        let moment: Vec3 = places(&run).iter().zip(&forces).map(|(x, f)| x.cross(f)).sum();
        assert!(forces.iter().sum::<Vec3>().norm() < 1e-4 * largest, "{method}");
        assert!(moment.norm() < 1e-4 * largest * 14.0, "{method} {moment:?}");
    }
}

#[test]
fn a_spinning_body_keeps_its_momenta_and_its_energy() {
    for body in Body::all() {
        let method = body.name();
        let mut run = body.free(LawName::Elastic);
        let (spin, drift) = (Vec3::new(3.0, -2.0, 5.0), Vec3::new(100.0, 0.0, -40.0));
        let places = places(&run);
        let momenta = |run: &Run| {
            let moving = || run.nodes.velocity.iter().zip(&run.nodes.mass).map(|(&v, m)| Vec3::from(v) * *m);
            let turning = moving().zip(&places).map(|(p, x)| x.cross(&p)).sum::<Vec3>();
            (moving().sum::<Vec3>(), turning)
        };
        run.nodes.velocity.iter_mut().zip(&places).for_each(|(v, x)| *v = (drift + spin.cross(x)).into());
        let (line, turning) = momenta(&run);
        let energy = |run: &Run| run.state.kinetic + run.state.internal;
        run.advance().unwrap();
        let before = energy(&run);
        (0..400).for_each(|_| run.advance().unwrap());
        let (line_after, turning_after) = momenta(&run);
        assert!((line_after - line).norm() < 1e-6 * line.norm(), "{method} {line_after:?} {line:?}");
        assert!((turning_after - turning).norm() < 1e-6 * turning.norm(), "{method} {turning_after:?} {turning:?}");
        assert!((energy(&run) / before - 1.0).abs() < 1e-6, "{method} {} {before}", energy(&run));
    }
}

#[test]
fn a_constant_strain_passes_the_patch_test() {
    let gradient = Mat3::new(1.0, 0.4, -0.3, 0.2, -0.8, 0.5, 0.6, -0.1, 0.7) * 1e-3;
    let Materials { mortar, aggregate, .. } = Materials::default();
    let bodies = Body::all().map(|body| (body, mortar));
    for (body, elastic) in bodies.into_iter().chain([(Body::stone(), aggregate)]) {
        let (what, stress) = (body.name(), hooke(&elastic, &gradient));
        let mut run = body.free(LawName::Elastic);
        displace(&mut run, |x| gradient * x);
        assert!(off(&run, &stress) < 1e-4 * stress.amax(), "{what:?} {}", off(&run, &stress));
        let (forces, places) = (forces(&mut run), places(&run));
        balance_inside(&body, &run, &forces, stress.amax());
        // At the surface, sum z f = stress e_z V by the divergence theorem.
        let pull: Vec3 = forces.iter().zip(&places).map(|(f, x)| f * x.z).sum();
        let exact = stress * Vec3::z() * (10.0 * 12.0 * 14.0);
        assert!((pull - exact).norm() < 1e-4 * exact.norm(), "{what:?} {pull:?} {exact:?}");
        let hourglass: f64 = run.blocks.iter().flat_map(|block| &block.groups).map(|group| group.hourglass[0]).sum();
        assert!(hourglass < 1e-8 * 0.5 * 26_000.0 * 1e-6 * 1680.0, "{what:?} {hourglass}");
    }
}

/// No inner node has a force above 1e-4 of that of `stress`, MPa, on a face of an element.
fn balance_inside(body: &Body, run: &Run, forces: &[Vec3], stress: f64) {
    let inner = run.order.iter().zip(forces).filter(|(node, _)| is_inner(&body.mesh, **node as usize));
    let unbalanced: Vec<f64> = inner.map(|(_, force)| force.norm() / (4.0 * stress)).collect();
    assert!(unbalanced.len() > 50 && unbalanced.iter().all(|f| *f < 1e-4), "{unbalanced:?}");
}

/// Saint-Venant's bending: stress E c z along x, and none else.
#[test]
fn aggregates_of_boxes_bend_exactly_and_no_hourglass_mode_has_a_part_in_it() {
    let body = Body::stone();
    let Elastic { youngs_modulus_mpa: e, poisson_ratio: nu, .. } = Materials::default().aggregate;
    let (curvature, middle) = (1e-4, Vec3::new(5.0, 6.0, 7.0));
    for law in [LawName::Elastic, LawName::Cdp] {
        let mut run = body.free(law);
        displace(&mut run, |at| {
            let [x, y, z]: [f64; 3] = (at - middle).into();
            curvature * Vec3::new(x * z, -nu * y * z, -0.5 * (x * x + nu * (z * z - y * y)))
        });
        let moved = run.nodes.displacement.clone();
        let forces = forces(&mut run);
        balance_inside(&body, &run, &forces, e * curvature * 7.0);
        let work: f64 = moved.iter().zip(&forces).map(|(&u, f)| 0.5 * Vec3::from(u).dot(f)).sum();
        // Half of E I c^2 L.
        let exact = 0.5 * e * (12.0 * 14.0_f64.powi(3) / 12.0) * curvature.powi(2) * 10.0;
        assert!((work / exact - 1.0).abs() < 1e-4, "{law:?} {work} {exact}");
        assert!(run.blocks.iter().flat_map(|block| &block.groups).all(|group| group.hourglass == [0.0; 2]));
    }
}

/// Stops after so many rows.
struct Rows(AtomicUsize);

impl Watch for Rows {
    fn stage(&self, _: Stage, _: f64) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }

    fn stops(&self) -> bool {
        self.0.load(Ordering::Relaxed) == 0
    }
}

#[test]
fn a_run_that_diverges_stops_at_once_names_the_element_and_keeps_the_curve() {
    let bodies = Body::all();
    for (body, law) in bodies.iter().flat_map(|body| [(body, LawName::Elastic), (body, LawName::Cdp)]) {
        let method = body.name();
        let mut run = body.run(law);
        let healthy = run.to_end(&Rows(AtomicUsize::new(30)), &Silent);
        // One node in the middle becomes so light that its step is far too long.
        let places = places(&run);
        let middle = Vec3::new(5.0, 6.0, 7.0);
        let light =
            (0..places.len()).min_by(|&a, &b| (places[a] - middle).norm().total_cmp(&(places[b] - middle).norm()));
        let light = light.unwrap();
        run.nodes.mass[light] *= 0.01;
        let (step, node) = (run.state.step, run.order[light]);
        let response = run.to_end(&Silent, &Silent);
        let Ended::Diverged(told) = &response.result.ended else { panic!("{:?}", response.result.ended) };
        let number: usize = told.split_whitespace().nth(1).unwrap().parse().unwrap();
        assert!(body.mesh.cell(number).contains(&node), "{told}");
        assert!(run.state.step < step + 200, "{method}: it took {} steps", run.state.step - step);
        assert_eq!(response.curve[..30], healthy.curve[..]);
        assert!(response.curve.iter().flat_map(crate::Row::values).all(f64::is_finite), "{:?}", response.curve.last());
        // A value that is not finite would be a null; figures that this mesh and test do not have are nulls, too.
        let absent = ["exact_fraction", "displacement_to_half_mm", "broken_stone", "phase_error", "phase_error_of"];
        let figures = serde_json::to_string(&response.result).unwrap();
        let figures = absent.iter().fold(figures, |text, key| text.replace(&format!("\"{key}\":null"), ""));
        assert!(!figures.contains("null") && !figures.contains("NaN"), "{figures}");
        assert!(response.result.errors.iter().any(|error| error.contains("diverged at element")), "{figures}");
    }
}
