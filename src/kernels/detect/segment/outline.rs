//! The outline of each light, and the trim of pixels far outside of it.

use rayon::prelude::*;

use super::adjacency::Adjacency;
use super::components::Segments;

/// Trim the glow from each segment; its labelled pixels remain, and their neighbours, which the light's edge may cut.
pub fn trim(adjacency: &Adjacency, mut segments: Segments) -> Segments {
    let label = &segments.label;
    segments.pixels.par_iter_mut().enumerate().for_each(|(segment, pixels)| {
        let own = segment as u32 + 1;
        pixels.retain(|&index| {
            let index = index as usize;
            label[index] == own || adjacency.around(index).into_iter().any(|other| label[other] == own)
        });
    });
    segments
}

/// Flat indices of the labelled pixels beside a pixel of another label or of none.
pub fn outline(adjacency: &Adjacency, segments: &Segments) -> Vec<u32> {
    let is_border = |&&index: &&u32| {
        let label = segments.label[index as usize];
        label != 0 && adjacency.sides(index as usize).into_iter().any(|side| segments.label[side] != label)
    };
    segments.pixels.iter().flat_map(|pixels| pixels.iter().filter(is_border)).copied().collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::test_maps::{rows_from, segments};
    use super::*;

    fn length(top: usize, rows: &[&str]) -> usize {
        let working = rows_from(top, rows);
        outline(&Adjacency::of(&working), &segments(&working, 0.0)).len()
    }

    #[test]
    fn inner_pixels_are_not_on_the_outline() {
        assert_eq!(length(2, &["...9999.........", "...9999.........", "...9999........."]), 10);
        assert_eq!(length(2, &["99............99", "99............99", "99............99"]), 10);
        assert_eq!(length(4, &[".......9........"]), 1);
    }

    /// A light does not end at a pole row.
    #[test]
    fn a_cap_has_one_ring_of_outline() {
        assert_eq!(length(0, &["9999999999999999", "9999999999999999"]), 16);
        assert_eq!(length(6, &["9999999999999999", "9999999999999999"]), 16);
    }
}
