//! The error of a rig with sizes at normals.

use glam::DVec3;

use crate::kernels::disc::irradiance_share;
use crate::kernels::fit::rig::Rig;
use crate::kernels::fit::samples::{Judged, Samples};

/// How far `rig`, whose lights have these radii, is from `samples`.
pub fn judged(samples: &Samples, rig: &Rig, radii: &[f64]) -> Judged {
    let lights = || rig.directions.iter().zip(&rig.irradiance).zip(radii);
    let ambient = Rig { directions: Vec::new(), irradiance: Vec::new(), ..rig.clone() };
    let (mut difference, mut whole, mut largest) = (DVec3::ZERO, DVec3::ZERO, 0.0_f64);
    for ((&n, &weight), &e) in samples.normals.iter().zip(&samples.weights).zip(&samples.irradiance) {
        let mut seen = ambient.at(n);
        for ((l, irradiance), &radius) in lights() {
            seen += *irradiance * irradiance_share(n.dot(*l), radius);
        }
        let off = (seen - e).abs();
        difference += weight * off * off;
        whole += weight * e * e;
        largest = largest.max(off.max_element());
    }
    Judged::of(difference, whole, largest, samples.weights.iter().sum())
}
