//! Which coordinates full cells have along an axis.

use std::collections::BTreeMap;

/// For each coordinate, in how many bricks there is a full cell that has it.
///
/// By these, the ends of all cells are known though cells come and go. A brick counts, not a cell,
/// so that most edits do not touch this.
#[derive(Clone, Debug, Default)]
pub(super) struct Slabs(BTreeMap<i32, u64>);

impl Slabs {
    /// One more brick has cells there.
    pub fn add(&mut self, coordinate: i32) {
        *self.0.entry(coordinate).or_default() += 1;
    }

    /// One brick less has.
    pub fn remove(&mut self, coordinate: i32) {
        let count = self.0.get_mut(&coordinate);
        debug_assert!(count.is_some(), "no brick had cells at {coordinate}");
        if let Some(count) = count {
            *count -= 1;
            if *count == 0 {
                self.0.remove(&coordinate);
            }
        }
    }

    /// The least and the greatest.
    pub fn ends(&self) -> Option<[i32; 2]> {
        let (least, _) = self.0.first_key_value()?;
        let (greatest, _) = self.0.last_key_value()?;
        Some([*least, *greatest])
    }
}
