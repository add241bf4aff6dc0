//! The local background of a light: the luminance just outside of it, glare included.
//!
//! It is the median of the pixels three rows or columns straight out from the outline: the nearest ones
//! are often cut by the light's edge. A median ignores what stands on one side of the light alone.

use super::adjacency::Adjacency;
use super::components::Segments;
use super::working_image::WorkingImage;

/// Heights of a row from the outline to the pixels of the background.
const DISTANCE: usize = 3;
/// The background is at most this share of the light's peak.
const MOST_OF_THE_PEAK: f64 = 0.5;

/// The luminance of the local background of each segment.
pub fn local_backgrounds(
    working: &WorkingImage,
    adjacency: &Adjacency,
    segments: &Segments,
    outline: &[u32],
) -> Vec<f64> {
    let luminance = &working.luminance;
    let width = working.size.1;
    // Find how many columns of each row are as wide as `DISTANCE` rows are high.
    let columns: Vec<usize> = (0..working.size.0).map(|row| working.columns_across(row, DISTANCE)).collect();
    // Collect the pixels straight out from each outline, where they are outside the segment.
    let mut outside: Vec<Vec<f32>> = vec![Vec::new(); segments.pixels.len()];
    for index in outline.iter().map(|&index| index as usize) {
        let label = segments.label[index];
        let beyond = adjacency.beyond(index, DISTANCE, columns[index / width]);
        for (side, beyond) in adjacency.sides(index).into_iter().zip(beyond) {
            if segments.label[side] != label && segments.label[beyond] != label {
                outside[label as usize - 1].push(luminance[beyond]);
            }
        }
    }
    // Take the median of each segment, at most half of its peak.
    let most = segments.peaks.iter().map(|&peak| MOST_OF_THE_PEAK * f64::from(peak));
    outside.iter_mut().zip(most).map(|(outside, most)| median(outside).min(most)).collect()
}

/// The middle one of some values, in another order then; 0 without any.
pub fn median(values: &mut [f32]) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { f64::from(*values.select_nth_unstable_by(middle, f32::total_cmp).1) }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::outline::outline;
    use super::super::test_maps::{drawn, segments};
    use super::*;
    use approx::assert_relative_eq;

    /// Local background of a lamp of 9, 5 x 5 pixels, where column x around it is `pixel(x)`.
    fn background_of(row: usize, column: usize, pixel: impl Fn(usize) -> char) -> f64 {
        let is_lamp = |y: usize, x: usize| y.abs_diff(row) <= 2 && (x + 32 - column + 2) % 32 <= 4;
        let rows: Vec<String> =
            (0..16).map(|y| (0..32).map(|x| if is_lamp(y, x) { '9' } else { pixel(x) }).collect()).collect();
        let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        let working = drawn(&rows);
        let (adjacency, mut segments) = (Adjacency::of(&working), segments(&working, 0.7));
        assert_eq!(segments.pixels.len(), 1);
        segments.pixels[0].retain(|&pixel| segments.label[pixel as usize] != 0);
        assert_eq!(segments.pixels[0].len(), 25);
        local_backgrounds(&working, &adjacency, &segments, &outline(&adjacency, &segments))[0]
    }

    #[test]
    fn the_background_is_the_luminance_around_the_light_also_on_the_seam() {
        for column in [10, 0, 31] {
            assert_relative_eq!(background_of(8, column, |_| '.'), 0.1, max_relative = 1e-5);
            assert_relative_eq!(background_of(8, column, |_| '3'), 3.0, max_relative = 1e-5);
        }
    }

    #[test]
    fn a_wall_on_one_side_does_not_matter() {
        assert_relative_eq!(
            background_of(8, 10, |x| if x > 12 { '4' } else { '1' }),
            1.0,
            max_relative = 1e-5
        );
    }

    #[test]
    fn the_background_is_at_most_half_of_the_peak() {
        assert_relative_eq!(background_of(8, 10, |_| '4'), 4.0, max_relative = 1e-5);
        assert_relative_eq!(background_of(8, 10, |_| '5'), 4.5, max_relative = 1e-5);
    }
}
