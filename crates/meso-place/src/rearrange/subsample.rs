//! Subsampling: fewer grains of the same grading.

use meso_concrete::aggregate::Grain;

/// The numbers of those `moving` that stay when every class gives up this `share` of its volume: the first ones
/// taken, which are those that a lower target takes.
pub(super) fn thinned(grains: &[Grain], moving: &[u32], share: f64) -> Vec<u32> {
    let grain = |number: u32| &grains[number as usize];
    let mut taken = moving.to_vec();
    taken.sort_unstable_by_key(|&number| (grain(number).class, grain(number).index));
    let mut kept = Vec::with_capacity(taken.len());
    for class in taken.chunk_by(|&p, &q| grain(p).class == grain(q).class) {
        let target = (1.0 - share) * class.iter().map(|&number| grain(number).volume()).sum::<f64>();
        let mut volume = 0.0;
        kept.extend(class.iter().take_while(|&&number| {
            let goes_in = volume + grain(number).volume() / 2.0 < target;
            volume += grain(number).volume();
            goes_in
        }));
    }
    kept.sort_unstable();
    kept
}
