//! The slots of points, as the low bits of a key.

use super::SLOTS;

/// 0, 1, 2, ...
#[repr(align(64))]
pub(super) struct Counting<T>(pub(super) [T; SLOTS]);
pub(super) static SLOTS_32: Counting<u32> = Counting(counting_32());
pub(super) static SLOTS_64: Counting<u64> = Counting(counting_64());

const fn counting_32() -> [u32; SLOTS] {
    let mut slots = [0; SLOTS];
    let mut slot = 0;
    while slot < SLOTS {
        slots[slot] = slot as u32;
        slot += 1;
    }
    slots
}

const fn counting_64() -> [u64; SLOTS] {
    let mut slots = [0; SLOTS];
    let mut slot = 0;
    while slot < SLOTS {
        slots[slot] = slot as u64;
        slot += 1;
    }
    slots
}
