//! The kernels' source for a run: `kernel.cl` with the run's laws and sizes.

use crate::law::{self, Law};
use crate::tables::{OwnLaw, Tables};
use meso_solve::device::{SPAN, Upload};
use std::fmt::Write;

const KERNEL: &str = include_str!("kernel.cl");
/// Most operations of a law that fits 80 registers: CDP has 485, `meso` 686 and CDPM2 810.
const SMALL: usize = 500;
/// Pairs of nodes of a cohesive face, and its nodes beside one.
const PAIRS: usize = 3;
const FACE: usize = 2 * PAIRS - 1;

/// Laws of a run.
#[derive(Default)]
pub(crate) struct Laws {
    laws: Vec<Law>,
    /// By material; cohesive faces come last.
    pub(crate) of_material: Vec<OwnLaw>,
    /// Number of the law of cohesive faces.
    of_faces: Option<usize>,
    /// Constants of all materials.
    pub(crate) params: Vec<f32>,
    /// Whether strengths grow or scatter.
    are_scaled: bool,
}

impl Laws {
    /// Traces the laws of all materials.
    pub(crate) fn of(upload: &Upload) -> Self {
        let mut all = Self { are_scaled: upload.are_scaled(), ..Self::default() };
        for material in 0..upload.materials() {
            let (law, params) = law::of_material(upload, material);
            all.add(law, params, 1);
        }
        all.of_faces = upload.cohesion().map(|values| {
            let (law, params) = law::of_faces(values);
            all.add(law, params, PAIRS)
        });
        all
    }

    /// Adds the law of elements that remember `times` the law's memory, and returns the law's number.
    fn add(&mut self, law: Law, params: Vec<f32>, times: usize) -> usize {
        let remembered = times * law.remembered;
        let number = self.laws.iter().position(|other| *other == law).unwrap_or_else(|| {
            self.laws.push(law);
            self.laws.len() - 1
        });
        assert!(number < 16, "an element has four bits for its law");
        self.of_material.push(OwnLaw { law: number as u32, params: self.params.len() as u32, remembered });
        self.params.extend(params);
        number
    }

    /// Groups of 128 threads on a multiprocessor: 6 have 80 registers a thread, which larger laws, expansion and cohesive faces
    /// would spill; 5 have 96, which `meso` with strengths that grow or scatter would spill; 4 have 128.
    fn resident(&self, expands: bool) -> usize {
        let is_large = expands || self.of_faces.is_some() || self.laws.iter().any(|law| law.operations() > SMALL);
        match (self.are_scaled, is_large) {
            (true, _) => 4,
            (false, true) => 5,
            (false, false) => 6,
        }
    }

    /// Source of the kernels for groups of `threads`.
    pub(crate) fn source(&self, tables: &Tables, threads: usize) -> String {
        let defines = [
            ("THREADS", threads),
            ("PLACES", tables.most_places),
            ("SLOTS", tables.most_slots),
            ("ENERGIES", tables.most_energies),
            ("SPAN", SPAN),
            ("SUPPORTS", tables.supports),
            ("LOADS", tables.has_loads.into()),
            ("DRIVEN", tables.is_driven.into()),
            ("TOUCHES", tables.most_touches),
            ("EXPANDS", tables.expands.into()),
            ("RESIDENT", self.resident(tables.expands)),
        ];
        let (mut head, mut answers) = (String::new(), String::new());
        defines.iter().for_each(|(name, value)| _ = writeln!(head, "#define {name} {value}"));
        let laws: String = self.laws.iter().enumerate().map(|(number, law)| law.code(number)).collect();
        for (number, law) in self.laws.iter().enumerate() {
            let (keeps, gets) =
                if law.remembered > 0 { ("lost = ", "memory + eight.y + lane") } else { ("", "memory") };
            let call = if self.of_faces == Some(number) {
                _ = writeln!(head, "#define FACE_LAW law_{number}");
                format!("face(params + eight.z, at, v, shift, near_u, {gets}, f + (eight.w >> 16) + lane); volume = 1")
            } else {
                format!("law_{number}(params + eight.z, e, width, {gets}, s)")
            };
            _ = writeln!(answers, "        case {number}: {keeps}{call}; break;");
        }
        let each = |call: &str| -> String {
            tables
                .kinds
                .iter()
                .filter(|&&others| others != FACE)
                .map(|n| format!("        case {n}: {}; break;\n", call.replace('N', &n.to_string())))
                .collect()
        };
        let body = KERNEL
            .replace("//LAWS\n", &laws)
            .replace("//STRAINS\n", &each("strain_of(N, at, g, v[16], shift, near_u, e)"))
            .replace("//ANSWERS\n", &answers)
            .replace("//FORCES\n", &each("resist(N, g, volume * v[16], s, f + (eight.w >> 16) + lane)"));
        head + &body
    }
}
