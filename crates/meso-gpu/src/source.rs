//! The kernels' source for a run: `kernel.cl` with the run's laws and sizes.

use crate::law::{self, Law};
use crate::tables::{PhaseLaw, Tables};
use meso_solve::device::{SPAN, Upload};
use std::fmt::Write;

const KERNEL: &str = include_str!("kernel.cl");

/// Laws of a run.
pub(crate) struct Laws {
    laws: Vec<Law>,
    /// By phase.
    pub(crate) of_phase: [PhaseLaw; 5],
    /// Constants of all phases.
    pub(crate) params: Vec<f32>,
}

impl Laws {
    /// Traces the laws of all phases.
    pub(crate) fn of(upload: &Upload) -> Self {
        let mut all = Self { laws: Vec::new(), of_phase: Default::default(), params: Vec::new() };
        for phase in 0..all.of_phase.len() {
            let (law, params) = law::of_phase(upload, phase);
            let remembered = law.remembered;
            let number = all.laws.iter().position(|other| *other == law).unwrap_or_else(|| {
                all.laws.push(law);
                all.laws.len() - 1
            });
            all.of_phase[phase] = PhaseLaw { law: number as u32, params: all.params.len() as u32, remembered };
            all.params.extend(params);
        }
        all
    }

    /// Groups of 128 threads on a multiprocessor: 6 have 80 registers a thread, which CDPM2 with its 16 registers of memory
    /// would spill.
    fn resident(&self) -> usize {
        if self.laws.iter().any(|law| law.remembered > 9) { 5 } else { 6 }
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
            ("RESIDENT", self.resident()),
        ];
        let (mut head, mut answers) = (String::new(), String::new());
        defines.iter().for_each(|(name, value)| _ = writeln!(head, "#define {name} {value}"));
        let laws: String = self.laws.iter().enumerate().map(|(number, law)| law.code(number)).collect();
        for (number, law) in self.laws.iter().enumerate() {
            let (keeps, gets) =
                if law.remembered > 0 { ("lost = ", "memory + eight.y + lane") } else { ("", "memory") };
            _ = writeln!(
                answers,
                "        case {number}: {keeps}law_{number}(params + eight.z, e, width, {gets}, s); break;"
            );
        }
        let each = |call: &str| -> String {
            tables
                .kinds
                .iter()
                .map(|n| format!("        case {n}: {}; break;\n", call.replace('N', &n.to_string())))
                .collect()
        };
        let body = KERNEL
            .replace("//LAWS\n", &laws)
            .replace("//STRAINS\n", &each("strain_of(N, at, g, shift, near_u, e)"))
            .replace("//ANSWERS\n", &answers)
            .replace("//FORCES\n", &each("resist(N, g, volume, s, f + (eight.w >> 16) + lane)"));
        head + &body
    }
}
