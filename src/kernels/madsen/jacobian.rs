//! The Jacobian of equations 7 to 9.
//!
//! For a light in direction `l_j(theta_j, phi_j)` in front of the surface (`n.l_j > 0`), the derivatives of the
//! residual of one normal n and one channel are
//!
//! ```text
//!   dr/dL_a     = -k_a C                              dr/dtheta_j = -k_d C L_j (n . dl_j/dtheta)
//!   dr/dL_j     = -k_d C (n.l_j)                      dr/dphi_j   = -k_d C L_j (n . dl_j/dphi)
//! ```
//!
//! each times the square root of the normal's weight. A channel does not depend on the irradiance in other
//! channels. On the terminator, `n.l_j = 0`, the model has a kink; the derivative there is set to 0.

use glam::DVec3;
use ndarray::{Array2, ArrayView1, ArrayViewMut2, Axis};
use rayon::prelude::*;

use super::parameters::{OF_AMBIENT, OF_LIGHT, PackedLight, Parameters};
use super::residual::ProbeValues;
use super::surface::Surface;
use crate::error::Result;
use crate::interrupt;
use crate::kernels::sphere::{angle_derivatives, check_memory, direction};

/// Irradiance and direction of a light, with the derivatives of the direction by its angles.
struct LightDerivatives {
    irradiance: DVec3,
    direction: DVec3,
    by_angles: [DVec3; 2],
}

impl LightDerivatives {
    fn of(light: &PackedLight) -> Self {
        let PackedLight { irradiance, theta, phi } = *light;
        Self { irradiance, direction: direction(theta, phi), by_angles: angle_derivatives(theta, phi) }
    }
}

/// Derivatives, (3n, 3 + 5M), of [`super::residual()`] by each unknown of `x`, (3 + 5M,).
///
/// # Errors
///
/// [`crate::error::Error::NotParameters`], [`crate::error::Error::NotFinite`],
/// [`crate::error::Error::NoMemory`].
pub fn jacobian(
    x: ArrayView1<'_, f64>,
    measured: &ProbeValues<'_>,
    surface: &Surface,
) -> Result<Array2<f64>> {
    let lights: Vec<LightDerivatives> =
        Parameters::unpack(x)?.lights.iter().map(LightDerivatives::of).collect();
    check_memory(&[3 * measured.normals.len(), x.len()])?;
    let mut out = Array2::zeros((3 * measured.normals.len(), x.len()));
    out.axis_chunks_iter_mut(Axis(0), 3)
        .into_par_iter()
        .zip(measured.normals.par_iter().zip(&measured.roots))
        .with_min_len(interrupt::min_task_len(measured.normals.len()))
        .for_each(|(rows, (normal, root))| {
            interrupt::check();
            fill(rows, *normal, *root, &lights, surface);
        });
    Ok(out)
}

/// Write the non-zero entries of the three rows of one normal.
fn fill(
    mut rows: ArrayViewMut2<'_, f64>,
    normal: DVec3,
    root: f64,
    lights: &[LightDerivatives],
    surface: &Surface,
) {
    let ambient = -root * surface.k_a * surface.colour;
    let diffuse = -root * surface.k_d * surface.colour;
    // Write the derivatives by the ambient light.
    for channel in 0..3 {
        rows[[channel, channel]] = ambient[channel];
    }
    for (index, light) in lights.iter().enumerate() {
        // Skip a light behind the surface.
        let cosine = normal.dot(light.direction);
        if cosine <= 0.0 {
            continue;
        }
        // Write those by the irradiance and the angles of the light.
        let at = OF_AMBIENT + OF_LIGHT * index;
        let derivatives = light.by_angles.map(|by_angle| normal.dot(by_angle));
        for channel in 0..3 {
            rows[[channel, at + channel]] = diffuse[channel] * cosine;
            for (angle, derivative) in derivatives.iter().enumerate() {
                rows[[channel, at + 3 + angle]] = diffuse[channel] * light.irradiance[channel] * derivative;
            }
        }
    }
}
