//! Equations 7 to 9: the difference between a measured probe and the model.

use glam::DVec3;
use ndarray::{Array1, ArrayView1, ArrayView2};

use super::model::model;
use super::surface::Surface;
use crate::error::Result;
use crate::interrupt;
use crate::kernels::sphere::check_weighted;

/// Measured probe values and their weights.
#[derive(Clone, Debug)]
pub struct ProbeValues<'a> {
    rows: ArrayView2<'a, f64>,
    pub(super) normals: Vec<DVec3>,
    probe: ArrayView2<'a, f64>,
    /// Square roots of the weights, because a least-squares solver squares its rows.
    pub(super) roots: Vec<f64>,
}

impl<'a> ProbeValues<'a> {
    /// Check normals, values and weights and pair them up.
    ///
    /// # Inputs
    ///
    /// - `normals`: (n, 3) unit vectors; `probe`: (n, 3) radiance at each, RGB.
    /// - `weights`: (n,), not negative; all 1 in the paper.
    ///
    /// # Errors
    ///
    /// [`crate::error::Error::WrongColumns`], [`crate::error::Error::LengthMismatch`],
    /// [`crate::error::Error::NotFinite`], [`crate::error::Error::NotUnit`],
    /// [`crate::error::Error::Negative`].
    pub fn new(
        normals: ArrayView2<'a, f64>,
        probe: ArrayView2<'a, f64>,
        weights: ArrayView1<'_, f64>,
    ) -> Result<Self> {
        let rows = normals;
        let normals = check_weighted(normals, ("probe", probe), weights)?;
        Ok(Self { rows, normals, probe, roots: weights.iter().map(|weight| weight.sqrt()).collect() })
    }
}

/// Left sides of equations 7 to 9, (3n,): R, G and B of the first normal, then of the next.
///
/// ```text
///   r_i = sqrt(w_i) (R_i - k_a C L_a - sum_j k_d C L_j max(0, n_i.l_j))
/// ```
///
/// # Errors
///
/// [`crate::error::Error::NotParameters`], [`crate::error::Error::NotFinite`].
pub fn residual(
    x: ArrayView1<'_, f64>,
    measured: &ProbeValues<'_>,
    surface: &Surface,
) -> Result<Array1<f64>> {
    let mut residual = &measured.probe - &model(x, measured.rows, surface)?;
    for (mut row, root) in residual.rows_mut().into_iter().zip(&measured.roots) {
        interrupt::check();
        row *= *root;
    }
    Ok(residual.into_iter().collect())
}
