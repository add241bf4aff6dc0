//! The seen part of a map that shows only a part of the sphere.
//!
//! Radiance is multiplied by its share already, so nothing outside of the seen part is bright. The rest of the sphere is
//! unknown, not black: the threshold and the local backgrounds leave it out.

use std::f64::consts::PI;

use ndarray::ArrayView2;
use rayon::prelude::*;

use super::{Grid, block_fractions};
use crate::kernels::sphere::{Registration, band_heights};

/// Settings of the border of the seen part.
struct BorderSettings {
    /// Least share of a pixel that can be a background. Without it, a light at the border has a background of 0.
    background: f32,
    /// Least share of a pixel that is seen as a whole: one code of 8 bits below 1 and rounding do not cut a light.
    whole: f32,
    /// Rounding of the sum of a block, below which its share is 0.
    rounding: f32,
}

const BORDER: BorderSettings = BorderSettings { background: 0.5, whole: 0.99, rounding: 1e-6 };

/// Share of each working pixel that the map shows.
#[derive(Clone, Debug)]
pub struct SeenPart {
    /// Mean by solid angle, row after row; exactly 1 where all is seen.
    shares: Vec<f32>,
    /// Solid angle that is seen.
    solid_angle: f64,
}

impl SeenPart {
    /// Reduce the `seen` share of each pixel of a map to blocks of `block` x `block` pixels.
    pub fn of(seen: ArrayView2<'_, f32>, registration: Registration, block: usize) -> Self {
        let (height, width) = seen.dim();
        let pixels = Grid::of_pixels(height, width, registration);
        let grid = pixels.in_blocks(block);
        let [rows, columns] = block_fractions(&pixels, block);
        let working_width = width.div_ceil(block);
        let mut shares = vec![0.0; height.div_ceil(block) * working_width];
        shares.par_chunks_mut(working_width).enumerate().for_each(|(row, shares)| {
            // Sum what is missing: a block without a gap has a share of exactly 1.
            for row in row * block..((row + 1) * block).min(height) {
                for (column, fraction) in columns.iter().enumerate() {
                    shares[column / block] += rows[row] * fraction * (1.0 - seen[[row, column]]);
                }
            }
            for share in shares {
                *share = share_of(*share);
            }
        });
        let (bands, widths) = (band_heights(&grid.theta_edges), grid.widths());
        let solid_angle_of = |(row, band): (&[f32], &f64)| {
            band * row.iter().zip(&widths).map(|(&share, width)| f64::from(share) * width).sum::<f64>()
        };
        let solid_angle = shares.chunks(working_width).zip(&bands).map(solid_angle_of).sum();
        Self { shares, solid_angle }
    }

    /// Share of each pixel, row after row.
    pub fn shares(&self) -> &[f32] {
        &self.shares
    }

    /// Seen solid angle in steradians.
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// Seen fraction of the sphere.
    pub fn fraction(&self) -> f64 {
        self.solid_angle / (4.0 * PI)
    }

    /// True for a pixel that can be the background of a light.
    pub fn is_background(&self, pixel: usize) -> bool {
        self.shares[pixel] >= BORDER.background
    }

    /// True for a pixel that is seen as a whole.
    pub fn is_whole(&self, pixel: usize) -> bool {
        self.shares[pixel] >= BORDER.whole
    }
}

/// Share of a block from the `missing` one.
fn share_of(missing: f32) -> f32 {
    let share = 1.0 - missing;
    if share > BORDER.rounding { share } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use ndarray::Array2;

    #[test]
    fn the_share_of_a_block_is_its_mean_by_solid_angle() {
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            for (height, width, block) in [(8, 16, 1), (30, 60, 4), (37, 74, 5)] {
                let seen =
                    Array2::from_shape_fn((height, width), |(y, x)| ((3 * y + 7 * x) % 5) as f32 / 4.0);
                let part = SeenPart::of(seen.view(), registration, block);
                let solid_angles = crate::kernels::sphere::pixel_solid_angles(height, width, registration);
                let solid_angles = solid_angles.expect("a map");
                let mut sums = vec![(0.0, 0.0); part.shares.len()];
                for ((y, x), &solid_angle) in solid_angles.indexed_iter() {
                    let sum = &mut sums[y / block * width.div_ceil(block) + x / block];
                    *sum = (sum.0 + solid_angle * f64::from(seen[[y, x]]), sum.1 + solid_angle);
                }
                assert_relative_eq!(
                    part.solid_angle,
                    sums.iter().map(|sum| sum.0).sum(),
                    max_relative = 1e-6
                );
                for (&share, (seen, whole)) in part.shares.iter().zip(sums) {
                    assert_relative_eq!(f64::from(share), seen / whole, epsilon = 1e-6);
                }
            }
        }
    }

    #[test]
    fn a_block_that_is_all_seen_or_all_unseen_has_exactly_that_share() {
        let seen = Array2::from_shape_fn((37, 74), |(y, _)| f32::from(u8::from(y < 20)));
        let part = SeenPart::of(seen.view(), Registration::BorderSampled, 5);
        assert!(part.shares[..4 * 15].iter().all(|&share| share.to_bits() == 1.0_f32.to_bits()));
        assert!(part.shares[4 * 15..].iter().all(|&share| share == 0.0));
    }
}
