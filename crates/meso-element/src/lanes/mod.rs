//! Eight elements at a time: registers of f32, chosen at run time, the same bits on every instruction set.
//!
//! The width is eight everywhere, so that forces are summed in one order. AVX-512 would bring 32 registers alone, which
//! gain nothing. Other machines take the portable lanes, which compilers turn into NEON on arm64.
//!
//! All functions are inlined into one that was compiled for the instruction set; a call left standing would be correct
//! and slow.

mod portable;
#[cfg(target_arch = "x86_64")]
mod x86;

use crate::real::Real;
use meso_collision::simd::Isa;
use portable::Portable;

/// Elements side by side.
pub const LANES: usize = 8;

/// Eight numbers in memory, aligned for one load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Octet(pub [f32; LANES]);

impl Octet {
    /// Their sum, in f64 and in their order.
    pub fn sum(&self) -> f64 {
        self.0.iter().map(|&x| f64::from(x)).sum()
    }
}

/// Eight small numbers in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(16))]
pub struct Short(pub [i16; LANES]);

/// Vectors of a block's nodes; the fourth number is padding and may have any value. As many as [`Places`] can name: no index
/// needs a check.
pub type Vectors = [[f32; 4]; MOST_NODES];

/// Most nodes of a block.
pub const MOST_NODES: usize = 1 << 15;

/// Eight nodes of a block. Their numbers are kept twofold: a vector is two words of eight bytes, the longest that an address
/// of x86 counts by itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Places([u16; LANES]);

impl Places {
    /// Sets the number of a `lane`'s node, which must be below [`MOST_NODES`].
    pub fn set(&mut self, lane: usize, node: u16) {
        assert!(usize::from(node) < MOST_NODES, "a block has at most {MOST_NODES} nodes");
        self.0[lane] = 2 * node;
    }

    /// The nodes' numbers.
    pub fn nodes(&self) -> [u16; LANES] {
        self.0.map(|twofold| twofold / 2)
    }
}

/// Zeros; pages that no block reaches never become resident.
pub fn vectors() -> Box<Vectors> {
    let zeros = vec![[0.0f32; 4]; MOST_NODES].into_boxed_slice();
    zeros.try_into().expect("a vector of that length")
}

/// A register of eight f32.
pub trait Lanes: Real + 'static {
    /// Whether these lanes serve machines without wide registers alone, where code is small before it is fast.
    const IS_FALLBACK: bool;

    /// From memory.
    fn load(from: &Octet) -> Self;
    /// From memory, exactly.
    fn load_short(from: &Short) -> Self;
    /// To memory.
    fn store(self, to: &mut Octet);
    /// A vector relative to the first three numbers of an `origin`, whose fourth one is zero.
    fn relative(vector: &[f64; 3], origin: &[f64; 4]) -> [f32; 4];
    /// x, y and z of eight nodes.
    fn gather(nodes: &Vectors, at: &Places) -> [Self; 3];
    /// Adds x, y and z to eight nodes, one after the other.
    fn scatter(nodes: &mut Vectors, at: &Places, vector: [Self; 3]);

    /// To memory, as a value.
    #[inline(always)]
    fn eight(self) -> Octet {
        let mut eight = Octet::default();
        self.store(&mut eight);
        eight
    }
}

/// Work on lanes. Give `run` and all that it calls `#[inline(always)]`.
pub trait Task {
    /// The answer.
    type Output;
    /// Does the work with registers `L`.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// An instruction set that the engine has code for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstructionSet {
    /// Instructions of every machine; NEON on arm64.
    Portable,
    /// AVX2 and FMA.
    Avx2,
}

impl InstructionSet {
    /// Instruction sets of this machine, slowest first.
    pub fn available() -> Vec<Self> {
        let all = [(Self::Portable, Isa::Scalar), (Self::Avx2, Isa::Avx2)];
        let best = Isa::best();
        all.into_iter().filter(|(_, isa)| *isa <= best).map(|(set, _)| set).collect()
    }

    /// The fastest one of this machine.
    pub fn best() -> Self {
        *Self::available().last().expect("portable is always there")
    }

    /// This one where the machine has it, else the best.
    pub fn or_best(self) -> Self {
        if Self::available().contains(&self) { self } else { Self::best() }
    }

    /// Runs `task`, compiled for this set, which must come from [`available`](Self::available).
    #[inline]
    pub fn run<T: Task>(self, task: T) -> T::Output {
        match self {
            Self::Portable => task.run::<Portable>(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => x86::on_avx2(task),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 => task.run::<Portable>(),
        }
    }
}
