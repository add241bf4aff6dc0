//! Lights that a camera has clipped, among those that the steps of Loghin (2021) find.

use ndarray::{ArrayView2, ArrayView3};
use rayon::prelude::*;

use super::image::{Pixel, pixels_inside};
use super::windows::Windows;
use crate::error::Result;
use crate::interrupt;
use crate::kernels::detect::clipping::{TOP, is_clipped};
use crate::kernels::image::{check_rgb, luminance_f32};

/// Whether each light is clipped, at the maximum of the map. Its pixels are those of the window around each of
/// `pixels`, (n, 2), one for each light: the steps see the map through such windows.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::WrongColumns`],
/// [`crate::error::Error::OutsideImage`].
pub fn are_clipped(
    radiance: ArrayView3<'_, f32>,
    pixels: ArrayView2<'_, i64>,
    reach: usize,
    sphere: bool,
) -> Result<Vec<bool>> {
    check_rgb(radiance)?;
    let (height, width, _) = radiance.dim();
    let places = pixels_inside(pixels, (height, width))?;
    let samples = radiance.as_standard_layout();
    let samples = samples.as_slice().unwrap_or(&[]); // the standard layout is a slice
    let map = samples.as_chunks::<3>().0;
    let windows = Windows::new((height, width), reach, sphere);
    // Find the peak of each window and count the pixels at it.
    let tops: Vec<(f64, usize)> =
        places.into_par_iter().map(|pixel| top_around(map, width, pixel, &windows)).collect();
    // Compare each with the brightest of them. What is not clipped beside them is not beside a brighter pixel,
    // so the map is read only for the others.
    let beside = |brightest: f64| -> Vec<bool> {
        tops.iter().map(|&(peak, pixels)| is_clipped(peak, pixels, brightest)).collect()
    };
    let brightest = tops.iter().map(|&(peak, _)| peak).fold(0.0, f64::max);
    let clipped = beside(brightest);
    let peaks = tops.iter().zip(&clipped).filter(|(_, clipped)| **clipped).map(|((peak, _), _)| *peak);
    let Some(dimmest) = peaks.reduce(f64::min) else { return Ok(clipped) };
    // Compare each with the brightest pixel of the map, where one is too bright for the dimmest of them.
    let level = dimmest / TOP;
    let rows = samples.par_chunks(3 * width).map(|row| maximum_above(level, row));
    Ok(beside(brightest.max(f64::from(rows.reduce(|| 0.0, f32::max)))))
}

/// Luminance of the brightest pixel of some `samples` if it is above `level`; else that or less.
///
/// A luminance is at most the largest sample of its pixel, up to rounding. That takes half the
/// time to find, so the luminance is computed only where it may be above.
fn maximum_above(level: f64, samples: &[f32]) -> f32 {
    /// Samples that are looked at together: 64 pixels.
    const AT_ONCE: usize = 3 * 64;
    /// More than what rounding adds to a luminance.
    const ROUNDING: f64 = 1e-6;
    let may_be_above = |samples: &&[f32]| f64::from(largest(samples)) > (1.0 - ROUNDING) * level;
    let luminances =
        |samples: &[f32]| samples.as_chunks::<3>().0.iter().copied().map(luminance_f32).fold(0.0, f32::max);
    samples.chunks(AT_ONCE).filter(may_be_above).map(luminances).fold(0.0, f32::max)
}

/// The largest of some values, in lanes that do not wait for one another.
fn largest(values: &[f32]) -> f32 {
    let (most, rest) = values.as_chunks::<16>();
    let mut lanes = [0.0_f32; 16];
    for values in most {
        for (lane, &value) in lanes.iter_mut().zip(values) {
            *lane = if value > *lane { value } else { *lane };
        }
    }
    lanes.iter().chain(rest).copied().fold(0.0, f32::max)
}

/// The peak of the window around `pixel` in a `map` of this `width`, and the number of pixels at it.
fn top_around(map: &[[f32; 3]], width: usize, pixel: Pixel, windows: &Windows) -> (f64, usize) {
    let mut values = Vec::new();
    for row in windows.rows(pixel) {
        interrupt::check();
        for columns in windows.columns(row, pixel) {
            values.extend(map[row * width..][columns].iter().copied().map(luminance_f32));
        }
    }
    let peak = f64::from(values.iter().copied().fold(0.0, f32::max));
    (peak, values.iter().filter(|&&value| f64::from(value) >= TOP * peak).count())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::{Array3, arr2};
    use proptest::collection::vec;
    use proptest::prelude::*;

    use super::*;

    /// A square of 4 pixels at 1, one of 3 at 1, and one of 4 at 0.9.
    fn squares() -> Array3<f32> {
        let mut map = Array3::from_elem((16, 32, 3), 0.1_f32);
        let pixels =
            |x: usize, count: usize| [(7, x), (7, x + 1), (8, x), (8, x + 1)].into_iter().take(count);
        for (value, places) in [(1.0, pixels(4, 4)), (1.0, pixels(14, 3)), (0.9, pixels(24, 4))] {
            for (row, column) in places {
                map.slice_mut(ndarray::s![row, column, ..]).fill(value);
            }
        }
        map
    }

    #[test]
    fn a_light_is_clipped_where_four_pixels_reach_the_maximum() {
        let pixels = arr2(&[[7, 4], [7, 14], [7, 24]]);
        let clipped = |map: Array3<f32>| are_clipped(map.view(), pixels.view(), 2, false).unwrap();
        assert_eq!(clipped(squares()), [true, false, false]);
        // A brighter pixel elsewhere counts by its luminance, wherever in the row it stands.
        let with_sun = |column: usize, rgb: [f32; 3]| {
            let mut map = squares();
            map.slice_mut(ndarray::s![2, column, ..]).assign(&ndarray::arr1(&rgb));
            clipped(map)
        };
        for column in [0, 20, 31] {
            assert_eq!(with_sun(column, [2.0; 3]), [false; 3]);
            assert_eq!(with_sun(column, [1.02 / TOP as f32; 3]), [false; 3]);
            assert_eq!(with_sun(column, [0.99 / TOP as f32; 3]), [true, false, false]);
            assert_eq!(with_sun(column, [0.0, 0.0, 9.0]), [true, false, false]);
        }
    }

    proptest! {
        #[test]
        fn the_maximum_above_a_level_is_the_maximum(
            samples in vec(0.0..1.0_f32, 0..400).prop_map(|mut all| { all.truncate(all.len() / 3 * 3); all }),
            level in 0.0..1.1_f64,
        ) {
            let luminances = samples.as_chunks::<3>().0.iter().copied().map(luminance_f32);
            let wanted = luminances.fold(0.0, f32::max);
            let found = maximum_above(level, &samples);
            prop_assert!(found <= wanted && (found >= wanted || f64::from(wanted) <= level), "{found} {wanted}");
        }
    }
}
