//! The error of a rig with sizes at normals.

use glam::DVec3;
use rayon::prelude::*;

use crate::kernels::disc::irradiance_share;
use crate::kernels::fit::rig::Rig;
use crate::kernels::fit::samples::{Judged, Samples};

/// Irradiance of one disc at a normal, over that at normal incidence, as a function of the cosine.
///
/// If the horizon cuts the disc, it is a cubic through a table of the closed form.
#[derive(Clone, Debug)]
struct Profile {
    sine: f64,
    /// At cosines from `-sine` to `sine`, and one beyond at either end.
    nodes: Vec<f64>,
}

impl Profile {
    const CELLS: usize = 256;

    fn new(radius: f64) -> Self {
        let sine = radius.sin();
        let cosine = |i: usize| sine * (2.0 * (i as f64 - 1.0) / Self::CELLS as f64 - 1.0);
        let nodes = (0..Self::CELLS + 3).map(|i| irradiance_share(cosine(i), radius)).collect();
        Self { sine, nodes }
    }

    fn at(&self, cosine: f64) -> f64 {
        if cosine.abs() >= self.sine {
            return cosine.max(0.0);
        }
        let place = (cosine / self.sine + 1.0) * 0.5 * Self::CELLS as f64;
        let cell = (place as usize).min(Self::CELLS - 1);
        let beyond = place - cell as f64;
        // Catmull and Rom (1974).
        let [before, low, high, after] = [0, 1, 2, 3].map(|i| self.nodes[cell + i]);
        let cubic = 3.0 * (low - high) + after - before;
        let square = 2.0 * before - 5.0 * low + 4.0 * high - after;
        low + 0.5 * beyond * (high - before + beyond * (square + beyond * cubic))
    }
}

/// Normals of one task.
const NORMALS_OF_A_PART: usize = 1280;

/// The error of a rig, whose lights have these radii, at the normals of `samples`.
pub fn evaluate(samples: &Samples, rig: &Rig, radii: &[f64]) -> Judged {
    let profiles: Vec<Profile> = radii.iter().map(|&radius| Profile::new(radius)).collect();
    let ambient = Rig { directions: Vec::new(), irradiance: Vec::new(), ..rig.clone() };
    let at = |i: usize| {
        let (n, weight, e) = (samples.normals[i], samples.weights[i], samples.irradiance[i]);
        let lights = rig.directions.iter().zip(&rig.irradiance).zip(&profiles);
        let seen = lights.fold(ambient.at(n), |seen, ((l, irradiance), profile)| {
            seen + *irradiance * profile.at(n.dot(*l))
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
    Judged::of(difference, whole, largest, samples.weights.iter().sum())
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
        assert!((discs.largest / points.largest - 1.0).abs() < 1e-12, "{} {}", discs.largest, points.largest);
    }

    #[test]
    fn a_profile_is_the_closed_form() {
        for degrees in [0.0, 0.3, 10.0, 75.0_f64] {
            let radius = degrees.to_radians();
            let profile = Profile::new(radius);
            for i in 0..=1000 {
                let cosine = f64::from(i) / 500.0 - 1.0;
                let error = profile.at(cosine) - irradiance_share(cosine, radius);
                assert!(error.abs() < 5e-6, "{degrees} {cosine}: {error:e}");
            }
        }
    }
}
