//! Irradiance of point sources.

use glam::DVec3;
use rayon::prelude::*;

/// Irradiance of point sources: `E(n) = sum of max(0, n.F)`, with an F for each channel.
pub fn under_sources(sources: &[[DVec3; 3]], normals: &[DVec3]) -> Vec<DVec3> {
    let under_all = |normal: &DVec3| {
        sources.iter().fold(DVec3::ZERO, |sum, flux| {
            sum + DVec3::from_array(flux.map(|flux| normal.dot(flux))).max(DVec3::ZERO)
        })
    };
    normals.par_iter().map(under_all).collect()
}
