//! The clipped fraction of a map's sphere and of its flux.

use ndarray::ArrayView3;
use rayon::prelude::*;

use crate::error::Result;
use crate::kernels::detect::clipping::{Ceiling, Top};
use crate::kernels::image::{Grid, LEAST_WHITE, check_rgb, luminance_f32, samples_of};
use crate::kernels::sphere::{Registration, band_heights};

/// A largest sample on more than this fraction of the sphere is not a flat top.
const MOSTLY_EVEN: f64 = 0.5;

/// The part of a map that is clipped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClippedShare {
    /// Fraction of the sphere with a clipped sample.
    pub sphere: f64,
    /// Fraction of the luminance flux in those pixels.
    pub flux: f64,
}

/// The clipped part of an equirectangular map, (height, width, 3).
///
/// A map is clipped at `white` if that is known, else at a flat top of its largest sample.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`] when the array is not (height, width, 3) or smaller than 2 x 2.
pub fn clipped_fraction(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    white: Option<f32>,
) -> Result<ClippedShare> {
    check_rgb(radiance)?;
    let none = ClippedShare { sphere: 0.0, flux: 0.0 };
    let Some(least) = least_clipped(radiance, white) else { return Ok(none) };
    let [clipped, clipped_flux, flux] = clipped_and_all(radiance, registration, least);
    let sphere = clipped / (4.0 * std::f64::consts::PI);
    // A map that is even on most of the sphere has no top.
    if white.is_none() && sphere > MOSTLY_EVEN {
        return Ok(none);
    }
    Ok(ClippedShare { sphere, flux: if flux > 0.0 { clipped_flux / flux } else { 0.0 } })
}

/// Least sample that is clipped; `None` if the map has no flat top.
fn least_clipped(radiance: ArrayView3<'_, f32>, white: Option<f32>) -> Option<f32> {
    if let Some(white) = white {
        return Some((LEAST_WHITE * f64::from(white)) as f32);
    }
    let top_of_row = |row| Top::of(samples_of(radiance, row..row + 1).as_chunks::<3>().0);
    let rows = (0..radiance.dim().0).into_par_iter();
    let top = rows.map(top_of_row).reduce(Top::default, Top::and);
    (top.is_clipped(Ceiling::Maximum(top.sample)) && top.sample > 0.0).then_some(top.sample)
}

/// Solid angle and flux of the pixels with a sample of at least `least`, and the flux of all pixels.
fn clipped_and_all(radiance: ArrayView3<'_, f32>, registration: Registration, least: f32) -> [f64; 3] {
    let (height, width, _) = radiance.dim();
    let grid = Grid::of_pixels(height, width, registration);
    let (bands, widths) = (band_heights(&grid.theta_edges), grid.widths());
    let sums_of_row = |row: usize| {
        let samples = samples_of(radiance, row..row + 1);
        let mut sums = [0.0; 3];
        for (&pixel, width) in samples.as_chunks::<3>().0.iter().zip(&widths) {
            let flux = f64::from(luminance_f32(pixel)) * width;
            if pixel.iter().any(|&sample| sample >= least) {
                sums[0] += width;
                sums[1] += flux;
            }
            sums[2] += flux;
        }
        sums.map(|sum| sum * bands[row])
    };
    let rows: Vec<[f64; 3]> = (0..height).into_par_iter().map(sums_of_row).collect();
    [0, 1, 2].map(|sum: usize| rows.iter().map(|row| row[sum]).sum())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use approx::assert_relative_eq;
    use ndarray::{Array3, s};

    use super::*;

    /// The upper half at `value`, the lower at a quarter.
    fn halves(value: f32) -> Array3<f32> {
        let mut map = Array3::from_elem((16, 32, 3), 0.25_f32);
        map.slice_mut(s![..8, .., ..]).fill(value);
        map
    }

    #[test]
    fn half_a_sphere_at_white_is_half_of_it_and_four_fifths_of_the_flux() {
        for white in [Some(1.0), None] {
            let share = clipped_fraction(halves(1.0).view(), Registration::CellCentred, white).unwrap();
            assert_relative_eq!(share.sphere, 0.5, max_relative = 1e-12);
            assert_relative_eq!(share.flux, 0.8, max_relative = 1e-6);
        }
    }

    #[test]
    fn nothing_is_clipped_below_white_or_in_the_dark() {
        let none = ClippedShare { sphere: 0.0, flux: 0.0 };
        let share =
            |map: Array3<f32>, white| clipped_fraction(map.view(), Registration::CellCentred, white).unwrap();
        assert_eq!(share(halves(0.9), Some(1.0)), none);
        assert_eq!(share(Array3::zeros((4, 8, 3)), None), none);
        let mut sun = halves(0.9);
        sun[[3, 3, 1]] = 7.0;
        assert_eq!(share(sun, None), none);
    }
}
