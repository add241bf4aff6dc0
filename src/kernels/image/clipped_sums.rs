//! Solid angle and luminance flux of clipped pixels, row by row.

use std::f64::consts::PI;

use super::luminance::luminance_f32;
use crate::kernels::sphere::band_heights;

/// Pixels of a run that is passed over if none of them is clipped.
const PIXELS_AT_ONCE: usize = 32;

/// Clipped pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ClippedSums {
    solid_angle: f64,
    /// Integral of the luminance.
    flux: f64,
}

impl ClippedSums {
    /// Pixels of some rows with a sample of at least `least`.
    ///
    /// `values` are the linear values of the RGB `samples`, `theta_edges` lie between the rows, and `widths` are those of
    /// the columns.
    pub fn of<T: Copy + PartialOrd>(
        samples: &[T],
        values: &[f32],
        theta_edges: &[f64],
        widths: &[f64],
        least: T,
    ) -> Self {
        let line = 3 * widths.len();
        let rows = samples.chunks_exact(line).zip(values.chunks_exact(line)).zip(band_heights(theta_edges));
        rows.fold(Self::default(), |mut sums, ((samples, values), band)| {
            let row = Self::of_row(samples, values, widths, least);
            sums.add(Self { solid_angle: band * row.solid_angle, flux: band * row.flux });
            sums
        })
    }

    /// Sums of widths instead of solid angles.
    fn of_row<T: Copy + PartialOrd>(samples: &[T], values: &[f32], widths: &[f64], least: T) -> Self {
        let at_once = 3 * PIXELS_AT_ONCE;
        let runs = samples.chunks(at_once).zip(values.chunks(at_once)).zip(widths.chunks(PIXELS_AT_ONCE));
        let mut sums = Self::default();
        for ((samples, values), widths) in runs {
            if !samples.iter().fold(false, |any, &sample| any | (sample >= least)) {
                continue;
            }
            let pixels = samples.as_chunks::<3>().0.iter().zip(values.as_chunks::<3>().0).zip(widths);
            for ((sample, &value), &width) in pixels {
                if sample.iter().any(|&sample| sample >= least) {
                    sums.add(Self { solid_angle: width, flux: width * f64::from(luminance_f32(value)) });
                }
            }
        }
        sums
    }

    /// Add the pixels of other rows.
    pub fn add(&mut self, other: Self) {
        self.solid_angle += other.solid_angle;
        self.flux += other.flux;
    }

    /// Fractions of the sphere, and of the `whole` luminance flux.
    pub fn shares(self, whole: f64) -> [f64; 2] {
        [self.solid_angle / (4.0 * PI), if whole > 0.0 { self.flux / whole } else { 0.0 }]
    }
}
