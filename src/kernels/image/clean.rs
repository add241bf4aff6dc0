//! Radiance without samples that no light can have.
//!
//! Negative samples become 0. Infinite ones are light beyond the format: they get a level above all finite samples, and a
//! pixel whose channels are all infinite takes the hue of its finite neighbours. NaN takes the mean of its neighbours.

use ndarray::{ArrayView3, ArrayViewMut3};
use rayon::prelude::*;

use super::samples::{Unusable, check_rgb, largest_usable};
use crate::error::{Error, Result};
use crate::interrupt;

/// Largest half float: the level of infinite samples above smaller finite ones.
pub(super) const LARGEST_HALF: f64 = 65504.0;
/// Largest radiance that the kernels can sum.
const MOST: f64 = 1e38;
/// NaN is in the brightest light if its neighbours reach this fraction of the largest sample.
const BRIGHT: f64 = 0.5;

/// Samples that were replaced in a map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cleaning {
    /// Samples of each kind.
    pub unusable: Unusable,
    /// Level of the infinite samples, which are clipped there; none without such samples.
    pub level: Option<f64>,
    /// True if a NaN was in the brightest light.
    pub is_nan_bright: bool,
}

impl Cleaning {
    /// Cleaning of a map with these samples, before its NaN are replaced.
    ///
    /// # Errors
    ///
    /// [`Error::NoFiniteSample`].
    pub fn of(unusable: Unusable) -> Result<Self> {
        let largest = f64::from(unusable.largest.ok_or(Error::NoFiniteSample)?.max(0.0));
        let beyond = if largest < LARGEST_HALF { LARGEST_HALF } else { (2.0 * largest).min(MOST) };
        let level = (unusable.infinite > 0).then_some(beyond.max(largest));
        Ok(Self { unusable, level, is_nan_bright: false })
    }

    /// Level of the infinite samples, or of the largest one.
    fn top(&self) -> f64 {
        self.level.unwrap_or(f64::from(self.unusable.largest.unwrap_or(0.0).max(0.0)))
    }

    /// Write usable samples for `radiance`, which may be some rows of the map, into `cleaned`.
    ///
    /// The outer pixels of a row are neighbours if `wraps`, as in a map.
    ///
    /// # Errors
    ///
    /// [`Error::NotAMap`] when the array is not (height, width, 3).
    pub fn apply(
        &mut self,
        radiance: ArrayView3<'_, f32>,
        wraps: bool,
        cleaned: ArrayViewMut3<'_, f32>,
    ) -> Result<()> {
        let of_nan = replace(radiance, self.top(), wraps, cleaned)?;
        self.is_nan_bright |= of_nan > BRIGHT * self.top();
        Ok(())
    }
}

/// Largest distance in pixels to finite neighbours from which an infinite pixel takes its hue.
const REACH: usize = 64;

/// Row, column and channel of a sample.
type Place = (usize, usize, usize);

/// Write usable samples for `radiance` into `cleaned`, and return the largest one that replaces a NaN.
///
/// Infinite samples become `level`.
fn replace(
    radiance: ArrayView3<'_, f32>,
    level: f64,
    wraps: bool,
    mut cleaned: ArrayViewMut3<'_, f32>,
) -> Result<f64> {
    check_rgb(radiance)?;
    let rows: Vec<Vec<Place>> = cleaned
        .outer_iter_mut()
        .into_par_iter()
        .zip(radiance.outer_iter())
        .enumerate()
        .map(|(row, (mut cleaned, radiance))| {
            interrupt::check();
            if let (Some(cleaned), Some(samples)) = (cleaned.as_slice_mut(), radiance.as_slice())
                && largest_usable(samples).is_some()
            {
                cleaned.copy_from_slice(samples);
                return Vec::new();
            }
            cleaned.zip_mut_with(&radiance, |out, &value| *out = if value < 0.0 { 0.0 } else { value });
            let odd = cleaned.indexed_iter().filter(|(_, value)| !value.is_finite());
            odd.map(|((column, channel), _)| (row, column, channel)).collect()
        })
        .collect();
    let (nan, infinite): (Vec<Place>, Vec<Place>) =
        rows.into_iter().flatten().partition(|&(y, x, c)| cleaned[[y, x, c]].is_nan());
    let mut image = CleanedImage { cleaned, wraps };
    image.replace_infinite(&infinite, level);
    Ok(image.replace_nan(&nan))
}

/// Samples, and their neighbours.
struct CleanedImage<'a> {
    cleaned: ArrayViewMut3<'a, f32>,
    wraps: bool,
}

impl CleanedImage<'_> {
    /// Put `infinite` samples at `level`, from the border of an infinite region to its middle.
    fn replace_infinite(&mut self, infinite: &[Place], level: f64) {
        let mut open: Vec<(usize, usize)> = infinite.iter().map(|&(y, x, _)| (y, x)).collect();
        open.dedup();
        open.retain(|&at| self.is_infinite(at));
        for _ in 0..REACH {
            interrupt::check();
            let hues: Vec<_> = open.iter().filter_map(|&at| Some((at, self.hue(at)?))).collect();
            if hues.is_empty() {
                break;
            }
            for (at, hue) in hues {
                let most = hue.iter().copied().fold(0.0, f64::max);
                (0..3).for_each(|c| self.cleaned[[at.0, at.1, c]] = (level * hue[c] / most) as f32);
            }
            open.retain(|&at| self.is_infinite(at));
        }
        for &(y, x, c) in infinite {
            let sample = &mut self.cleaned[[y, x, c]];
            if *sample == f32::INFINITY {
                *sample = level as f32;
            }
        }
    }

    /// Sum of the finite neighbours; none if they are black.
    fn hue(&self, at: (usize, usize)) -> Option<[f64; 3]> {
        let near = self.neighbours(at).map(|at| self.pixel(at)).into_iter();
        let finite = near.filter(|pixel| pixel.iter().all(|sample| sample.is_finite()));
        let sum = finite.fold([0.0; 3], |sum, pixel| [0, 1, 2].map(|c| sum[c] + f64::from(pixel[c])));
        (sum.iter().copied().fold(0.0, f64::max) > 0.0).then_some(sum)
    }

    /// Put the mean of the finite neighbours into `nan` samples, and return the largest mean.
    ///
    /// Samples without such neighbours become 0.
    fn replace_nan(&mut self, nan: &[Place]) -> f64 {
        let mean = |&(y, x, c): &Place| {
            let near = self.neighbours((y, x)).map(|(y, x)| f64::from(self.cleaned[[y, x, c]]));
            let count = near.iter().filter(|value| value.is_finite()).count();
            near.iter().filter(|value| value.is_finite()).sum::<f64>() / count.max(1) as f64
        };
        let means: Vec<f64> = nan.par_iter().map(mean).collect();
        for (&(y, x, c), &mean) in nan.iter().zip(&means) {
            self.cleaned[[y, x, c]] = mean as f32;
        }
        means.into_iter().fold(0.0, f64::max)
    }

    /// True if no channel of a pixel is finite.
    fn is_infinite(&self, at: (usize, usize)) -> bool {
        self.pixel(at).iter().all(|sample| sample.is_infinite())
    }

    fn pixel(&self, (y, x): (usize, usize)) -> [f32; 3] {
        [0, 1, 2].map(|c| self.cleaned[[y, x, c]])
    }

    /// The eight pixels around a pixel; beyond the first and the last row, those of the row itself.
    fn neighbours(&self, (y, x): (usize, usize)) -> [(usize, usize); 8] {
        let (height, width, _) = self.cleaned.dim();
        let rows = [y.saturating_sub(1), y, (y + 1).min(height - 1)];
        let columns = if self.wraps {
            [(x + width - 1) % width, x, (x + 1) % width]
        } else {
            [x.saturating_sub(1), x, (x + 1).min(width - 1)]
        };
        [(0, 0), (0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1), (2, 2)].map(|(i, j)| (rows[i], columns[j]))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::Array3;

    use super::*;

    fn run(map: &Array3<f32>, wraps: bool) -> (Array3<f32>, f64) {
        let mut out = Array3::zeros(map.dim());
        let largest = replace(map.view(), 100.0, wraps, out.view_mut()).unwrap();
        (out, largest)
    }

    #[test]
    fn an_infinite_region_takes_the_hue_around_it_up_to_its_middle() {
        let mut map = Array3::from_shape_fn((9, 18, 3), |(_, _, c)| [4.0, 2.0, 1.0][c]);
        map.slice_mut(ndarray::s![2..7, 4..9, ..]).fill(f32::INFINITY);
        map[[0, 0, 0]] = -1.0;
        map[[0, 1, 2]] = f32::INFINITY;
        let (out, _) = run(&map, true);
        assert_eq!(out.slice(ndarray::s![4, 6, ..]).to_vec(), [100.0, 50.0, 25.0]);
        assert_eq!((out[[0, 0, 0]], out[[0, 1, 2]], out[[0, 1, 0]]), (0.0, 100.0, 4.0));
    }

    #[test]
    fn nan_takes_the_mean_of_its_neighbours_across_the_seam_of_a_map() {
        let mut map = Array3::from_shape_fn((4, 8, 3), |(_, x, _)| x as f32);
        map[[1, 0, 1]] = f32::NAN;
        let (out, largest) = run(&map, true);
        assert_eq!((out[[1, 0, 1]], largest), (3.0, 3.0));
        assert!((run(&map, false).0[[1, 0, 1]] - 3.0 / 7.0).abs() < 1e-6);
    }

    #[test]
    #[allow(clippy::float_cmp, reason = "exact values are expected")]
    fn infinite_samples_lie_above_all_finite_ones() {
        let of = |largest| Cleaning::of(Unusable { infinite: 1, largest, ..Unusable::default() });
        let level = |largest| of(Some(largest)).unwrap().level.unwrap();
        assert_eq!([-3.0, 7.0, 1e6].map(level), [65504.0, 65504.0, 2e6]);
        assert_eq!(level(2e38), f64::from(2e38_f32));
        assert_eq!(of(None), Err(Error::NoFiniteSample));
    }
}
