//! The error of a rig with sizes at normals.

use glam::DVec3;
use rayon::prelude::*;

use crate::kernels::disc::irradiance_share;
use crate::kernels::fit::rig::Rig;
use crate::kernels::fit::samples::{ProbeError, Samples};

/// Normals of one task.
const NORMALS_OF_A_PART: usize = 1280;

/// The error of a rig, whose lights have these radii, at the normals of `samples`.
pub fn evaluate(samples: &Samples, rig: &Rig, radii: &[f64]) -> ProbeError {
    let ambient = Rig { directions: Vec::new(), irradiance: Vec::new(), ..rig.clone() };
    let at = |i: usize| {
        let (n, weight, e) = (samples.normals[i], samples.weights[i], samples.irradiance[i]);
        let lights = rig.directions.iter().zip(&rig.irradiance).zip(radii);
        let seen = lights.fold(ambient.at(n), |seen, ((l, irradiance), radius)| {
            seen + *irradiance * irradiance_share(n.dot(*l), *radius)
        });
        let off = (seen - e).abs();
        (weight * off * off, weight * e * e, off.max_element())
    };
    let plus = |(difference, whole, largest): (DVec3, DVec3, f64), one: (DVec3, DVec3, f64)| {
        (difference + one.0, whole + one.1, largest.max(one.2))
    };
    let zero = (DVec3::ZERO, DVec3::ZERO, 0.0);
    // Parts of one length, added in their order: the same sums for any number of threads.
    let count = samples.normals.len();
    let part = |first: usize| (first..count.min(first + NORMALS_OF_A_PART)).map(at).fold(zero, plus);
    let (difference, whole, largest) = if count <= NORMALS_OF_A_PART {
        part(0) // without the pool of threads, whose entry takes as long
    } else {
        let parts: Vec<_> = (0..count).into_par_iter().step_by(NORMALS_OF_A_PART).map(part).collect();
        parts.into_iter().fold(zero, plus)
    };
    ProbeError::of(difference, whole).with_largest(largest, whole, samples.weights.iter().sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::sphere::direction;

    /// 3000 normals are two full tasks and a shorter one.
    #[test]
    fn discs_of_radius_0_have_the_error_of_points() {
        let normals: Vec<DVec3> =
            (0..3000).map(|i| direction(3.1 * f64::from(i) / 3000.0, 2.4 * f64::from(i))).collect();
        let irradiance = normals.iter().map(|n| DVec3::new(2.0, 1.0 + n.x, 1.5 + n.y * n.z)).collect();
        let weights = (0..normals.len()).map(|i| 1.0 + (i % 7) as f64).collect();
        let samples = Samples::of(normals, weights, irradiance);
        let rig = Rig {
            ambient: vec![DVec3::new(0.3, 0.2, 0.1)],
            directions: vec![DVec3::Y, DVec3::new(2.0, 3.0, -6.0) / 7.0],
            irradiance: vec![DVec3::ONE, DVec3::new(0.1, 2.0, 0.3)],
            ..Rig::default()
        };
        let (discs, points) = (evaluate(&samples, &rig, &[0.0; 2]), samples.evaluate(&rig));
        assert!((discs.error / points.error - 1.0).abs() < 1e-12, "{} {}", discs.error, points.error);
        let [one, other] = [discs, points].map(|error| error.largest.unwrap_or_default());
        assert!((one / other - 1.0).abs() < 1e-12, "{one} {other}");
    }
}
