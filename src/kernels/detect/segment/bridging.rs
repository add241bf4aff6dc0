//! Bridging: lights that are divided only by a narrow dark gap become one, as a window with bars.
//!
//! The distance between two directions is the chord between their points on the sphere,
//!
//! ```text
//!   chord^2 = (sin theta_1 - sin theta_2)^2 + (cos theta_1 - cos theta_2)^2
//!           + 4 sin theta_1 sin theta_2 sin^2((phi_1 - phi_2) / 2)
//! ```
//!
//! so a gap is the same angle at the equator, on the seam and around the poles, where many pixels of a row almost
//! coincide. The centres of the pixels on both sides of a bar are apart by its width plus one pixel.

use std::f64::consts::PI;

use super::adjacency::Adjacency;
use super::components::Segments;
use super::forest::{self, root};
use super::working_image::WorkingImage;
use crate::kernels::image::CellCentres;

/// Join the segments whose solid pixels are at most `gap` radians apart.
///
/// A pixel is solid if its luminance times `prominence` reaches its segment's peak. Two lights that are separated by
/// their prominence have no solid pixel where they meet. So segments are joined across a bar, however dim, but not
/// along the glow between two lamps.
pub fn bridge(
    working: &WorkingImage,
    adjacency: &Adjacency,
    segments: Segments,
    prominence: f64,
    gap: f64,
) -> Segments {
    if segments.pixels.len() < 2 || gap <= 0.0 {
        return segments;
    }
    // Define the label of a solid pixel; 0 for any other.
    let solid_label = |pixel: usize| match segments.label[pixel] {
        0 => 0,
        label if prominence as f32 * working.luminance[pixel] < segments.peaks[label as usize - 1] => 0,
        label => label,
    };
    let reach = Reach::new(working, gap + working.row_height());
    let mut parent = forest::singletons(segments.pixels.len());
    // Search from all segments but the largest: for a pair of segments, one search is enough.
    let size = |&segment: &usize| segments.pixels[segment].len();
    let largest = (0..segments.pixels.len()).max_by_key(size);
    let searching = (0..segments.pixels.len()).filter(|&segment| Some(segment) != largest);
    for pixel in searching.flat_map(|segment| &segments.pixels[segment]).map(|&pixel| pixel as usize) {
        let own = solid_label(pixel);
        if own == 0 || adjacency.sides(pixel).into_iter().all(|side| solid_label(side) == own) {
            continue; // not solid, or inside its segment
        }
        // Join the segment with all that have a solid pixel within reach.
        reach.for_each(pixel, |other| {
            let other = solid_label(other);
            if other != 0 && other != own {
                forest::join(&mut parent, own - 1, other - 1);
            }
        });
    }
    join(segments, &mut parent)
}

/// Join the segments of each tree of `parent`.
fn join(segments: Segments, parent: &mut [u32]) -> Segments {
    let mut number_of = vec![None; parent.len()];
    let mut wholes: Vec<(Vec<u32>, f32)> = Vec::new();
    for ((segment, pixels), peak) in (0..).zip(segments.pixels).zip(segments.peaks) {
        let number = *number_of[root(parent, segment) as usize].get_or_insert(wholes.len());
        if number == wholes.len() {
            wholes.push((pixels, peak));
        } else {
            wholes[number].0.extend(pixels);
            wholes[number].1 = wholes[number].1.max(peak);
        }
    }
    let mut joined = Segments::empty(segments.label);
    for (pixels, peak) in wholes {
        joined.push(pixels, peak);
    }
    joined
}

/// The pixels within an angle of another, centre to centre.
struct Reach {
    /// Square of the chord of the angle.
    chord_squared: f64,
    height: usize,
    width: usize,
    /// Rows to look at on either side.
    rows: usize,
    /// Sine and cosine of the polar angle of each row.
    theta: Vec<(f64, f64)>,
}

impl Reach {
    fn new(working: &WorkingImage, angle: f64) -> Self {
        let (height, width) = working.size;
        // Take one row more than fit, as the last row may be lower than the others.
        let rows = (angle / PI * height as f64) as usize + 1;
        // Stop at half a turn, and allow for rounding of the chord.
        let chord_squared = (2.0 * (0.5 * angle.min(PI)).sin()).powi(2) * (1.0 + 1e-12);
        Self { chord_squared, height, width, rows, theta: CellCentres::new(&working.grid).rows }
    }

    /// Call `visit` with the flat index of each pixel within the angle.
    fn for_each(&self, pixel: usize, mut visit: impl FnMut(usize)) {
        let (row, column) = (pixel / self.width, pixel % self.width);
        for other in row.saturating_sub(self.rows)..(row + self.rows + 1).min(self.height) {
            let Some(columns) = self.columns_within(row, other) else { continue };
            // Skip pixels around a pole, where they are narrow: visit one in each quarter of a row's height.
            let step = ((0.25 / self.theta[other].0) as usize).max(1);
            for offset in (0..=columns).step_by(step) {
                for column in [column + offset, column + self.width - offset] {
                    visit(other * self.width + column % self.width);
                }
            }
        }
    }

    /// Columns within the angle in row `other`, on either side of a pixel of `row`; `None` if the row is too far.
    fn columns_within(&self, row: usize, other: usize) -> Option<usize> {
        let ((sin, cos), (other_sin, other_cos)) = (self.theta[row], self.theta[other]);
        let along = (sin - other_sin).powi(2) + (cos - other_cos).powi(2);
        let left = self.chord_squared - along;
        let half_sine = || (left / (4.0 * sin * other_sin)).sqrt().min(1.0);
        (left >= 0.0).then(|| (half_sine().asin() / PI * self.width as f64) as usize)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::test_maps::{rows_from, segments, sizes, working_image_of};
    use super::super::working_image::WorkingImage;
    use super::*;
    use crate::kernels::sphere::{Registration, direction};
    use proptest::prelude::*;
    use std::f64::consts::TAU;

    /// Pixels of each light of a test map after gaps of `gap_px` pixel heights are bridged.
    fn sizes_after_bridging(working: &WorkingImage, gap_px: f64) -> Vec<usize> {
        let gap = gap_px * PI / working.size.0 as f64;
        sizes(&bridge(working, &Adjacency::of(working), segments(working, 0.0), 4.0, gap))
    }

    #[test]
    fn a_bar_of_one_pixel_joins_and_one_of_three_does_not() {
        assert_eq!(sizes_after_bridging(&rows_from(4, &["...99.99........"]), 1.2), [4]);
        assert_eq!(sizes_after_bridging(&rows_from(4, &["...99...99......"]), 1.2), [2, 2]);
        assert_eq!(
            sizes_after_bridging(
                &rows_from(2, &["....99..........", "................", "....99.........."]),
                1.2
            ),
            [4]
        );
    }

    #[test]
    fn a_bar_on_the_seam_joins() {
        assert_eq!(sizes_after_bridging(&rows_from(4, &["9..............9"]), 1.2), [2]);
        assert_eq!(sizes_after_bridging(&rows_from(4, &[".9.............9"]), 1.2), [2]);
        assert_eq!(sizes_after_bridging(&rows_from(4, &["9.............9."]), 1.2), [2]);
        assert_eq!(sizes_after_bridging(&rows_from(4, &[".9............9."]), 1.2), [1, 1]);
    }

    #[test]
    fn no_gap_no_bridge() {
        assert_eq!(sizes_after_bridging(&rows_from(4, &["...99.99........"]), 0.0), [2, 2]);
    }

    #[test]
    fn a_glow_between_two_lamps_is_no_bridge() {
        assert_eq!(sizes_after_bridging(&rows_from(4, &["...921298......."]), 1.2), [3, 3]);
        // A third of the peak is solid.
        assert_eq!(sizes_after_bridging(&rows_from(4, &["...93.39........"]), 1.2), [4]);
    }

    /// Pixels half a turn apart in row 1 are 3 heights apart over the pole; in row 7 of 16, almost a half circle.
    #[test]
    fn around_a_pole_a_gap_is_an_angle() {
        let row = "9...............9...............";
        let dark = ".".repeat(32);
        for (y, expected) in [(1, vec![2]), (14, vec![2]), (2, vec![1, 1]), (7, vec![1, 1])] {
            let mut rows = vec![dark.as_str(); 16];
            rows[y] = row;
            assert_eq!(sizes_after_bridging(&working_image_of(&rows), 2.2), expected, "row {y}");
        }
    }

    #[test]
    fn a_chain_of_panes_is_one_light_with_all_pixels_and_the_highest_peak() {
        let working = rows_from(4, &["..5.9.7.6......."]);
        let gap = 1.2 * PI / 8.0;
        let joined = bridge(&working, &Adjacency::of(&working), segments(&working, 0.0), 4.0, gap);
        assert_eq!(sizes(&joined), [4]);
        assert!((joined.peaks[0] - 9.0).abs() < 1e-5);
        for &pixel in &joined.pixels[0] {
            assert_eq!(joined.label[pixel as usize], 1);
        }
        assert_eq!(joined.label.iter().filter(|&&label| label != 0).count(), 4);
    }

    proptest! {
        /// All pixels within an angle and no others are visited, also if the last row is lower than the others.
        #[test]
        fn all_pixels_within_reach_are_visited(row in 0_usize..23, column in 0_usize..46, angle in 0.1..3.0) {
            let map = ndarray::Array3::zeros((45, 92, 3));
            let working = WorkingImage::of(map.view(), Registration::CellCentred, 46).unwrap();
            let pixel = row * 46 + column;
            let mut is_visited = vec![false; 23 * 46];
            Reach::new(&working, angle).for_each(pixel, |other| is_visited[other] = true);
            let edges = &working.grid.theta_edges;
            let towards = |pixel: usize| {
                let (row, column) = (pixel / 46, pixel % 46);
                direction(0.5 * (edges[row] + edges[row + 1]), TAU * (column as f64 + 0.5) / 46.0)
            };
            for (other, visited) in is_visited.into_iter().enumerate() {
                let apart = towards(pixel).angle_between(towards(other));
                prop_assert!(!visited || apart <= angle + 1e-7, "{pixel} {other} {apart}");
                // The rows at the poles are visited in steps.
                let is_polar = [0, 22].contains(&(other / 46));
                prop_assert!(visited || is_polar || apart >= angle - 1e-7, "{pixel} {other} {apart}");
            }
        }
    }
}
