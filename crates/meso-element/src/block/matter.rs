//! Material of a phase: its elasticity, its density, and its law.

use crate::hex::{BoxShape, hourglass_stiffness};
use crate::law::LawName;
use crate::law::{self, Law, cdp, cdpm2, meso};
use crate::real::Real;
use meso_concrete::{OutOfRange, PhaseNames};
use meso_mesh::Phase;
use meso_mesh::materials::{Cdpm2Parameters, Elastic, MATERIALS, Materials, Mesoscale, Plasticity, Stone, Strength};
use std::any::Any;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::OnceLock;

/// A phase's material.
#[derive(Clone, Debug)]
pub struct Matter {
    /// Stiffness and density.
    pub elastic: Elastic,
    /// How it answers strain.
    pub behaviour: Behaviour,
    /// Whether it is elastic under every law, so that its boxes bend.
    pub is_unbreakable: bool,
    /// The law on the lanes of the run.
    prepared: Prepared,
}

/// A law that is prepared once: its constants take as long as a hundred elements.
#[derive(Default)]
struct Prepared(OnceLock<Box<dyn Any + Send + Sync>>);

impl Prepared {
    /// The law that `prepare` gives; on lanes other than the first ones it is prepared anew. Compiled once a law: `prepare` is
    /// another closure in each task.
    fn law<W: Any + Send + Sync>(&self, prepare: &dyn Fn() -> W) -> PreparedLaw<'_, W> {
        match self.0.get_or_init(|| Box::new(prepare())).downcast_ref() {
            Some(law) => PreparedLaw::Kept(law),
            None => PreparedLaw::New(Box::new(prepare())),
        }
    }
}

/// A law that is kept, or a new one; behind one address, to which kernels add those of its values.
enum PreparedLaw<'a, W> {
    Kept(&'a W),
    New(Box<W>),
}

impl<W> PreparedLaw<'_, W> {
    #[inline(always)]
    fn get(&self) -> &W {
        match self {
            Self::Kept(law) => law,
            Self::New(law) => law,
        }
    }
}

impl Clone for Prepared {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl fmt::Debug for Prepared {
    fn fmt(&self, _: &mut fmt::Formatter) -> fmt::Result {
        Ok(())
    }
}

/// The laws that a phase may follow.
#[derive(Clone, Debug)]
pub enum Behaviour {
    /// Linear elasticity.
    Elastic,
    /// Concrete damaged plasticity.
    Cdp(Strength, Plasticity),
    /// CDPM2, with the biaxial over the uniaxial strength.
    Cdpm2(Strength, f64, Cdpm2Parameters),
    /// Mortar between grains.
    Meso(Strength, Mesoscale),
    /// The same in steps of some seconds, with strengths that grow with the rate of strain.
    Rated(Strength, Mesoscale, f64),
    /// Mortar between grains, with strengths that scatter by this factor at most.
    Scattered(Strength, Mesoscale, f64),
    /// Both: the step, s, and the largest factor.
    RatedScattered(Strength, Mesoscale, [f64; 2]),
}

/// Finds out whether the law `name` can have `materials`.
///
/// # Errors
/// Names the first value that it cannot have.
pub fn validate(materials: &Materials, name: LawName) -> Result<(), OutOfRange> {
    carried(materials, name)?;
    match name {
        LawName::Elastic => materials.validate_elastic(),
        LawName::Cdp => cdp::validate(materials),
        LawName::Cdpm2 => cdpm2::validate(materials),
        LawName::Meso => meso::validate(materials),
    }?;
    validate_stone(materials, name)?;
    materials.validate_scatter(name)?;
    materials.validate_cohesive()
}

/// Checks the strengths of stone as the law checks those of a mortar.
fn validate_stone(materials: &Materials, name: LawName) -> Result<(), OutOfRange> {
    materials.validate_stone()?;
    let (Some(stone), true) = (&materials.aggregate_strength, name != LawName::Elastic) else { return Ok(()) };
    let elastic = materials.aggregate;
    let of_stone = |text: &str| text.replace("mortar_strength", "aggregate_strength").replace("MORTAR", "AGGREGATE");
    stone.strengths().into_iter().try_for_each(|mortar_strength| {
        let as_mortar = Materials {
            mortar: elastic,
            itz: elastic,
            itz_strength_ratio: 1.0,
            mortar_strength: mortar_strength.into(),
            aggregate_strength: None,
            own: BTreeMap::new(),
            ..materials.clone()
        };
        let renamed =
            |error: OutOfRange| OutOfRange { key: of_stone(&error.key), accepted: of_stone(&error.accepted), ..error };
        validate(&as_mortar, name).map_err(renamed)
    })
}

/// Least and largest value of a stiffness, strength or energy of which single precision carries squares and quotients.
const CARRIED: [f64; 2] = [1e-12, 1e12];

/// Refuses values that single precision cannot carry. Values at or below 0 have their own ranges.
fn carried(materials: &Materials, law: LawName) -> Result<(), OutOfRange> {
    let stiffness = |(name, values, _): (&str, Elastic, Option<f64>)| {
        (format!("{name}.youngs_modulus_mpa"), values.youngs_modulus_mpa)
    };
    let given = materials.mortar_strength.of(law);
    let strengths = [
        ("compressive_mpa", given.compressive_mpa),
        ("tensile_mpa", given.tensile_mpa),
        ("fracture_energy_n_per_mm", given.fracture_energy_n_per_mm),
        ("crushing_energy_n_per_mm", given.crushing_energy_n_per_mm),
    ];
    let strengths = strengths.map(|(key, value)| (format!("mortar_strength.{key}"), value));
    let [least, most] = CARRIED;
    for (key, value) in materials.by_name().map(stiffness).chain(strengths) {
        let met = !(value > 0.0 && value.is_finite()) || (least..=most).contains(&value);
        MATERIALS.require(key, value, met, "the solver computes in single precision and takes 1e-12 to 1e12")?;
    }
    Ok(())
}

/// Tensile over compressive strength below which CDPM2 gains too much from lateral pressure: the slope of its compressive
/// meridian at no pressure is 1 + m0 / 2, which is 6.6 here and 7.8 at 0.075; tests have 4 to 5.
const LOW_TENSION: f64 = 0.09;

/// Work with a law over the numbers `R`. Give `run` `#[inline(always)]`.
pub trait LawTask<R: Real> {
    /// The answer.
    type Output;
    /// Does the work.
    fn run<W: Law<R>>(self, law: &W) -> Self::Output;
}

impl Matter {
    /// Material of one of the `phases`; those with a strength follow the law `name`.
    pub fn new(materials: &Materials, phase: Phase, phases: &PhaseNames, name: LawName) -> Self {
        Self::with(materials, materials.elastic(phase, phases), materials.strength(phase, phases, name), name)
    }

    /// Materials of stone that breaks, in the order of [`Stone::strengths`].
    pub fn stones(materials: &Materials, stone: &Stone, name: LawName) -> Vec<Self> {
        let of = |strength| Self::with(materials, materials.aggregate, Some(strength), name);
        stone.strengths().into_iter().map(of).collect()
    }

    fn with(materials: &Materials, elastic: Elastic, strength: Option<Strength>, name: LawName) -> Self {
        let behaviour = match (name, strength) {
            (LawName::Elastic, _) | (_, None) => Behaviour::Elastic,
            (LawName::Cdp, Some(strength)) => Behaviour::Cdp(strength, materials.plasticity),
            (LawName::Cdpm2, Some(strength)) => {
                Behaviour::Cdpm2(strength, materials.plasticity.biaxial_ratio, materials.cdpm2)
            }
            (LawName::Meso, Some(strength)) => Behaviour::Meso(strength, materials.meso),
        };
        Self { is_unbreakable: strength.is_none(), ..Self::of(elastic, behaviour) }
    }

    /// An elasticity and a law.
    pub fn of(elastic: Elastic, behaviour: Behaviour) -> Self {
        Self { elastic, behaviour, is_unbreakable: false, prepared: Prepared::default() }
    }

    /// Runs `task` with the phase's law.
    #[inline(always)]
    pub fn law<R: Real + 'static, T: LawTask<R>>(&self, task: T) -> T::Output {
        match &self.behaviour {
            Behaviour::Elastic => task.run(&law::Hooke::<R>::new(&self.elastic)),
            Behaviour::Cdp(strength, plasticity) => {
                task.run(self.prepared.law(&|| self.cdp::<R>(strength, plasticity)).get())
            }
            Behaviour::Cdpm2(strength, biaxial, own) => {
                task.run(self.prepared.law(&|| self.cdpm2::<R>(strength, *biaxial, own)).get())
            }
            Behaviour::Meso(strength, own) => task.run(self.prepared.law(&|| self.meso::<R>(strength, own)).get()),
            Behaviour::Rated(strength, own, dt) => {
                task.run(self.prepared.law(&|| self.scaled::<R, 10>(strength, own, [*dt, 1.0])).get())
            }
            Behaviour::Scattered(strength, own, most) => {
                task.run(self.prepared.law(&|| self.scaled::<R, 9>(strength, own, [1.0, *most])).get())
            }
            Behaviour::RatedScattered(strength, own, factors) => {
                task.run(self.prepared.law(&|| self.scaled::<R, 11>(strength, own, *factors)).get())
            }
        }
    }

    fn cdp<R: Real>(&self, strength: &Strength, plasticity: &Plasticity) -> law::Cdp<R> {
        law::Cdp::new(&self.elastic, strength, plasticity)
    }

    fn cdpm2<R: Real>(&self, strength: &Strength, biaxial: f64, own: &Cdpm2Parameters) -> law::Cdpm2<R> {
        law::Cdpm2::new(&self.elastic, strength, biaxial, own)
    }

    fn meso<R: Real>(&self, strength: &Strength, own: &Mesoscale) -> law::Meso<R> {
        law::Meso::new(&self.elastic, strength, own)
    }

    fn scaled<R: Real, const N: usize>(
        &self,
        strength: &Strength,
        own: &Mesoscale,
        factors: [f64; 2],
    ) -> law::Scaled<R, N> {
        law::Scaled::new(&self.elastic, strength, own, factors)
    }

    /// Lets strengths grow with the rate of strain, in steps of `dt_s`; elastic phases stay.
    pub fn rate(&mut self, dt_s: f64) {
        match self.behaviour {
            Behaviour::Meso(strength, own) => self.behaviour = Behaviour::Rated(strength, own, dt_s),
            Behaviour::Scattered(strength, own, most) => {
                self.behaviour = Behaviour::RatedScattered(strength, own, [dt_s, most]);
            }
            _ => {}
        }
    }

    /// Lets strengths scatter by a factor of `most` at most, which each element has in its [register](Self::factor).
    pub fn scatter(&mut self, most: f64) {
        if let Behaviour::Meso(strength, own) = self.behaviour {
            self.behaviour = Behaviour::Scattered(strength, own, most);
        }
    }

    /// Whether strengths grow with the rate of strain, or scatter.
    pub fn is_scaled(&self) -> bool {
        matches!(self.behaviour, Behaviour::Rated(..) | Behaviour::Scattered(..) | Behaviour::RatedScattered(..))
    }

    /// Place of the factor of the strengths, less 1, among the registers that an element remembers.
    pub fn factor(&self) -> Option<usize> {
        let is_scattered = matches!(self.behaviour, Behaviour::Scattered(..) | Behaviour::RatedScattered(..));
        // Before the integrity.
        is_scattered.then(|| self.remembered() - 2)
    }

    /// Registers that an element remembers: the law's history and the integrity.
    pub fn remembered(&self) -> usize {
        fn with_integrity<W: Law<f64>>() -> usize {
            W::virgin().as_ref().len() + 1
        }
        match &self.behaviour {
            Behaviour::Elastic => 0,
            Behaviour::Cdp(..) => with_integrity::<law::Cdp<f64>>(),
            Behaviour::Cdpm2(..) => with_integrity::<law::Cdpm2<f64>>(),
            Behaviour::Meso(..) => with_integrity::<law::Meso<f64>>(),
            Behaviour::Rated(..) => with_integrity::<law::Rated<f64>>(),
            Behaviour::Scattered(..) => with_integrity::<law::Scattered<f64>>(),
            Behaviour::RatedScattered(..) => with_integrity::<law::RatedScattered<f64>>(),
        }
    }

    /// Widest bands of cracking and of crushing that dissipate their energy, mm.
    pub fn widest_mm(&self) -> [f64; 2] {
        match &self.behaviour {
            Behaviour::Elastic => [f64::INFINITY; 2],
            Behaviour::Cdp(strength, plasticity) => self.cdp::<f64>(strength, plasticity).widest_mm(),
            Behaviour::Cdpm2(strength, biaxial, own) => self.cdpm2::<f64>(strength, *biaxial, own).widest_mm(),
            Behaviour::Meso(strength, own) => self.meso::<f64>(strength, own).widest_mm(),
            Behaviour::Rated(strength, own, dt) => self.scaled::<f64, 10>(strength, own, [*dt, 1.0]).widest_mm(),
            Behaviour::Scattered(strength, own, most) => self.scaled::<f64, 9>(strength, own, [1.0, *most]).widest_mm(),
            Behaviour::RatedScattered(strength, own, factors) => {
                self.scaled::<f64, 11>(strength, own, *factors).widest_mm()
            }
        }
    }

    /// Tensile over compressive strength, where CDPM2 has too little tension.
    pub fn low_tension(&self) -> Option<f64> {
        let Behaviour::Cdpm2(strength, ..) = &self.behaviour else { return None };
        Some(strength.tensile_mpa / strength.compressive_mpa).filter(|ratio| *ratio < LOW_TENSION)
    }

    /// Stiffness of an hourglass mode, N/mm.
    pub fn hourglass_stiffness(&self, factor: f64, shape: &BoxShape) -> f64 {
        hourglass_stiffness(factor, self.elastic.youngs_modulus_mpa, shape.edge())
    }

    /// Lame's constants lambda and G, MPa.
    pub fn lame(&self) -> [f64; 2] {
        let (e, nu) = (self.elastic.youngs_modulus_mpa, self.elastic.poisson_ratio);
        let shear = e / (2.0 * (1.0 + nu));
        [2.0 * shear * nu / (1.0 - 2.0 * nu), shear]
    }
}
