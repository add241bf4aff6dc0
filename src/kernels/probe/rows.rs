//! Sums over columns of one or two rows of a band, in wide vectors.
//!
//! L cos phi and L sin phi of a row have the weight e, and its L has the weight p. For two rows, with
//! `S = L_0 + L_1 e_1 / e_0`,
//!
//! ```text
//!   e_0 L_0 + e_1 L_1 = e_0 S
//!   p_0 L_0 + p_1 L_1 = p_0 S + q L_1,   q = p_1 - p_0 e_1 / e_0
//! ```
//!
//! so that only S is multiplied with cos and sin, and `L_1` is summed directly.

use glam::{DVec3, Vec3, Vec4};

/// Four pixels: twelve samples in three vectors of four, in any order of the channels.
pub type FourPixels = [Vec4; 3];

/// Four pixels of gray values: the number of each pixel, once for each of its samples.
pub fn four(number: impl Fn(usize) -> f32) -> FourPixels {
    [0, 4, 8].map(|first| Vec4::from_array(std::array::from_fn(|lane| number((first + lane) / 3))))
}

/// Sum of four pixels: `rgbr gbrg brgb` by channel.
#[inline]
fn by_channel([a, b, c]: FourPixels) -> Vec4 {
    let second = Vec4::new(a.w, b.x, b.y, 0.0);
    let third = Vec4::new(b.z, b.w, c.x, 0.0);
    let fourth = Vec4::new(c.y, c.z, c.w, 0.0);
    (a + second) + (third + fourth)
}

/// Weights of a row in its band.
#[derive(Debug, Clone, Copy)]
pub struct Weight {
    /// L cos phi and L sin phi.
    pub equatorial: f64,
    /// L.
    pub polar: f64,
}

/// `N` rows, at most two.
pub struct Rows<'a, const N: usize> {
    samples: [&'a [[f32; 3]]; N],
    weights: [Weight; N],
    /// Weight of each row in S: 1 and `e_1 / e_0`.
    shares: [f32; N],
    /// `e_0`.
    equatorial: f32,
    /// `p_0` and q.
    polar: [f32; N],
}

/// Weights of L cos o, L sin o and L of a column for a normal; o is the offset of the column.
pub struct ColumnWeights {
    pub cos: f32,
    pub sin: f32,
    pub one: f32,
}

impl<'a, const N: usize> Rows<'a, N> {
    pub fn new(samples: [&'a [[f32; 3]]; N], weights: [Weight; N]) -> Self {
        let first = weights[0];
        let shares = weights.map(|weight| weight.equatorial / first.equatorial);
        let mut polar = std::array::from_fn(|row| (weights[row].polar - first.polar * shares[row]) as f32);
        polar[0] = first.polar as f32;
        Self {
            samples,
            weights,
            shares: shares.map(|x| x as f32),
            equatorial: first.equatorial as f32,
            polar,
        }
    }

    /// The rows from column `first` on, in groups of four pixels.
    #[inline]
    fn fours<const PIXELS: usize>(&self, first: usize) -> [&'a [[f32; 12]]; N] {
        self.samples.map(|row| row[first..first + PIXELS].as_flattened().as_chunks().0)
    }

    /// Four samples of S, and of each row.
    #[inline]
    fn four_samples(&self, rows: [&[f32; 12]; N], part: usize) -> (Vec4, [Vec4; N]) {
        let samples = rows.map(|row| Vec4::from_slice(&row[4 * part..]));
        let further = samples.iter().zip(self.shares).skip(1);
        (further.fold(samples[0], |sum, (&samples, share)| sum + samples * share), samples)
    }

    /// Sums of L cos o, L sin o and L by channel over a block of `PIXELS` columns; `offsets` are cos o and sin o.
    #[inline]
    pub fn sums<const PIXELS: usize>(&self, first: usize, offsets: &[[FourPixels; 2]]) -> [Vec4; 3] {
        let rows = self.fours::<PIXELS>(first);
        let [mut cosines, mut sines] = [[Vec4::ZERO; 3]; 2];
        // Sums of S, then of each further row.
        let mut ones = [[Vec4::ZERO; 3]; N];
        // Add up the pixels, four at a time.
        for (i, [cos, sin]) in offsets.iter().enumerate() {
            for part in 0..3 {
                let (sum, samples) = self.four_samples(rows.map(|row| &row[i]), part);
                cosines[part] += sum * cos[part];
                sines[part] += sum * sin[part];
                ones[0][part] += sum;
                for (ones, &samples) in ones.iter_mut().zip(&samples).skip(1) {
                    ones[part] += samples;
                }
            }
        }
        // Add up each channel, and weight the rows.
        let one = ones.into_iter().zip(self.polar).map(|(one, polar)| by_channel(one) * polar).sum();
        [by_channel(cosines) * self.equatorial, by_channel(sines) * self.equatorial, one]
    }

    /// Sum of `PIXELS` columns by channel, with these weights and signs.
    #[inline]
    pub fn weighted_sum<const PIXELS: usize>(
        &self,
        first: usize,
        weights: &ColumnWeights,
        offsets: &[[FourPixels; 2]],
        signs: &[FourPixels],
    ) -> Vec4 {
        // Multiply the weights of the columns with those of S and of each row.
        let rows = self.fours::<PIXELS>(first);
        let (along, across) = (weights.cos * self.equatorial, weights.sin * self.equatorial);
        let polar = self.polar.map(|polar| polar * weights.one);
        // Add up the pixels, four at a time.
        let mut sums = [Vec4::ZERO; 3];
        for (i, ([cos, sin], signs)) in offsets.iter().zip(signs).enumerate() {
            for part in 0..3 {
                let (sum, samples) = self.four_samples(rows.map(|row| &row[i]), part);
                let mut weighted = sum * (cos[part] * along + sin[part] * across + polar[0]);
                for (&samples, polar) in samples.iter().zip(polar).skip(1) {
                    weighted += samples * polar;
                }
                sums[part] += weighted * signs[part];
            }
        }
        by_channel(sums)
    }

    /// Sum of one column; `equatorial` is the weight of cos and sin there, `polar` that of 1.
    #[inline]
    pub fn pixel(&self, column: usize, equatorial: f64, polar: f64) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for (row, weight) in self.samples.iter().zip(self.weights) {
            let factor = equatorial * weight.equatorial + polar * weight.polar;
            sum += Vec3::from_array(row[column]).as_dvec3() * factor;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    fn row() -> impl Strategy<Value = Vec<[f32; 3]>> {
        prop::collection::vec(prop::array::uniform3(0.0_f32..10.0), 8)
    }

    /// Weights of a row: at a pole the second row of a band has seven times the weight of the first.
    fn weight() -> impl Strategy<Value = Weight> {
        (0.25..2.0, -1.0..1.0).prop_map(|(equatorial, polar)| Weight { equatorial, polar })
    }

    proptest! {
        /// Wide sums agree with sums column by column, in f64 and with a weight for each row.
        #[test]
        fn wide_sums_are_those_of_the_columns(
            rows in [row(), row()], weights in [weight(), weight()], counts in prop::array::uniform8(-1_i8..=1)
        ) {
            let rows = Rows::new([rows[0].as_slice(), &rows[1]], weights);
            let offset = |column: usize| 0.1 * (column as f64 - 3.5);
            let offsets = [0, 4].map(|first| {
                [f64::cos, f64::sin].map(|f| four(|pixel| f(offset(first + pixel)) as f32))
            });
            let signs = [0, 4].map(|first| four(|pixel| f32::from(counts[first + pixel])));
            let weights_of_columns = ColumnWeights { cos: 0.3, sin: -0.7, one: 0.4 };
            let (mut sums, mut weighted) = ([DVec3::ZERO; 3], DVec3::ZERO);
            for (column, &count) in counts.iter().enumerate() {
                let (sin, cos) = offset(column).sin_cos();
                sums[0] += rows.pixel(column, cos, 0.0);
                sums[1] += rows.pixel(column, sin, 0.0);
                sums[2] += rows.pixel(column, 0.0, 1.0);
                weighted += rows.pixel(column, 0.3 * cos - 0.7 * sin, 0.4) * f64::from(count);
            }
            let result = rows.sums::<8>(0, &offsets).map(|sum| sum.truncate().as_dvec3());
            let weighted_result = rows.weighted_sum::<8>(0, &weights_of_columns, &offsets, &signs).truncate().as_dvec3();
            // Allow for some roundings of 8 columns of up to 10, with a weight of up to 9 in S.
            let rounding = 5e-7 * 8.0 * 10.0 * 9.0;
            for (result, sum) in result.into_iter().chain([weighted_result]).zip(sums.into_iter().chain([weighted])) {
                assert_relative_eq!(result.x, sum.x, epsilon = rounding);
                assert_relative_eq!(result.y, sum.y, epsilon = rounding);
                assert_relative_eq!(result.z, sum.z, epsilon = rounding);
            }
        }
    }
}
