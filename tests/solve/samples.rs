//! Small specimens that the tests share.

use meso_core::aggregate::{Aggregate, Grading};
use meso_core::materials::{Materials, Plasticity, Strength};
use meso_core::mesh::{self, ItzForm, Joined, Mesh, MeshOptions, Method, Phase, PhaseVolumes, Tools, VolumeMesher};
use meso_core::specimen::Specimen;
use meso_core::{Model, Silent, Spec, Watch};
use meso_gmsh::Gmsh;
use meso_solve::{LawName, Observer, Response, Run, Sample, Test};

/// A mesh, its specimen and its options.
pub(crate) struct Meshed {
    pub(crate) mesh: Mesh,
    pub(crate) specimen: Specimen,
    pub(crate) options: MeshOptions,
}

impl Meshed {
    /// Meshes bodies in a specimen.
    pub(crate) fn of(bodies: &[Aggregate], specimen: Specimen, options: MeshOptions) -> Self {
        let mesh = mesh::build((bodies, &specimen), &options, &Tools::default()).unwrap();
        Self { mesh, specimen, options }
    }

    /// Mortar alone.
    pub(crate) fn mortar(size_mm: [f64; 3], method: Method, element_size_mm: f64) -> Self {
        Self::of(&[], Specimen::cuboid(size_mm), options(method, element_size_mm, ItzForm::None))
    }

    /// Mortar alone, filled by gmsh; `None` without it.
    pub(crate) fn filled_by_gmsh(side_mm: f64, element_size_mm: f64) -> Option<Self> {
        let gmsh = Gmsh::program("gmsh");
        if gmsh.available().is_err() {
            eprintln!("skipped: no `gmsh` here (Debian: gmsh)");
            return None;
        }
        let mut model = small_cube(0.0);
        model.aggregates.clear();
        let specimen = Specimen::cube(side_mm);
        model.spec.specimen = specimen.clone();
        let options = options(Method::CONFORMING, element_size_mm, ItzForm::None);
        let mesh = mesh::build(&model, &options, &Tools { gmsh: &gmsh, ..Tools::default() }).unwrap();
        Some(Self { mesh, specimen, options })
    }

    /// Volume of the cells, mm3.
    pub(crate) fn mesh_volume_mm3(&self) -> f64 {
        let volumes = PhaseVolumes::of_mesh(&self.mesh);
        Phase::SOLID.into_iter().map(|phase| volumes.of(phase)).sum()
    }

    /// Edge of a cube.
    pub(crate) fn side_mm(&self) -> f64 {
        self.specimen.aabb().size().z
    }

    pub(crate) fn sample(&self) -> Sample<'_> {
        Sample::of(&self.mesh, &self.specimen, &self.options)
    }

    /// The whole test.
    pub(crate) fn solve(&self, materials: &Materials, test: &Test) -> Response {
        self.watched(materials, test, &Silent, &Silent)
    }

    pub(crate) fn watched(
        &self,
        materials: &Materials,
        test: &Test,
        watch: &dyn Watch,
        observer: &dyn Observer,
    ) -> Response {
        Run::new(self.sample(), materials, test).unwrap().to_end(watch, observer)
    }
}

pub(crate) fn options(method: Method, element_size_mm: f64, itz: ItzForm) -> MeshOptions {
    MeshOptions { method, element_size_mm, itz, joined: Joined::Mortar, ..Default::default() }
}

/// A cube of 24 mm with aggregates of 4 to 10 mm, `gap` mm apart.
pub(crate) fn small_cube(gap: f64) -> Model {
    cube(24.0, 3, gap)
}

/// A cube of `size_mm` with aggregates of 4 to 10 mm, `gap` mm apart.
pub(crate) fn cube(size_mm: f64, seed: u64, gap: f64) -> Model {
    packed(Specimen::cube(size_mm), seed, gap)
}

/// A specimen with aggregates of 4 to 10 mm, `gap` mm apart.
fn packed(specimen: Specimen, seed: u64, gap: f64) -> Model {
    let mut spec = Spec { specimen, fraction: 0.3, seed, ..Spec::default() };
    spec.grading = Grading { d_min_mm: 4.0, d_max_mm: 10.0, classes_mm: vec![4.0, 7.0, 10.0], ..Grading::default() };
    spec.placement.min_gap_mm = gap;
    meso_core::pack(&spec, &Silent).unwrap()
}

/// The small cube, meshed.
pub(crate) fn concrete(gap: f64, method: Method, element_size_mm: f64, itz: ItzForm) -> Meshed {
    meshed(&small_cube(gap), options(method, element_size_mm, itz))
}

/// A cube in boxes, with a smeared ITZ.
pub(crate) fn voxels(size_mm: f64, seed: u64, element_size_mm: f64) -> Meshed {
    meshed(&cube(size_mm, seed, 1.0), options(Method::VOXEL, element_size_mm, ItzForm::Smeared))
}

/// A prism twice as high as wide, which stores nearly as much as its cracks spend: it collapses.
pub(crate) fn slender() -> Meshed {
    let model = packed(Specimen::cuboid([20.0, 20.0, 40.0]), 3, 1.0);
    meshed(&model, options(Method::FITTED, 4.0, ItzForm::Smeared))
}

/// A model, meshed.
pub(crate) fn meshed(model: &Model, options: MeshOptions) -> Meshed {
    Meshed::of(&model.aggregates, model.spec.specimen.clone(), options)
}

/// Compressive strength of [`brittle`], MPa.
pub(crate) const BRITTLE_MPA: f64 = 40.0;

/// Materials that soften within a test of 0.5 % strain.
pub(crate) fn brittle() -> Materials {
    let mut materials = Materials::default();
    for (elastic, modulus) in
        [(&mut materials.aggregate, 70e3), (&mut materials.mortar, 26e3), (&mut materials.itz, 20e3)]
    {
        elastic.youngs_modulus_mpa = modulus;
    }
    materials.mortar_strength = Strength {
        compressive_mpa: BRITTLE_MPA,
        peak_strain: 0.0022,
        tensile_mpa: 3.0,
        fracture_energy_n_per_mm: 0.06,
        crushing_energy_n_per_mm: 0.5,
    }
    .into();
    materials.plasticity = Plasticity { dilation_angle_deg: 30.0, meridian_ratio: 0.8, ..materials.plasticity };
    materials
}

/// A test with the law of decks.
pub(crate) fn damaged_plasticity() -> Test {
    Test { law: LawName::Cdp, ..Test::default() }
}

/// Stops a test before its first step.
pub(crate) struct StopAtOnce;

impl Watch for StopAtOnce {
    fn stops(&self) -> bool {
        true
    }
}
