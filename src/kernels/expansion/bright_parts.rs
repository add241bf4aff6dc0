//! Bright cells of a map as point lights.

use glam::DVec3;

use crate::kernels::image::WorkingMap;
use crate::kernels::sphere::{band_heights, direction};

/// A light without size, with its irradiance at normal incidence.
#[derive(Clone, Copy, Debug)]
pub struct PointLight {
    pub direction: DVec3,
    pub irradiance: [f64; 3],
}

impl PointLight {
    /// Direction, A and flux of a disc of radius 0.
    pub fn disc(&self) -> (DVec3, f64, [f64; 3]) {
        (self.direction, 0.0, self.irradiance)
    }
}

/// Bright cells that do not belong to sources, as points in their middles.
pub fn bright_cells(map: &WorkingMap) -> Vec<PointLight> {
    let (theta, phi) = (&map.grid.theta_edges, &map.grid.phi_edges);
    let point = |&(row, column): &(usize, usize)| {
        let solid_angle = band_heights(&theta[row..row + 2])[0] * (phi[column + 1] - phi[column]);
        let middle = |edges: &[f64], i: usize| 0.5 * (edges[i] + edges[i + 1]);
        let irradiance = [0, 1, 2].map(|c| solid_angle * f64::from(map.radiance[[row, column, c]]));
        PointLight { direction: direction(middle(theta, row), middle(phi, column)), irradiance }
    };
    map.bright.iter().map(point).collect()
}
