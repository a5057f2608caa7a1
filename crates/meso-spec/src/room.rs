//! Room that a packing leaves for a mesh, and the specimen of a first test.

use super::Spec;
use meso_concrete::Room;

/// Share of the strategy's reach up to which gaps cost little time. At 50 % of the paper's specimen gaps of 0.5 mm take
/// 3 CPU s and gaps of 0.75 mm 34 CPU s; 1 mm is not reached.
const EASY: f64 = 0.9;

impl Spec {
    /// The paper's specimen (Sec. 3.1) for a first test: 40 % of aggregates, with gaps that elements of 4 mm resolve better
    /// than none.
    pub fn of_first_test() -> Self {
        let mut spec = Self { fraction: 0.4, ..Self::default() };
        spec.placement.min_gap_mm = 1.0;
        spec
    }

    /// Sets gaps that are 0 to those of `room`; returns the new gap, mm, `None` if nothing changes.
    ///
    /// Gaps [between](Room::Between) aggregates are halved up to three times until the packing is easy.
    pub fn leave_room(&mut self, room: Room) -> Option<f64> {
        let placement = &mut self.placement;
        match room {
            Room::Everywhere(gap) => {
                let unset =
                    [&mut placement.min_gap_mm, &mut placement.wall_gap_mm].into_iter().filter(|gap| **gap == 0.0);
                (unset.map(|unset| *unset = gap).count() > 0).then_some(gap)
            }
            Room::Between(_) if placement.min_gap_mm > 0.0 => None,
            Room::Between(most) => {
                let gap = self.widest_gap(most)?;
                self.placement.min_gap_mm = gap;
                Some(gap)
            }
        }
    }

    fn widest_gap(&self, most: f64) -> Option<f64> {
        [1.0, 0.5, 0.25, 0.125].into_iter().map(|share| share * most).find(|gap| {
            let mut with_gap = self.clone();
            with_gap.placement.min_gap_mm = *gap;
            with_gap.crowding() <= EASY * with_gap.reach()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_between_aggregates_shrink_in_dense_packings() {
        let left = |fraction| Spec { fraction, ..Spec::default() }.leave_room(Room::Between(1.0));
        assert_eq!(left(0.3), Some(1.0));
        assert!(left(0.5).is_some_and(|gap| gap < 1.0));
        assert_eq!(left(0.75), None);
    }

    #[test]
    fn gaps_that_the_spec_sets_stay() {
        let mut spec = Spec::of_first_test();
        assert_eq!(spec.leave_room(Room::Between(4.0)), None);
        assert_eq!(spec.leave_room(Room::Everywhere(0.05)), Some(0.05));
        assert_eq!((spec.placement.min_gap_mm, spec.placement.wall_gap_mm), (1.0, 0.05));
    }
}
