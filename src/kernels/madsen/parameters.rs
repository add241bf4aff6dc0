//! The unknowns of the fit: packed into the vector that an optimiser changes, and unpacked into lights.
//!
//! ```text
//!   x = (L_a R, G, B,   L_1 R, G, B, theta_1, phi_1,   L_2 R, G, B, theta_2, phi_2,   ...)
//! ```
//!
//! The angles are those of [`crate::kernels::sphere`] and equal the paper's polar angles: its pole is z and its
//! azimuth runs from x to y, so its axes (x, y, z) are (-z, x, y) here. At the poles phi has no effect, and the
//! Jacobian loses a rank.

use glam::DVec3;
use ndarray::{Array1, Array2, ArrayView1, ArrayView2, Axis};

use crate::error::{Error, Result};
use crate::kernels::sphere::{angles, check_lengths, check_rows, direction, from_vectors, unit_vectors};

/// Unknowns of the ambient term: its radiance.
pub(super) const OF_AMBIENT: usize = 3;
/// Unknowns of a light: its irradiance, then theta and phi.
pub(super) const OF_LIGHT: usize = 5;

/// One directional light of the paper's model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PackedLight {
    /// Irradiance at normal incidence: `L_j` of the paper times the solid angle of the light.
    pub irradiance: DVec3,
    pub theta: f64,
    pub phi: f64,
}

/// The unknowns by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    /// Radiance `L_a` of the ambient light, RGB.
    pub ambient: DVec3,
    pub(super) lights: Vec<PackedLight>,
}

impl Parameters {
    /// Unpack `x`, (3 + 5M,).
    ///
    /// # Errors
    ///
    /// [`Error::NotParameters`] for another length, [`Error::NotFinite`].
    pub fn unpack(x: ArrayView1<'_, f64>) -> Result<Self> {
        let seen = x.len();
        if seen < OF_AMBIENT || !(seen - OF_AMBIENT).is_multiple_of(OF_LIGHT) {
            return Err(Error::NotParameters { seen });
        }
        check_rows("x", x.insert_axis(Axis(1)), 1)?;
        let lights = (OF_AMBIENT..seen).step_by(OF_LIGHT).map(|at| PackedLight {
            irradiance: DVec3::new(x[at], x[at + 1], x[at + 2]),
            theta: x[at + 3],
            phi: x[at + 4],
        });
        Ok(Self { ambient: DVec3::new(x[0], x[1], x[2]), lights: lights.collect() })
    }

    /// Unit vectors towards the lights, (M, 3).
    pub fn directions(&self) -> Array2<f64> {
        from_vectors(self.lights.iter().map(|light| direction(light.theta, light.phi)))
    }

    /// Irradiance of the lights at normal incidence, (M, 3).
    pub fn irradiance(&self) -> Array2<f64> {
        from_vectors(self.lights.iter().map(|light| light.irradiance))
    }
}

/// The vector x, (3 + 5M,), of ambient light and M lights; `theta` in `0 ..= pi`, `phi` in `0 .. 2 pi`.
///
/// # Inputs
///
/// - `ambient`: RGB; `directions`: (M, 3) unit vectors; `irradiance`: (M, 3).
///
/// # Errors
///
/// [`Error::WrongShape`], [`Error::WrongColumns`], [`Error::LengthMismatch`], [`Error::NotFinite`], [`Error::NotUnit`].
pub fn pack(
    ambient: ArrayView1<'_, f64>,
    directions: ArrayView2<'_, f64>,
    irradiance: ArrayView2<'_, f64>,
) -> Result<Array1<f64>> {
    if ambient.len() != OF_AMBIENT {
        let shape = ambient.shape().to_vec();
        return Err(Error::WrongShape { what: "ambient", wanted: "(3,)", shape });
    }
    check_rows("ambient", ambient.insert_axis(Axis(1)), 1)?;
    let directions = unit_vectors("direction", directions)?;
    check_rows("irradiance", irradiance, 3)?;
    check_lengths("directions", directions.len(), [("irradiance", irradiance.nrows())])?;
    let lights = directions.iter().zip(irradiance.rows()).flat_map(|(&direction, light)| {
        let (theta, phi) = angles(direction);
        [light[0], light[1], light[2], theta, phi]
    });
    Ok(ambient.iter().copied().chain(lights).collect())
}
