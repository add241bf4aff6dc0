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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::drawn::{drawn_from, regions};
    use super::*;

    fn length(top: usize, rows: &[&str]) -> usize {
        let summary = drawn_from(top, rows);
        outline(&Sheet::of(&summary), &regions(&summary, 0.0)).len()
    }

    #[test]
    fn the_inner_pixels_are_no_outline() {
        assert_eq!(length(2, &["...9999.........", "...9999.........", "...9999........."]), 10);
        assert_eq!(length(2, &["99............99", "99............99", "99............99"]), 10);
        assert_eq!(length(4, &[".......9........"]), 1);
    }

    /// Beyond a pole row there is nothing that a light could end at.
    #[test]
    fn a_cap_has_one_ring_of_outline() {
        assert_eq!(length(0, &["9999999999999999", "9999999999999999"]), 16);
        assert_eq!(length(6, &["9999999999999999", "9999999999999999"]), 16);
    }
}
