//! Ambient and directional lights: equations 4 to 6 of Madsen et al. 2003, in physical scale.

use glam::DVec3;
#[cfg(test)]
use ndarray::Array2;
use ndarray::ArrayView2;

use super::ambient::Ambient;
use crate::error::Result;
use crate::kernels::sphere::vectors;
#[cfg(test)]
use crate::kernels::sphere::{from_vectors, unit_vectors};

/// Ambient and directional lights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rig {
    /// Coefficients of the environment's radiance, RGB: as many as [`Ambient`] has.
    pub ambient: Vec<DVec3>,
    /// Towards each light.
    pub directions: Vec<DVec3>,
    /// Irradiance of each light at normal incidence, RGB.
    pub irradiance: Vec<DVec3>,
    /// True over a floor, which hides the lower half of a constant environment.
    pub has_floor: bool,
}

impl Rig {
    /// An `ambient` term of (0, 1 or 9, 3) alone, over a floor or not.
    ///
    /// # Errors
    ///
    /// [`crate::error::Error::NotAmbient`], [`crate::error::Error::WrongColumns`], [`crate::error::Error::NotFinite`].
    pub fn of_ambient(ambient: ArrayView2<'_, f64>, has_floor: bool) -> Result<Self> {
        Ambient::of(ambient.nrows())?;
        Ok(Self { ambient: vectors("ambient", ambient)?, has_floor, ..Self::default() })
    }

    /// Irradiance at `normal` of each ambient coefficient alone.
    pub fn ambient_columns(&self, normal: DVec3) -> [f64; 9] {
        let columns = Ambient::of(self.ambient.len()).unwrap_or(Ambient::None).irradiance(normal);
        if self.has_floor { columns.map(|column| 0.5 * column * (1.0 + normal.y)) } else { columns }
    }

    /// Irradiance at `normal`.
    pub fn at(&self, normal: DVec3) -> DVec3 {
        let ambient = self
            .ambient
            .iter()
            .zip(self.ambient_columns(normal))
            .fold(DVec3::ZERO, |sum, (c, column)| sum + c * column);
        let lights = self.directions.iter().zip(&self.irradiance);
        lights
            .fold(ambient, |sum, (direction, irradiance)| sum + irradiance * normal.dot(*direction).max(0.0))
    }
}

/// Irradiance of `rig` at `normals`, (n, 3), as if all lights were points.
#[cfg(test)]
pub fn irradiance(rig: &Rig, normals: ArrayView2<'_, f64>) -> Result<Array2<f64>> {
    let normals = unit_vectors("normal", normals)?;
    Ok(from_vectors(normals.iter().map(|&normal| rig.at(normal))))
}
