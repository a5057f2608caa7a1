//! Grain libraries from surface and JSON files, put into the spec as if their vertices had been written there.

use super::files::Files;
use super::limits::TIME_LIMIT;
use super::messages::{found, number};
use super::tree::{Node, Value};
use super::{Reading, SpecError};
use crate::distinct;
use meso_collision::geometry::{Polyhedron, TriangleMesh, Triangles, convex_hull};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::{Reduction, Template};
use meso_concrete::import;
use meso_concrete::import::harmonics::{self, Harmonics};
use meso_concrete::import::polygon::Polygons;
use meso_concrete::short;
use meso_concrete::stop::{self, Late};
use meso_concrete::watch::{Waiting, Watch};
use serde::Deserialize;
use std::fmt;

const KEY: &str = "shape.library";
/// The other name of the key.
const PATH: &str = "shape.path";
const HULL: &str = "shape.hull";
const TOLERANCE: &str = "shape.tolerance";
/// Scans are reduced to this share of their length where no tolerance is given, and have more triangles than that.
const USUAL_TOLERANCE: f64 = 0.005;
const SCAN: usize = 20_000;
/// Largest tolerance: a tenth of the length leaves some ten corners.
const MOST_TOLERANCE: f64 = 0.1;
/// A surface that holds less than this share of its hull is not convex; coordinates in f32 dent a convex one by 1e-6.
const CONVEX: f64 = 0.999;
/// Bodies below this share of the volume of the largest in their file are specks, as scanners leave them.
pub(super) const SPECK: f64 = 1e-3;
/// Thickness of the flattest stone that is taken, as a share of its length.
const LEAST_THICKNESS: f64 = 1e-3;
const NO_LIST: &str = "it is not a list of grains, each its vertices, [[x, y, z], ...], or with its faces, {\"vertices\": [[x, y, z], \
                       ...], \"faces\": [[0, 1, 2], ...]}";
const ROUND: &str = "it is a ball or an ellipsoid, saved as the ends of its axes, and a library takes polyhedra; convert the model to \
                     STL and name that file, or set shape.kind to \"sphere\" or \"ellipsoid\"";

/// Replaces `shape.library` by the grains that its file, or the files of its folder, hold. With `shape.hull` each is the
/// convex hull of its body. With the kind `harmonics` the files hold coefficients. The time limit counts for grains of files,
/// which are not proved yet, and is returned for them.
///
/// # Errors
/// Names the key, the file and the fault; an error [is late](SpecError::is_late) where the time limit was over before all
/// grains were read.
pub(super) fn inline(tree: &mut Node, reading: &mut Reading<'_>) -> Result<Limit, SpecError> {
    let limit = Limit::of(tree, reading.time_limit_s);
    let Some(shape) = tree.child_mut("shape") else { return Ok(Limit::NONE) };
    let hull = shape.take("hull").map(|(_, node)| node);
    let is_harmonic = shape.child("kind").is_some_and(|kind| kind.value == Value::Text(HARMONICS.to_owned()));
    let is_library = !is_harmonic && (shape.child("library").is_some() || shape.child("path").is_some());
    for (key, counts, place) in [
        (TOLERANCE, is_library, "a library of surfaces"),
        ("shape.degree", is_harmonic, "kind = \"harmonics\""),
        ("shape.triangles", is_harmonic, "kind = \"harmonics\""),
    ] {
        let given = shape.child(key.trim_start_matches("shape."));
        if let (Some(Node { line, .. }), false) = (given, counts) {
            let message = format!("counts only for {place}; leave it out");
            return Err(SpecError { line: *line, ..SpecError::value(key, message) });
        }
    }
    let tolerance = tolerance(shape)?;
    let [degree, triangles] = [DEGREE, TRIANGLES].map(|option| option.taken(shape));
    let library = shape.take("library").or_else(|| shape.take("path"));
    let Some((key, Node { value, line })) = library else {
        let message = "counts only for a library, the grains of a file; leave it out";
        let unused = |node: Node| Err(SpecError { line: node.line, ..SpecError::value(HULL, message) });
        return if is_harmonic { Err(SpecError::value(PATH, NO_FOLDER)) } else { hull.map_or(Ok(Limit::NONE), unused) };
    };
    let key = if key == "path" { PATH } else { KEY };
    let takes_hull = match hull {
        None => false,
        Some(Node { value: Value::Bool(flag), .. }) => flag,
        Some(node) => {
            let message = format!("is {}; it must be true or false", found(&node.unexpected()));
            return Err(SpecError { is_wrong_type: true, line: node.line, ..SpecError::value(HULL, message) });
        }
    };
    let Value::Text(name) = value else {
        let message = "must be the name of a folder, or of a file of grains (STL, PLY, OBJ, OFF, JSON) in quotes";
        return Err(SpecError { is_wrong_type: true, line, ..SpecError::value(key, message) });
    };
    let form = if is_harmonic { Form::Harmonics { degree: degree?, triangles: triangles? } } else { Form::Surfaces };
    let mut reader = GrainReader { files: &mut *reading.files, takes_hull, form, tolerance };
    let late = |Late| limit.late(&format!("{key} {name:?} was read"), GRAINS);
    let grains = stop::until(limit.waiting(reading.watch), || reader.grains(&name)).map_err(late)?;
    let named = |reason| SpecError { line, ..SpecError::value(key, format!("is {name:?}: {reason}")) };
    let grains = grains.map_err(named)?;
    let kind = if is_harmonic { None } else { shape.take("kind") };
    shape.take("kind");
    if let Value::Table(entries) = &mut shape.value {
        let grains = grains.iter().map(|grain| grain.node(line));
        entries.push(("grains".to_owned(), node(Value::Array(grains.collect()), line)));
        entries.push(kind.unwrap_or_else(|| ("kind".to_owned(), node(Value::Text("library".to_owned()), line))));
    }
    Ok(limit)
}

/// What saves the time that grains of files take.
pub(super) const GRAINS: &str = "reduced grains";

/// The time limit of a reading.
#[derive(Clone, Copy)]
pub(super) struct Limit {
    seconds: Option<f64>,
    /// Its line, where it is the spec's own.
    line: Option<usize>,
}

impl Limit {
    const NONE: Self = Self { seconds: None, line: None };

    /// The one that is given, or the spec's own where that is a number.
    pub(super) fn of(tree: &Node, given: Option<f64>) -> Self {
        if given.is_some() {
            return Self { seconds: given, line: None };
        }
        let own = tree.child("placement").and_then(|placement| placement.child("time_limit_s"));
        let seconds = own.and_then(|own| match own.value {
            Value::Integer(n) => Some(n as f64),
            Value::Float(x) => Some(x),
            _ => None,
        });
        Self { seconds, line: own.and_then(|own| own.line) }
    }

    /// The wait that it allows for.
    pub(super) fn waiting(self, watch: &dyn Watch) -> Waiting<'_> {
        Waiting { watch, deadline: self.seconds.map_or(f64::INFINITY, |limit| watch.began() + limit) }
    }

    /// The error of a limit that was over while something was done.
    pub(super) fn late(self, done: &str, reduced: &str) -> SpecError {
        let limit = number(self.seconds.unwrap_or(f64::INFINITY));
        let message = format!(
            "is {limit}, which was over while {done}: no time was left for it; raise the limit, or save {reduced} first"
        );
        SpecError { is_late: true, line: self.line, ..SpecError::value(TIME_LIMIT, message) }
    }
}

/// Takes the distance that a surface may be reduced to, as a share of its length.
fn tolerance(shape: &mut Node) -> Result<Option<f64>, SpecError> {
    let Some((_, given)) = shape.take("tolerance") else { return Ok(None) };
    let share = match given.value {
        Value::Integer(n) => n as f64,
        Value::Float(x) => x,
        _ => f64::NAN,
    };
    if (0.0..=MOST_TOLERANCE).contains(&share) {
        return Ok(Some(share));
    }
    let message =
        format!("is {}; it must be a share of a grain's length, 0 to {MOST_TOLERANCE}", found(&given.unexpected()));
    Err(SpecError { line: given.line, ..SpecError::value(TOLERANCE, message) })
}

const HARMONICS: &str = "harmonics";
const NO_FOLDER: &str = "is missing; name a folder of coefficients, or a file that ends in .dat, .anm or .txt";

/// A whole number that counts only for harmonics.
struct Whole {
    key: &'static str,
    usual: u32,
    range: [u32; 2],
}

const DEGREE: Whole = Whole { key: "degree", usual: 12, range: [1, harmonics::MOST_DEGREE] };
const TRIANGLES: Whole = Whole { key: "triangles", usual: 160, range: [20, 5000] };

impl Whole {
    /// Takes the value out of the table; the usual one where it is not given.
    fn taken(&self, shape: &mut Node) -> Result<u32, SpecError> {
        let Some((_, given)) = shape.take(self.key) else { return Ok(self.usual) };
        let [low, high] = self.range;
        match given.value {
            Value::Integer(n) if (i128::from(low)..=i128::from(high)).contains(&n) => Ok(n as u32),
            _ => {
                let message =
                    format!("is {}; it must be a whole number from {low} to {high}", found(&given.unexpected()));
                Err(SpecError { line: given.line, ..SpecError::value(format!("shape.{}", self.key), message) })
            }
        }
    }
}

fn node(value: Value, line: Option<usize>) -> Node {
    Node { value, line }
}

fn row(vertex: &Vec3) -> Node {
    Node::list(vertex.iter().map(|&x| Value::Float(x)))
}

/// A grain as it is put into the spec.
struct Inlined {
    vertices: Vec<Vec3>,
    /// Triangles of a closed surface with dents; none where the grain is the hull of its vertices.
    triangles: Vec<[u32; 3]>,
    reduced: Option<Reduction>,
}

impl Inlined {
    fn node(&self, line: Option<usize>) -> Node {
        let vertices = node(Value::Array(self.vertices.iter().map(row).collect()), line);
        if self.triangles.is_empty() && self.reduced.is_none() {
            return vertices;
        }
        let table = |entries: Vec<(&str, Node)>| {
            node(Value::Table(entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()), line)
        };
        let face = |t: &[u32; 3]| Node::list(t.iter().map(|&corner| Value::Integer(corner.into())));
        let faces = || node(Value::Array(self.triangles.iter().map(face).collect()), line);
        let reduced = |reduced: Reduction| {
            table(vec![
                ("scanned_triangles", node(Value::Integer(reduced.scanned_triangles as i128), line)),
                ("triangles", node(Value::Integer(reduced.triangles as i128), line)),
                ("distance", node(Value::Float(reduced.distance), line)),
                ("volume_change", node(Value::Float(reduced.volume_change), line)),
            ])
        };
        let mut entries = vec![("vertices", vertices)];
        entries.extend((!self.triangles.is_empty()).then(|| ("faces", faces())));
        entries.extend(self.reduced.map(|value| ("reduced", reduced(value))));
        table(entries)
    }
}

/// What the files hold.
#[derive(Clone, Copy)]
enum Form {
    /// Closed surfaces, or lists of vertices.
    Surfaces,
    /// Coefficients, cut at a degree and turned into triangles.
    Harmonics { degree: u32, triangles: u32 },
}

impl Form {
    /// Endings of the names of files of grains.
    fn endings(self) -> Vec<&'static str> {
        match self {
            Self::Surfaces => import::ENDINGS.into_iter().chain(["json"]).collect(),
            Self::Harmonics { .. } => vec!["dat", "anm", "txt"],
        }
    }

    fn is_grain_file(self, name: &str) -> bool {
        import::ending(name).is_some_and(|ending| self.endings().contains(&ending.as_str()))
    }
}

/// Where a grain stands.
#[derive(Clone, Copy)]
struct Place<'a> {
    file: &'a str,
    /// Begins a remark about one of several grains in the file.
    within: &'a str,
}

/// Reads grains, convex ones and those with dents.
struct GrainReader<'a> {
    files: &'a mut dyn Files,
    /// Whether bodies that are not convex count as their hulls.
    takes_hull: bool,
    form: Form,
    /// Share of its length within which a surface is reduced; absent: scans alone.
    tolerance: Option<f64>,
}

impl GrainReader<'_> {
    /// Every grain in the file, or in the files of the folder in the order of their names.
    fn grains(&mut self, name: &str) -> Result<Vec<Inlined>, String> {
        if self.form.is_grain_file(name) {
            return self.read(name);
        }
        let readable = import::list(&self.form.endings());
        let no_folder = |error| format!("{error}; it is no folder, and a file of grains ends in {readable}");
        let mut names: Vec<String> = self.files.list(name).map_err(no_folder)?;
        names.retain(|name| self.form.is_grain_file(name));
        names.sort();
        if names.is_empty() {
            return Err(format!("the folder holds no file that ends in {readable}"));
        }
        let (mut all, mut passed_over) = (Vec::new(), Vec::new());
        for file in names {
            let path = format!("{}/{file}", name.trim_end_matches('/'));
            match self.read_of_folder(&path).map_err(|reason| format!("{file}: {reason}"))? {
                Some(mut grains) => all.append(&mut grains),
                None => passed_over.push(file),
            }
        }
        let others = passed_over.join(", ");
        if all.is_empty() {
            return Err(format!("none of its files begins with a coefficient, `0 0 Re Im`: {others}"));
        }
        if !passed_over.is_empty() {
            let count = passed_over.len();
            let remark =
                format!("{count} file(s) that begin with no coefficient, n m Re Im, were passed over: {others}");
            self.files.remark(name, &remark);
        }
        Ok(all)
    }

    /// The grains in a file of a folder; `None` where it has no coefficients, as the tables beside stones.
    fn read_of_folder(&mut self, name: &str) -> Result<Option<Vec<Inlined>>, String> {
        let bytes = self.files.read(name).map_err(|error| error.to_string())?;
        if matches!(self.form, Form::Harmonics { .. }) && !Harmonics::begin(&bytes) {
            return Ok(None);
        }
        self.grains_in(name, &bytes).map(Some)
    }

    fn read(&mut self, name: &str) -> Result<Vec<Inlined>, String> {
        let bytes = self.files.read(name).map_err(|error| error.to_string())?;
        self.grains_in(name, &bytes)
    }

    fn grains_in(&mut self, name: &str, bytes: &[u8]) -> Result<Vec<Inlined>, String> {
        if let Form::Harmonics { degree, triangles } = self.form {
            return self.stone(name, bytes, degree, triangles).map(|stone| vec![stone]);
        }
        if import::ending(name).as_deref() == Some("json") {
            return self.json_grains(name, bytes);
        }
        let (mut bodies, notes) =
            import::read_bodies(name, bytes).map_err(|error| misnamed(name, bytes, &self.form.endings(), &error))?;
        notes.iter().for_each(|note| self.files.remark(name, note));
        let count = bodies.len();
        let is_closed = bodies.iter().all(|body| body.check_edges().is_ok());
        if is_closed && bodies.iter().map(TriangleMesh::volume).sum::<f64>() < 0.0 {
            bodies.iter_mut().flat_map(|body| &mut body.triangles).for_each(|triangle| triangle.swap(1, 2));
            self.files.remark(name, "its triangles are clockwise seen from outside; they were turned");
        }
        let place = Place { file: name, within: "" };
        let bodies = self.without_hollows(place, bodies);
        let bodies = self.without_specks(place, bodies);
        if let Some([outer, inner]) = nested(&bodies) {
            return Err(format!(
                "body {inner} of {count}, counted from 0, lies within body {outer}; turn the triangles of a hollow's surface \
                 round, or leave one of the two out"
            ));
        }
        let alone = bodies.len() == 1;
        let named = |(i, body): (usize, TriangleMesh)| {
            let within = import::numbers(i, 1, if alone { 1 } else { count });
            let place = Place { file: name, within: &within };
            self.grain(place, body).map_err(|reason| format!("{within}{reason}"))
        };
        bodies.into_iter().map(named).collect()
    }

    fn remark(&mut self, place: Place<'_>, remark: &str) {
        self.files.remark(place.file, &format!("{}{remark}", place.within));
    }

    /// The bodies with their numbers, without those that are the surface of a hollow in another one, with a remark about
    /// these.
    fn without_hollows(&mut self, place: Place<'_>, bodies: Vec<TriangleMesh>) -> Vec<(usize, TriangleMesh)> {
        let (solid, turned): (Vec<_>, Vec<_>) = (0..bodies.len()).partition(|&i| bodies[i].volume() > 0.0);
        let surfaces: Vec<Triangles> =
            if turned.is_empty() { Vec::new() } else { solid.iter().map(|&i| bodies[i].facets()).collect() };
        let is_hollow = |i: &usize| surfaces.iter().any(|surface| surface.contains(&bodies[*i].vertices[0]));
        let hollows: Vec<usize> = turned.into_iter().filter(is_hollow).collect();
        if !hollows.is_empty() {
            let volume = |which: &[usize]| which.iter().map(|&i| bodies[i].volume().abs()).sum::<f64>();
            let percent = 100.0 * volume(&hollows) / volume(&solid);
            self.remark(place, &format!("{} hollow(s), {percent:.2} % of the volume, were filled", hollows.len()));
        }
        bodies.into_iter().enumerate().filter(|(i, _)| !hollows.contains(i)).collect()
    }

    /// The bodies that are no specks beside the largest one, with a remark about how many there are.
    fn without_specks(
        &mut self,
        place: Place<'_>,
        mut bodies: Vec<(usize, TriangleMesh)>,
    ) -> Vec<(usize, TriangleMesh)> {
        let sizes: Vec<f64> = bodies.iter().map(|(_, body)| room(body)).collect();
        let largest = sizes.iter().copied().fold(0.0, f64::max);
        let count = bodies.len();
        let mut sizes = sizes.into_iter();
        bodies.retain(|_| sizes.next().is_none_or(|size| size >= SPECK * largest));
        let (kept, specks) = (bodies.len(), count - bodies.len());
        if specks > 0 {
            self.remark(
                place,
                &format!(
                    "it has {count} bodies: {specks} below {SPECK} of the volume of the largest were dropped, as scans have specks; \
                     {kept} left"
                ),
            );
        } else if count > 1 {
            self.remark(place, &format!("it has {count} bodies, and each is a grain of equal right"));
        }
        bodies
    }

    /// The distance within which a surface of so many triangles is reduced, as a share of its length and in mm; `None` where
    /// it is left as it is.
    fn distance(&self, vertices: &[Vec3], triangles: usize) -> Option<[f64; 2]> {
        let share = self.tolerance.unwrap_or(if triangles > SCAN { USUAL_TOLERANCE } else { 0.0 });
        (share > 0.0).then(|| [share, share * Aabb::around(vertices).size().max()])
    }

    /// Remarks on what a reduction left, its triangles from and to or corners, and what it changed.
    fn told(&mut self, place: Place<'_>, left: &str, distance_mm: f64, reduction: Reduction) -> Reduction {
        let Reduction { distance, volume_change, .. } = reduction;
        let (share, percent) = (short(100.0 * distance), 100.0 * volume_change);
        let remark = format!(
            "{left}, nowhere more than {distance_mm:.3} mm away ({share} % of its length); its volume changed by {percent:+.2} %"
        );
        self.remark(place, &remark);
        reduction
    }

    /// A surface in fewer triangles, and what that changed, with a remark; others as they are.
    fn reduced(
        &mut self,
        place: Place<'_>,
        surface: TriangleMesh,
    ) -> Result<(TriangleMesh, Option<Reduction>), String> {
        let scanned_triangles = surface.triangles.len();
        let Some([distance, mm]) = self.distance(&surface.vertices, scanned_triangles) else {
            return Ok((surface, None));
        };
        let reduced = surface.reduced(mm).map_err(|error| error.to_string())?;
        let triangles = reduced.triangles.len();
        if triangles == scanned_triangles {
            self.remark(place, &format!("its {triangles} triangles stay: no fewer lie within {mm:.1e} mm of it"));
            return Ok((surface, None));
        }
        let left = format!("{scanned_triangles} triangles became {triangles}");
        let volume_change = reduced.volume() / surface.volume() - 1.0;
        let reduction = Reduction { scanned_triangles, triangles, distance, volume_change };
        Ok((reduced, Some(self.told(place, &left, mm, reduction))))
    }

    /// The vertices of the hull of so many triangles, or some of them, with a remark, where there are many.
    fn hull(&mut self, place: Place<'_>, hull: &Polyhedron, triangles: usize) -> Result<Inlined, String> {
        let of_hull = hull.triangles().count();
        let Some([distance, mm]) = self.distance(hull.vertices(), triangles.max(of_hull)) else {
            return convex(hull, None);
        };
        let reduced = hull.reduced_hull(mm).map_err(|error| error.to_string())?;
        let [before, after] = [hull, &reduced].map(|hull| hull.vertices().len());
        if after == before {
            return convex(&reduced, None);
        }
        let left = format!("{before} corners of its hull became {after}");
        let (triangles, volume_change) = (reduced.triangles().count(), reduced.volume() / hull.volume() - 1.0);
        let reduction = Reduction { scanned_triangles: of_hull, triangles, distance, volume_change };
        convex(&reduced, Some(self.told(place, &left, mm, reduction)))
    }

    /// The stone of a file of coefficients, and a remark about the volume that its triangles hold.
    fn stone(&mut self, name: &str, bytes: &[u8], degree: u32, triangles: u32) -> Result<Inlined, String> {
        let coefficients = Harmonics::read(bytes, degree);
        let stone = coefficients.map_err(|error| misnamed(name, bytes, &self.form.endings(), &error))?;
        let surface = stone.surface(triangles as usize).map_err(|error| error.to_string())?;
        let percent = 100.0 * surface.volume() / stone.volume();
        let (degree, triangles) = (stone.degree(), surface.triangles.len());
        self.files.remark(name, &format!("{triangles} triangles hold {percent:.1} % of the volume of degree {degree}"));
        if stone.left_out() > 0 {
            self.files.remark(name, &format!("{} coefficients that it leaves out count as 0", stone.left_out()));
        }
        self.grain(Place { file: name, within: "" }, surface)
    }

    fn json_grains(&mut self, file: &str, bytes: &[u8]) -> Result<Vec<Inlined>, String> {
        let grains = listed(bytes).map_err(|error| misnamed(file, bytes, &self.form.endings(), &error))?;
        let alone = grains.len() == 1;
        let named = |(i, grain): (usize, ReadGrain)| {
            let (name, vertices, faces, round) = match grain {
                ReadGrain::Vertices(vertices) => (None, vertices, None, false),
                ReadGrain::Named { name, vertices, faces, round } => (name, vertices, faces, round),
            };
            let name = name.unwrap_or_else(|| format!("grain {i}"));
            let within = if alone { String::new() } else { format!("{name}: ") };
            let place = Place { file, within: &within };
            let grain = if round { Err(ROUND.to_owned()) } else { self.json_grain(place, vertices, faces) };
            grain.map_err(|reason| format!("{name}: {reason}"))
        };
        grains.into_iter().enumerate().map(named).collect()
    }

    fn json_grain(
        &mut self,
        place: Place<'_>,
        vertices: Vec<[f64; 3]>,
        faces: Option<Vec<Vec<u32>>>,
    ) -> Result<Inlined, String> {
        let vertices: Vec<Vec3> = vertices.into_iter().map(Vec3::from).collect();
        let Some(faces) = faces else {
            let hull = convex_hull(&vertices).map_err(|error| error.to_string())?;
            return self.hull(place, &hull, 0);
        };
        if let Some(corner) = faces.iter().flatten().find(|&&corner| corner as usize >= vertices.len()) {
            return Err(format!("a face names vertex {corner} of {}", vertices.len()));
        }
        let (mut polygons, mut triangles) = (Polygons::default(), Vec::new());
        for face in &faces {
            let corners: Vec<Vec3> = face.iter().map(|&corner| vertices[corner as usize]).collect();
            triangles.extend(polygons.triangles(&corners).iter().map(|t| t.map(|corner| face[corner])));
        }
        polygons.notes().for_each(|note| self.remark(place, &note));
        let surface = TriangleMesh { triangles, vertices };
        if self.takes_hull {
            return self.grain(place, surface);
        }
        let mut bodies = self.without_hollows(place, import::bodies(&surface));
        self.grain(place, if bodies.len() == 1 { bodies.remove(0).1 } else { surface })
    }

    /// A closed surface, in fewer triangles where it has many; the hull of a convex one, or of any where hulls are taken.
    fn grain(&mut self, place: Place<'_>, surface: TriangleMesh) -> Result<Inlined, String> {
        stop::point();
        let hull = surface.hull().map_err(|error| error.to_string())?;
        if self.takes_hull {
            return self.hull(place, &hull, surface.triangles.len());
        }
        surface.check_closed().map_err(|error| error.to_string())?;
        if surface.volume() / hull.volume() >= CONVEX {
            return self.hull(place, &hull, surface.triangles.len());
        }
        let (surface, reduced) = self.reduced(place, surface)?;
        let hull = surface.hull().map_err(|error| error.to_string())?;
        if surface.volume() / hull.volume() >= CONVEX {
            return convex(&hull, reduced);
        }
        thick_enough(&Template::of_surface(surface.clone()).map_err(|error| error.to_string())?)?;
        let TriangleMesh { vertices, triangles } = surface;
        Ok(Inlined { vertices, triangles, reduced })
    }
}

/// Volume of a body, or of the box about one that is not closed.
fn room(body: &TriangleMesh) -> f64 {
    match body.check_edges() {
        Ok(()) => body.volume().abs(),
        Err(_) => Aabb::around(&body.vertices).size().product(),
    }
}

/// The numbers of the first two bodies of which one lies within the other.
fn nested(bodies: &[(usize, TriangleMesh)]) -> Option<[usize; 2]> {
    let boxes: Vec<Aabb> = bodies.iter().map(|(_, body)| Aabb::around(&body.vertices)).collect();
    let holds = |outer: &Aabb, inner: &Aabb| {
        (0..3).all(|axis| outer.min[axis] <= inner.min[axis] && inner.max[axis] <= outer.max[axis])
    };
    bodies.iter().zip(&boxes).find_map(|((outer, body), aabb)| {
        let mut within = bodies.iter().zip(&boxes).filter(|((inner, _), inside)| inner != outer && holds(aabb, inside));
        let first = within.next()?;
        let surface = body.facets();
        let lies_within = |((_, inner), _): &(&(usize, TriangleMesh), &Aabb)| surface.contains(&inner.vertices[0]);
        let found = std::iter::once(first).chain(within).find(lies_within)?;
        Some([*outer, found.0.0])
    })
}

/// The error of a file's bytes, or of its name where that says another format than they have.
fn misnamed(name: &str, bytes: &[u8], read_here: &[&str], error: &dyn fmt::Display) -> String {
    import::misnamed(name, bytes, read_here).unwrap_or_else(|| error.to_string())
}

/// A convex grain.
fn convex(hull: &Polyhedron, reduced: Option<Reduction>) -> Result<Inlined, String> {
    let vertices = hull.vertices().to_vec();
    thick_enough(&Template::new(vertices.clone()).map_err(|error| error.to_string())?)?;
    Ok(Inlined { vertices, triangles: Vec::new(), reduced })
}

/// Refuses stones that are nearly flat: they have next to no volume, and are thinner than all that is made of them.
fn thick_enough(stone: &Template) -> Result<(), String> {
    let thickness = stone.thickness();
    if thickness >= LEAST_THICKNESS {
        return Ok(());
    }
    Err(format!(
        "it is nearly flat, {thickness:.1e} of its length thick, and a grain needs {LEAST_THICKNESS}; leave it out"
    ))
}

/// A list of grains, bare or under `grains` or (a saved model) `aggregates`.
#[derive(Deserialize)]
#[serde(untagged)]
enum Listed {
    Bare(Vec<ReadGrain>),
    Grains { grains: Vec<ReadGrain> },
    Model { aggregates: Vec<ReadGrain> },
}

/// A grain is the hull of its vertices where nothing is said of faces.
#[derive(Deserialize)]
#[serde(untagged)]
enum ReadGrain {
    Vertices(Vec<[f64; 3]>),
    Named {
        name: Option<String>,
        vertices: Vec<[f64; 3]>,
        faces: Option<Vec<Vec<u32>>>,
        /// True for a ball or an ellipsoid of a saved model, whose vertices are the ends of its axes.
        #[serde(default)]
        round: bool,
    },
}

fn listed(bytes: &[u8]) -> Result<Vec<ReadGrain>, String> {
    // Some programs begin a text with its byte order.
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = serde_json::Deserializer::from_slice(bytes);
    let tree = distinct::value(&mut reader).and_then(|tree| reader.end().map(|()| tree));
    let tree = tree.map_err(|error| match error.is_data() {
        true => error.to_string(),
        false => format!("it is not JSON: {error}"),
    })?;
    let (Listed::Bare(grains) | Listed::Grains { grains } | Listed::Model { aggregates: grains }) =
        serde_json::from_value(tree).map_err(|_| NO_LIST)?;
    if grains.is_empty() { Err("it has no grains".to_owned()) } else { Ok(grains) }
}
