//! Where the lights end: the pixels at the border of each, and no pixels far outside.

use rayon::prelude::*;

use super::components::Regions;
use super::touch::Sheet;

/// The regions without their glow: labelled pixels, and those that touch one. The edge of a light may
/// cut those; what lies farther out is none of it.
pub fn trim(sheet: &Sheet, mut regions: Regions) -> Regions {
    let label = &regions.label;
    regions.pixels.par_iter_mut().enumerate().for_each(|(region, pixels)| {
        let own = region as u32 + 1;
        pixels.retain(|&index| {
            let index = index as usize;
            label[index] == own || sheet.around(index).into_iter().any(|other| label[other] == own)
        });
    });
    regions
}

/// Flat indices of the labelled pixels that have a side in common with another label or none.
pub fn outline(sheet: &Sheet, regions: &Regions) -> Vec<u32> {
    let is_border = |&&index: &&u32| {
        let label = regions.label[index as usize];
        label != 0 && sheet.sides(index as usize).into_iter().any(|side| regions.label[side] != label)
    };
    regions.pixels.iter().flat_map(|pixels| pixels.iter().filter(is_border)).copied().collect()
}
