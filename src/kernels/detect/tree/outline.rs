//! Where the lights end: the pixels at the border of each.

use super::components::Regions;
use super::touch::Sheet;

/// Flat indices of the labelled pixels that have a side in common with another label or none.
pub fn outline(sheet: &Sheet, regions: &Regions) -> Vec<u32> {
    let is_border = |&&index: &&u32| {
        let label = regions.label[index as usize];
        label != 0 && sheet.sides(index as usize).into_iter().any(|side| regions.label[side] != label)
    };
    regions.pixels.iter().flat_map(|pixels| pixels.iter().filter(is_border)).copied().collect()
}
