//! One instruction set after the other, while no other test chooses one: the choice holds for the whole process.

use meso_collision::simd::{Isa, choose};
use std::sync::{Mutex, PoisonError};

/// Calls `act` on every instruction set that the machine has, the widest last.
pub(crate) fn on_every_one(mut act: impl FnMut(Isa)) {
    static CHOOSING: Mutex<()> = Mutex::new(());
    let _alone = CHOOSING.lock().unwrap_or_else(PoisonError::into_inner);
    for isa in Isa::ALL {
        if choose(isa) == isa {
            act(isa);
        }
    }
}
