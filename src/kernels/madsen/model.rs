//! Equations 4 to 6: the probe under ambient light and M directional lights.

use ndarray::{Array1, Array2, ArrayView1, ArrayView2, aview1};

use super::parameters::Parameters;
use super::surface::Surface;
use crate::error::Result;
use crate::kernels::probe::sum_over_sources;

/// Radiance of the probe, (n, 3), at `normals`, (n, 3), under the lights of `x`, (3 + 5M,).
///
/// ```text
///   R_i = k_a C L_a + sum_j k_d C L_j max(0, n_i.l_j)
/// ```
///
/// The second term is that of equations 1 to 3, over M lights in place of K sources.
///
/// # Errors
///
/// [`crate::error::Error::NotParameters`], [`crate::error::Error::WrongColumns`],
/// [`crate::error::Error::NotFinite`], [`crate::error::Error::NotUnit`].
pub fn model(x: ArrayView1<'_, f64>, normals: ArrayView2<'_, f64>, surface: &Surface) -> Result<Array2<f64>> {
    let parameters = Parameters::unpack(x)?;
    // Sum the lights as sources of solid angle 1: their irradiance already includes the solid angle.
    let (directions, irradiance) = (parameters.directions(), parameters.irradiance());
    let solid_angles = Array1::ones(irradiance.nrows());
    let (k_d, colour) = (surface.k_d, surface.colour.to_array());
    let diffuse =
        sum_over_sources(normals, directions.view(), irradiance.view(), solid_angles.view(), k_d, colour)?;
    // Add the ambient light.
    let ambient = surface.k_a * surface.colour * parameters.ambient;
    Ok(diffuse + aview1(&ambient.to_array()))
}
