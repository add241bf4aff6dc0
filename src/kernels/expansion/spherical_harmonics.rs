//! Coefficients of a distribution of light in spherical harmonics, their products and moments.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::DEGREES;
use crate::kernels::sphere::angles;

/// Three channels of a cosine, a free slot, three channels of the sine, and another free slot.
pub type Rgb2 = [f64; 8];

/// Coefficients of three channels: order by order, degree by degree from the order on.
#[derive(Clone, Debug)]
pub struct Harmonics {
    pub values: Vec<Rgb2>,
}

/// Degree and order of each coefficient.
fn degrees_and_orders() -> impl Iterator<Item = (usize, usize)> {
    (0..DEGREES).flat_map(|m| (m..DEGREES).map(move |l| (l, m)))
}

impl Harmonics {
    /// No light.
    pub fn zero() -> Self {
        Self { values: vec![[0.0; 8]; DEGREES * (DEGREES + 1) / 2] }
    }

    /// The coefficients of degree l and order m.
    pub fn at(&self, l: usize, m: usize) -> &Rgb2 {
        &self.values[m * DEGREES - m * m.saturating_sub(1) / 2 + l - m]
    }

    /// True if two channels have the same bits.
    pub fn has_equal_channels(&self, a: usize, b: usize) -> bool {
        let are_equal = |one: &Rgb2, i: usize| one[i + a].to_bits() == one[i + b].to_bits();
        self.values.iter().all(|one| are_equal(one, 0) && are_equal(one, 4))
    }

    /// The coefficients of each order, all degrees from the order on.
    pub fn orders(&self) -> impl Iterator<Item = &[Rgb2]> {
        let mut rest = &self.values[..];
        (0..DEGREES).map(move |m| rest.split_off(..DEGREES - m).unwrap_or(&[]))
    }

    /// Add a vector to the integral of `L w dw` of a channel.
    pub fn add_first(&mut self, channel: usize, vector: DVec3) {
        let vector = vector * (3.0 / (4.0 * PI)).sqrt();
        self.values[1][channel] += vector.y;
        self.values[DEGREES][channel] -= vector.z;
        self.values[DEGREES][4 + channel] += vector.x;
    }

    /// Each degree times its factor, plus `others`, each degree times its own.
    pub fn scaled_sum(
        &self,
        factors: &[f64; DEGREES],
        others: &Self,
        other_factors: &[f64; DEGREES],
    ) -> Self {
        let pairs = self.values.iter().zip(&others.values).zip(degrees_and_orders());
        let sum = |((a, b), (l, _)): ((&Rgb2, &Rgb2), (usize, usize))| {
            std::array::from_fn(|i| factors[l] * a[i] + other_factors[l] * b[i])
        };
        Self { values: pairs.map(sum).collect() }
    }

    /// Rotate the distribution around +y, so that `azimuth` moves to 0.
    pub fn rotate(&self, azimuth: f64) -> Self {
        let turn = |(value, (_, m)): (&Rgb2, (usize, usize))| {
            let (sin, cos) = (m as f64 * azimuth).sin_cos();
            let mut out = [0.0; 8];
            for c in 0..3 {
                out[c] = value[c] * cos + value[4 + c] * sin;
                out[4 + c] = value[4 + c] * cos - value[c] * sin;
            }
            out
        };
        Self { values: self.values.iter().zip(degrees_and_orders()).map(turn).collect() }
    }

    /// Inner product with `others`, each degree times its factor, by channel.
    pub fn product(&self, others: &Self, factors: &[f64; DEGREES]) -> [f64; 3] {
        let mut out = [0.0; 3];
        for ((a, b), (l, _)) in self.values.iter().zip(&others.values).zip(degrees_and_orders()) {
            (0..3).for_each(|c| out[c] += factors[l] * (a[c] * b[c] + a[4 + c] * b[4 + c]));
        }
        out
    }

    /// The integrals of `L dw`, `L w dw` and `L w w^T dw` of a channel.
    ///
    /// The trace of the last comes from degree 0, all else from degree 2, whose harmonics are `sqrt(15 / 4 pi)` times -y z, x y,
    /// (z^2 - x^2) / 2, -x z, and `sqrt(5 / 16 pi) (3 y^2 - 1)`.
    pub fn moments(&self, channel: usize) -> (f64, DVec3, DMat3) {
        let (cosine, sine) = (|l, m| self.at(l, m)[channel], |l, m| self.at(l, m)[4 + channel]);
        let whole = cosine(0, 0) * (4.0 * PI).sqrt();
        let first = DVec3::new(sine(1, 1), cosine(1, 0), -cosine(1, 1)) * (4.0 * PI / 3.0).sqrt();
        let unit = (15.0 / (4.0 * PI)).sqrt();
        let [yz, xy, zz_xx, xz] =
            [-cosine(2, 1), sine(2, 1), 2.0 * cosine(2, 2), -sine(2, 2)].map(|value| value / unit);
        let yy = (cosine(2, 0) / (5.0 / (16.0 * PI)).sqrt() + whole) / 3.0;
        let (zz, xx) = (0.5 * (whole - yy + zz_xx), 0.5 * (whole - yy - zz_xx));
        (whole, first, DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]))
    }

    /// Azimuth of the vector irradiance, or 0 if that is almost vertical.
    pub fn azimuth(&self) -> f64 {
        let moments = [0, 1, 2].map(|channel| self.moments(channel));
        let whole: f64 = moments.iter().map(|(whole, ..)| whole).sum();
        let first: DVec3 = moments.iter().map(|(_, first, _)| first).sum();
        if first.with_y(0.0).length() > 1e-6 * whole { angles(first).1 } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::sphere::direction;

    #[test]
    fn moments_are_those_of_the_harmonics() {
        let mut harmonics = Harmonics::zero();
        let towards = DVec3::new(2.0, 3.0, -6.0) / 7.0;
        harmonics.add_discs([(towards, 0.0, [5.0, 0.0, 1.0])].into_iter());
        let (whole, first, second) = harmonics.moments(0);
        assert!((whole - 5.0).abs() < 1e-12);
        assert!((first - 5.0 * towards).length() < 1e-12);
        let expected = DMat3::from_cols(towards * towards.x, towards * towards.y, towards * towards.z) * 5.0;
        assert!((second - expected).to_cols_array().iter().all(|value| value.abs() < 1e-12), "{second}");
        harmonics.add_first(2, DVec3::new(0.1, 0.2, 0.3));
        assert!((harmonics.moments(2).1 - towards - DVec3::new(0.1, 0.2, 0.3)).length() < 1e-12);
    }

    #[test]
    fn a_rotated_point_is_a_point_at_another_azimuth() {
        let [mut one, mut other] = [Harmonics::zero(), Harmonics::zero()];
        one.add_discs([(direction(0.9, 2.5), 0.0, [1.0, 2.0, 3.0])].into_iter());
        other.add_discs([(direction(0.9, 0.8), 0.0, [1.0, 2.0, 3.0])].into_iter());
        let (rotated, azimuth) = (one.rotate(1.7), other.azimuth());
        let pairs = rotated.values.as_flattened().iter().zip(other.values.as_flattened());
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-12));
        assert!((azimuth - 0.8).abs() < 1e-12, "{azimuth}");
    }
}
