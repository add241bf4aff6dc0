//! The local background of a light: the radiance just outside of it, glare included.
//!
//! Its luminance is the median of the pixels three rows or columns straight out from the outline, because the light's
//! edge often cuts the nearest ones. A median ignores an object on one side of the light. The colour is that of the
//! middle half of these pixels.

use ndarray::ArrayView3;

use super::adjacency::Adjacency;
use super::components::Segments;
use super::working_image::WorkingImage;
use crate::kernels::image::luminance;

/// Heights of a row from the outline to the pixels of the background.
const DISTANCE: usize = 3;
/// Largest ratio of the background to the light's peak.
const MOST_OF_THE_PEAK: f64 = 0.5;

/// The radiance around a light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LocalBackground {
    /// Median luminance.
    pub luminance: f64,
    /// Radiance of that luminance, RGB.
    pub radiance: [f64; 3],
}

/// The local background of each segment.
pub fn local_backgrounds(
    radiance: ArrayView3<'_, f32>,
    working: &WorkingImage,
    adjacency: &Adjacency,
    segments: &Segments,
    outline: &[u32],
) -> Vec<LocalBackground> {
    let width = working.size.1;
    // Find the number of columns of each row that are as wide as `DISTANCE` rows are high.
    let columns: Vec<usize> = (0..working.size.0).map(|row| working.columns_across(row, DISTANCE)).collect();
    let is_seen = |pixel| working.seen.as_ref().is_none_or(|seen| seen.is_background(pixel));
    // Collect the pixels straight out from each outline, where they are outside the segment and seen.
    let mut outside: Vec<Vec<u32>> = vec![Vec::new(); segments.pixels.len()];
    for index in outline.iter().map(|&index| index as usize) {
        let label = segments.label[index];
        let beyond = adjacency.beyond(index, DISTANCE, columns[index / width]);
        for (side, beyond) in adjacency.sides(index).into_iter().zip(beyond) {
            if segments.label[side] != label && segments.label[beyond] != label && is_seen(beyond) {
                outside[label as usize - 1].push(beyond as u32);
            }
        }
    }
    // Take the median of each segment, at most half of its peak.
    let most = segments.peaks.iter().map(|&peak| MOST_OF_THE_PEAK * f64::from(peak));
    outside.into_iter().zip(most).map(|(outside, most)| of_pixels(radiance, working, outside, most)).collect()
}

/// The background from some pixels of the working image, with a luminance of at most `most`.
fn of_pixels(
    radiance: ArrayView3<'_, f32>,
    working: &WorkingImage,
    mut pixels: Vec<u32>,
    most: f64,
) -> LocalBackground {
    if pixels.is_empty() {
        return LocalBackground::default();
    }
    // Find the median luminance.
    let level = |&pixel: &u32| working.luminance[pixel as usize];
    pixels.sort_unstable_by(|one, other| level(one).total_cmp(&level(other)));
    let median = f64::from(level(&pixels[pixels.len() / 2])).min(most);
    // Sum the colours in the middle of the pixels of the middle half.
    let (height, width, _) = radiance.dim();
    let middle = |index: usize, size: usize| (index * working.block + working.block / 2).min(size - 1);
    let mut sum = [0.0; 3];
    for &pixel in &pixels[pixels.len() / 4..pixels.len() - pixels.len() / 4] {
        let (row, column) = (pixel as usize / working.size.1, pixel as usize % working.size.1);
        let (row, column) = (middle(row, height), middle(column, width));
        (0..3).for_each(|c| sum[c] += f64::from(radiance[[row, column, c]]));
    }
    // Scale them to the median.
    let scale = median / luminance(sum);
    let radiance = if scale.is_finite() { sum.map(|value| scale * value) } else { [median; 3] };
    LocalBackground { luminance: median, radiance }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::outline::outline;
    use super::super::test_maps::{map_of, segments, working_image_of};
    use super::*;
    use crate::kernels::image::LUMINANCE;
    use crate::kernels::sphere::Registration;
    use approx::assert_relative_eq;
    use ndarray::Array3;

    /// Luminance of the local background of a lamp of 9, 5 x 5 pixels, where column x around it is `pixel(x)`.
    fn background_of(row: usize, column: usize, pixel: impl Fn(usize) -> char) -> f64 {
        let is_lamp = |y: usize, x: usize| y.abs_diff(row) <= 2 && (x + 32 - column + 2) % 32 <= 4;
        let rows: Vec<String> =
            (0..16).map(|y| (0..32).map(|x| if is_lamp(y, x) { '9' } else { pixel(x) }).collect()).collect();
        let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        let (map, working) = (map_of(&rows), working_image_of(&rows));
        let (adjacency, mut segments) = (Adjacency::of(&working), segments(&working, 0.7));
        assert_eq!(segments.pixels.len(), 1);
        segments.pixels[0].retain(|&pixel| segments.label[pixel as usize] != 0);
        assert_eq!(segments.pixels[0].len(), 25);
        let outline = outline(&adjacency, &segments);
        let background = local_backgrounds(map.view(), &working, &adjacency, &segments, &outline)[0];
        assert_relative_eq!(luminance(background.radiance), background.luminance, max_relative = 1e-9);
        background.luminance
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

    /// The darkest quarter is red, the brightest blue, and what is between them green.
    #[test]
    fn the_colour_is_that_of_the_middle_half() {
        let channel = |x: usize| [0, 1, 1, 2][x / 4];
        let sample = |(_, x, c)| if c == channel(x) { ((x + 1) as f64 / LUMINANCE[c]) as f32 } else { 0.0 };
        let map = Array3::from_shape_fn((8, 16, 3), sample);
        let working = WorkingImage::of(map.view(), Registration::CellCentred, 16).unwrap();
        let background = of_pixels(map.view(), &working, (64..80).collect(), f64::INFINITY);
        let expected = [0.0, 9.0 / LUMINANCE[1], 0.0];
        for (value, expected) in background.radiance.into_iter().zip(expected) {
            assert_relative_eq!(value, expected, max_relative = 1e-6);
        }
    }

    #[test]
    fn the_background_is_at_most_half_of_the_peak() {
        assert_relative_eq!(background_of(8, 10, |_| '4'), 4.0, max_relative = 1e-5);
        assert_relative_eq!(background_of(8, 10, |_| '5'), 4.5, max_relative = 1e-5);
    }
}
