//! The nine real spherical harmonics up to order 2, and the irradiance under each.
//!
//! In the order and with the signs of Ramamoorthi and Hanrahan (2001), equation 3:
//!
//! ```text
//!   1    y    z    x    x y    y z    3 z^2 - 1    x z    x^2 - y^2
//! ```
//!
//! A clamped cosine scales those of order 0, 1 and 2 by pi, 2 pi / 3 and pi / 4 (equation 8), so that the
//! irradiance under an ambient term is its coefficients times nine polynomials of the normal.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use ndarray::{Array2, ArrayView2};

use super::sphere::unit_vectors;
use crate::error::Result;
use crate::interrupt;

/// Factors of the clamped cosine for order 0, 1 and 2.
const COSINE_LOBE: [f64; 3] = [PI, 2.0 * PI / 3.0, PI / 4.0];
/// Order of each harmonic.
const ORDER: [usize; 9] = [0, 1, 1, 1, 2, 2, 2, 2, 2];

/// Irradiance under the harmonic 1, a constant.
pub const CONSTANT: f64 = COSINE_LOBE[0] * 0.282_094_791_773_878_14;
/// Irradiance under x, y and z, over x, y and z.
pub const LINEAR: f64 = COSINE_LOBE[1] * 0.488_602_511_902_919_9;
/// Irradiance under x y, y z and x z, over these; half of it for `x^2 - y^2`.
pub const SQUARE: f64 = COSINE_LOBE[2] * 1.092_548_430_592_079_2;
/// Irradiance under `3 z^2 - 1`, over it.
pub const ZONAL: f64 = COSINE_LOBE[2] * 0.315_391_565_252_520_05;

/// Factors of the nine polynomials in the irradiance under each harmonic.
pub const FACTORS: [f64; 9] = [CONSTANT, LINEAR, LINEAR, LINEAR, SQUARE, SQUARE, ZONAL, SQUARE, SQUARE / 2.0];

/// Irradiance at `normal` under each harmonic.
pub fn irradiance(normal: DVec3) -> [f64; 9] {
    let DVec3 { x, y, z } = normal;
    [
        CONSTANT,
        LINEAR * y,
        LINEAR * z,
        LINEAR * x,
        SQUARE * x * y,
        SQUARE * y * z,
        ZONAL * (3.0 * z * z - 1.0),
        SQUARE * x * z,
        SQUARE / 2.0 * (x * x - y * y),
    ]
}

/// Irradiance under each harmonic, summed over directions that have this whole, first and second moment.
pub fn irradiance_of_moments(whole: f64, first: DVec3, second: DMat3) -> [f64; 9] {
    let [xx, xy, xz, _, yy, yz, _, _, zz] = second.to_cols_array();
    [
        CONSTANT * whole,
        LINEAR * first.y,
        LINEAR * first.z,
        LINEAR * first.x,
        SQUARE * xy,
        SQUARE * yz,
        ZONAL * (3.0 * zz - whole),
        SQUARE * xz,
        SQUARE / 2.0 * (xx - yy),
    ]
}

/// Factor of the clamped cosine for harmonic `k`.
pub fn cosine_lobe(k: usize) -> f64 {
    COSINE_LOBE[ORDER[k]]
}

/// Value of each harmonic in `direction`, from the irradiance so that each polynomial is written once.
pub fn radiance(direction: DVec3) -> [f64; 9] {
    let irradiance = irradiance(direction);
    std::array::from_fn(|k| irradiance[k] / COSINE_LOBE[ORDER[k]])
}

/// Values of the harmonics, (n, 9), in `directions`, (n, 3).
///
/// # Errors
///
/// [`crate::error::Error::WrongColumns`], [`crate::error::Error::NotFinite`], [`crate::error::Error::NotUnit`].
pub fn harmonic_radiance(directions: ArrayView2<'_, f64>) -> Result<Array2<f64>> {
    Ok(rows(&unit_vectors("direction", directions)?, radiance))
}

/// Irradiance under each harmonic, (n, 9), at `normals`, (n, 3).
///
/// # Errors
///
/// [`crate::error::Error::WrongColumns`], [`crate::error::Error::NotFinite`], [`crate::error::Error::NotUnit`].
pub fn harmonic_irradiance(normals: ArrayView2<'_, f64>) -> Result<Array2<f64>> {
    Ok(rows(&unit_vectors("normal", normals)?, irradiance))
}

fn rows(vectors: &[DVec3], nine: fn(DVec3) -> [f64; 9]) -> Array2<f64> {
    let row = |&vector: &DVec3| {
        interrupt::check();
        nine(vector)
    };
    Array2::from(vectors.iter().map(row).collect::<Vec<_>>())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::Axis;

    use super::*;
    use crate::kernels::sampling;

    /// Checks sums over an even sphere, where harmonics are orthogonal and have the norm 1.
    #[test]
    fn harmonics_are_orthonormal() {
        let (directions, solid_angles) = sampling::icosphere(20480).unwrap();
        let values = harmonic_radiance(directions.view()).unwrap();
        let weighted = &values * &solid_angles.insert_axis(Axis(1));
        for ((row, column), product) in values.t().dot(&weighted).indexed_iter() {
            let expected = f64::from(row == column);
            assert!((product - expected).abs() < 1e-3, "{row}, {column}: {product}");
        }
    }

    /// Checks against the definition, the sum of the radiance in front of the normal times the cosine.
    #[test]
    fn irradiance_is_the_integral_of_the_radiance() {
        let (directions, solid_angles) = sampling::icosphere(20480).unwrap();
        let radiance = harmonic_radiance(directions.view()).unwrap();
        let (normals, _) = sampling::icosphere(20).unwrap();
        let cosines = normals.dot(&directions.t()).mapv(|cosine| cosine.max(0.0)) * solid_angles;
        let difference = cosines.dot(&radiance) - harmonic_irradiance(normals.view()).unwrap();
        assert!(difference.iter().all(|value| value.abs() < 1e-3), "{difference}");
    }
}
