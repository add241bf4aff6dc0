//! Irradiance of point sources.

use glam::DVec3;
use ndarray::{Array3, ArrayView2};
use rayon::prelude::*;

/// Irradiance of point sources, (n, 3 axes, 3 channels): `E(n) = sum of max(0, n.F)`, with an F for each channel.
pub fn under_sources(sources: &Array3<f64>, normals: &[DVec3]) -> Vec<DVec3> {
    let flux = |source: ArrayView2<'_, f64>| {
        [0, 1, 2].map(|channel| DVec3::new(source[[0, channel]], source[[1, channel]], source[[2, channel]]))
    };
    let sources: Vec<[DVec3; 3]> = sources.outer_iter().map(flux).collect();
    let under_all = |normal: &DVec3| {
        sources.iter().fold(DVec3::ZERO, |sum, flux| {
            sum + DVec3::from_array(flux.map(|flux| normal.dot(flux))).max(DVec3::ZERO)
        })
    };
    normals.par_iter().map(under_all).collect()
}
