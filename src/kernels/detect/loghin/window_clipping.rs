//! Clipped lights among those of the steps of Loghin (2021).

use ndarray::{ArrayView2, ArrayView3};
use rayon::prelude::*;

use super::windows::Windows;
use crate::error::Result;
use crate::interrupt;
use crate::kernels::detect::clipping::{Ceiling, Top, largest};
use crate::kernels::image::check_rgb;
use crate::kernels::sphere::{Pixel, pixels_inside};

/// For each light, true if it is clipped: at `clip_level` if that is known, else at the map's largest sample.
///
/// The pixels of a light are those of the window around its one of `pixels`, (n, 2).
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
    clip_level: Option<f32>,
) -> Result<Vec<bool>> {
    check_rgb(radiance)?;
    let (height, width, _) = radiance.dim();
    let places = pixels_inside(pixels, (height, width))?;
    let samples = radiance.as_standard_layout();
    let map = samples.as_slice().map_or(&[][..], |samples| samples.as_chunks::<3>().0);
    let windows = Windows::new((height, width), reach, sphere);
    // Find the largest sample of each window.
    let tops: Vec<Top> =
        places.into_par_iter().map(|pixel| top_around(map, width, pixel, &windows)).collect();
    let at = |ceiling| -> Vec<bool> { tops.iter().map(|top| top.is_clipped(ceiling)).collect() };
    if let Some(clip_level) = clip_level {
        return Ok(at(Ceiling::White(clip_level)));
    }
    // Compare each with the largest of them. Lights that are not clipped at this level are not clipped at a higher one,
    // so the map is read only for the others.
    let clipped = at(Ceiling::Maximum(tops.iter().map(|top| top.sample).fold(0.0, f32::max)));
    if !clipped.contains(&true) {
        return Ok(clipped);
    }
    // Compare each with the largest sample of the map.
    Ok(at(Ceiling::Maximum(
        map.par_chunks(width).map(|row| largest(row.as_flattened())).reduce(|| 0.0, f32::max),
    )))
}

/// The top of the window around `pixel` in a `map` of this `width`.
fn top_around(map: &[[f32; 3]], width: usize, pixel: Pixel, windows: &Windows) -> Top {
    let mut top = Top::default();
    for row in windows.rows(pixel) {
        interrupt::check();
        for columns in windows.columns(row, pixel) {
            top = top.and(Top::of(&map[row * width..][columns]));
        }
    }
    top
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::{Array3, arr2};

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
        let clipped = |map: Array3<f32>| are_clipped(map.view(), pixels.view(), 2, false, None).unwrap();
        assert_eq!(clipped(squares()), [true, false, false]);
        let mut sunny = squares();
        sunny.slice_mut(ndarray::s![2, 30, ..]).fill(2.0);
        assert_eq!(clipped(sunny), [false; 3]);
    }
}
