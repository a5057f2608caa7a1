//! The instruction set that is measured.

use meso_collision::simd::{Isa, choose, isa};

/// Uses the instructions of `--isa scalar|avx2|avx512`, else the widest there are.
pub fn choose_isa() -> Isa {
    let args: Vec<String> = std::env::args().collect();
    let Some(at) = args.iter().position(|arg| arg == "--isa") else { return isa() };
    let name = args.get(at + 1).map_or("", String::as_str);
    let asked = Isa::ALL.into_iter().find(|isa| isa.name() == name);
    let asked = asked.unwrap_or_else(|| panic!("--isa is {name:?}; accepted are scalar, avx2 and avx512"));
    assert_eq!(choose(asked), asked, "this machine lacks {name}");
    asked
}
