//! Light in spherical harmonics of all degrees.
//!
//! Real harmonics around +y, orthonormal on the sphere, in the angles of [`crate::kernels::sphere`]:
//!
//! ```text
//!   P_lm(cos theta) cos(m phi)      P_lm(cos theta) sin(m phi)
//! ```

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::zonal::{DEGREE, DEGREES};
use crate::kernels::fit::azimuthal::Rgb2;

/// Harmonics of one sign of m: order by order, degree by degree from the order on.
const COUNT: usize = DEGREES * (DEGREES + 1) / 2;

/// Coefficients of three channels.
#[derive(Clone, Debug)]
pub struct Harmonics {
    pub values: Vec<Rgb2>,
}

/// Degree of each coefficient.
fn degrees() -> impl Iterator<Item = usize> {
    (0..DEGREES).flat_map(|m| m..DEGREES)
}

impl Harmonics {
    /// None of all.
    pub fn zero() -> Self {
        Self { values: vec![[0.0; 8]; COUNT] }
    }

    /// Add a vector to the integral of `L w dw` of a channel.
    pub fn add_first(&mut self, channel: usize, vector: DVec3) {
        let vector = vector * (3.0 / (4.0 * PI)).sqrt();
        self.values[1][channel] += vector.y;
        self.values[DEGREES][channel] -= vector.z;
        self.values[DEGREES][4 + channel] += vector.x;
    }

    /// Each degree times its factor, plus `others`, each degree times its own.
    pub fn scaled_sum(&self, factors: &[f64; DEGREES], others: &Self, of_others: &[f64; DEGREES]) -> Self {
        let pairs = self.values.iter().zip(&others.values).zip(degrees());
        let sum = |((a, b), l): ((&Rgb2, &Rgb2), usize)| {
            std::array::from_fn(|i| factors[l] * a[i] + of_others[l] * b[i])
        };
        Self { values: pairs.map(sum).collect() }
    }

    /// Inner product with `others`, each degree times its factor, by channel.
    pub fn product(&self, others: &Self, factors: &[f64; DEGREES]) -> [f64; 3] {
        let mut out = [0.0; 3];
        for ((a, b), l) in self.values.iter().zip(&others.values).zip(degrees()) {
            (0..3).for_each(|c| out[c] += factors[l] * (a[c] * b[c] + a[4 + c] * b[4 + c]));
        }
        out
    }

    /// `integral of L dw`, `L w dw`, `L w w^T dw` of a channel: the last has its trace from degree 0, the rest from
    /// degree 2, whose harmonics are `sqrt(15 / 4 pi)` times -y z, x y, (z^2 - x^2) / 2, -x z, and
    /// `sqrt(5 / 16 pi) (3 y^2 - 1)`.
    pub fn moments(&self, channel: usize) -> (f64, DVec3, DMat3) {
        let at = |l: usize, m: usize| &self.values[m * DEGREES - m * m.saturating_sub(1) / 2 + l - m];
        let (cosine, sine) = (|l, m| at(l, m)[channel], |l, m| at(l, m)[4 + channel]);
        let whole = cosine(0, 0) * (4.0 * PI).sqrt();
        let first = DVec3::new(sine(1, 1), cosine(1, 0), -cosine(1, 1)) * (4.0 * PI / 3.0).sqrt();
        let unit = (15.0 / (4.0 * PI)).sqrt();
        let [yz, xy, zz_xx, xz] =
            [-cosine(2, 1), sine(2, 1), 2.0 * cosine(2, 2), -sine(2, 2)].map(|value| value / unit);
        let yy = (cosine(2, 0) / (5.0 / (16.0 * PI)).sqrt() + whole) / 3.0;
        let (zz, xx) = (0.5 * (whole - yy + zz_xx), 0.5 * (whole - yy - zz_xx));
        (whole, first, DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]))
    }
}

const _: () = assert!(DEGREE > 2, "moments take degree 2");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_harmonics() {
        let mut harmonics = Harmonics::zero();
        let towards = DVec3::new(2.0, 3.0, -6.0) / 7.0;
        harmonics.add_discs([(towards, 0.0, [5.0, 0.0, 1.0])].into_iter());
        let (whole, first, second) = harmonics.moments(0);
        assert!((whole - 5.0).abs() < 1e-12);
        assert!((first - 5.0 * towards).length() < 1e-12);
        let wanted = DMat3::from_cols(towards * towards.x, towards * towards.y, towards * towards.z) * 5.0;
        assert!((second - wanted).to_cols_array().iter().all(|value| value.abs() < 1e-12), "{second}");
        harmonics.add_first(2, DVec3::new(0.1, 0.2, 0.3));
        assert!((harmonics.moments(2).1 - towards - DVec3::new(0.1, 0.2, 0.3)).length() < 1e-12);
    }
}
