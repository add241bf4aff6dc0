//! The outline of each light, and the trim of pixels far outside of it.

use rayon::prelude::*;

use super::adjacency::Adjacency;
use super::components::Segments;
use crate::kernels::image::SeenPart;

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

/// For each segment, true if it touches the border of the seen part of the map.
pub fn are_cut(seen: &SeenPart, adjacency: &Adjacency, segments: &Segments, outline: &[u32]) -> Vec<bool> {
    let mut are_cut = vec![false; segments.pixels.len()];
    for index in outline.iter().map(|&index| index as usize) {
        let is_inside = || adjacency.around(index).into_iter().all(|other| seen.is_whole(other));
        if !seen.is_whole(index) || !is_inside() {
            are_cut[segments.label[index] as usize - 1] = true;
        }
    }
    are_cut
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::test_maps::{rows_from, segments};
    use super::*;
    use crate::kernels::sphere::Registration;
    use ndarray::Array2;

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

    #[test]
    fn a_light_is_cut_if_an_unseen_pixel_lies_beside_it() {
        let working = rows_from(3, &["....9......9....", "................", "8..............7"]);
        let (adjacency, segments) = (Adjacency::of(&working), segments(&working, 0.1));
        let outline = outline(&adjacency, &segments);
        let cut = |unseen: (usize, usize), share: f32| {
            let mut seen = Array2::ones((8, 16));
            seen[unseen] = share;
            let part = SeenPart::of(seen.view(), Registration::CellCentred, 1);
            let cut = are_cut(&part, &adjacency, &segments, &outline);
            let columns = segments.pixels.iter().zip(cut).filter(|(_, cut)| *cut);
            columns.map(|(pixels, _)| pixels[0] as usize % 16).collect::<Vec<_>>()
        };
        assert_eq!(cut((4, 5), 0.0), [4]); // diagonal
        assert_eq!(cut((3, 11), 0.5), [11]); // in the light itself
        assert_eq!(cut((5, 1), 0.0), [0]); // of a light across the seam
        assert_eq!(cut((3, 11), 254.5 / 255.0), [0; 0]);
        assert_eq!(cut((3, 8), 0.0), [0; 0]);
    }
}
