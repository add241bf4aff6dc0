//! Solid angle and luminance flux of each of the largest codes, where the clip level of a picture may be.

use std::f64::consts::PI;

use super::luminance::luminance_f32;
use super::sample_types::{Sample, larger};
use super::white::CODES;
use crate::kernels::sphere::band_heights;

/// Pixels of a run that is passed over if none of them has one of the largest codes.
const PIXELS_AT_ONCE: usize = 32;

/// Sums over pixels by the code of their largest channel, from [`Sample::TOP`] on; empty without pixels or codes.
#[derive(Clone, Debug, Default)]
pub(super) struct TopCodes {
    /// Solid angle, and integral of the luminance.
    sums: Vec<[f64; 2]>,
}

impl TopCodes {
    /// Pixels of some rows.
    ///
    /// `values` are the linear values of the RGB `samples`, `theta_edges` lie between the rows, and `widths` are those of
    /// the columns.
    pub fn of<T: Sample>(samples: &[T], values: &[f32], theta_edges: &[f64], widths: &[f64]) -> Self {
        let mut top = Self::default();
        let Some(first) = T::TOP else { return top };
        let line = 3 * widths.len();
        let rows = samples.chunks_exact(line).zip(values.chunks_exact(line)).zip(band_heights(theta_edges));
        for ((samples, values), band) in rows {
            top.add_row(samples, values, widths, band, first);
        }
        top
    }

    fn add_row<T: Sample>(&mut self, samples: &[T], values: &[f32], widths: &[f64], band: f64, first: T) {
        let at_once = 3 * PIXELS_AT_ONCE;
        let runs = samples.chunks(at_once).zip(values.chunks(at_once)).zip(widths.chunks(PIXELS_AT_ONCE));
        for ((samples, values), widths) in runs {
            // A count is a loop of vectors, where `any` would stop at each sample.
            if samples.iter().filter(|&&sample| sample >= first).count() == 0 {
                continue;
            }
            self.sums.resize(T::CODES - first.code(), [0.0; 2]);
            let pixels = samples.as_chunks::<3>().0.iter().zip(values.as_chunks::<3>().0).zip(widths);
            for ((&[red, green, blue], &value), &width) in pixels {
                let largest = larger(larger(red, green), blue);
                if largest >= first {
                    let [solid_angle, flux] = &mut self.sums[largest.code() - first.code()];
                    *solid_angle += band * width;
                    *flux += band * width * f64::from(luminance_f32(value));
                }
            }
        }
    }

    /// Add the pixels of other rows.
    pub fn add(&mut self, other: &Self) {
        self.sums.resize(self.sums.len().max(other.sums.len()), [0.0; 2]);
        for (sum, other) in self.sums.iter_mut().zip(&other.sums) {
            (0..2).for_each(|i| sum[i] += other[i]);
        }
    }

    /// Fractions of the sphere, and of the `whole` luminance flux, of pixels from the code `least` on.
    pub fn shares<T: Sample>(&self, least: T, whole: f64) -> [f64; 2] {
        let from = T::TOP.map_or(0, |first| least.code().saturating_sub(first.code()));
        let clipped =
            self.sums.iter().skip(from).fold([0.0; 2], |sum, bin| [sum[0] + bin[0], sum[1] + bin[1]]);
        [clipped[0] / (4.0 * PI), if whole > 0.0 { clipped[1] / whole } else { 0.0 }]
    }

    /// Solid angle of each code as 8 bits; that of smaller codes than [`Sample::TOP`] is in the first bin.
    pub fn histogram<T: Sample>(&self) -> [f64; CODES] {
        let mut histogram = [0.0; CODES];
        for (bin, sum) in self.sums.iter().enumerate() {
            let code = bin + T::TOP.map_or(0, Sample::code);
            histogram[T::as_8_bits(code)] += sum[0];
        }
        histogram[0] = (4.0 * PI - histogram.iter().sum::<f64>()).max(0.0);
        histogram
    }
}
