//! The probe under a map at the normals that evaluate a rig.
//!
//! Its irradiance is that of the cells, in harmonics, and that of each bright part, a disc of the same spread (`disc.rs`).
//! A point in place of that disc changed the error of a fit by up to 4e-4, in maps of 14 to 200 columns.
//!
//! A cell with the fraction s of the flux loses about 5e-3 s of the irradiance with its higher degrees, so cells of
//! 1.5e-3 or more of the flux are bright parts. On 17 real maps, the error of 1 to 32 lights is within 1e-5 to 5e-5 of the
//! exact one.
//!
//! The normals lie on rings at the nodes of a Gauss-Legendre rule, evenly spaced in azimuth. Each ring is turned against
//! the one before by the golden section of a step. With evenly spaced heights, errors scatter twice as much.

use std::array::from_fn;
use std::f64::consts::{PI, TAU};
use std::iter::repeat_n;

use glam::DVec3;

use super::kernel::clamped_cosine;
use crate::error::{Error, Result};
use crate::kernels::disc::irradiance_share;
use crate::kernels::expansion::{Cap, DEGREES, Harmonics};
use crate::kernels::fit::picture::Picture;
use crate::kernels::fit::samples::Samples;
use crate::kernels::image::{Part, WorkingMap};
use crate::kernels::sampling::gauss_legendre;
use crate::kernels::sphere::direction;

/// Normals of a ring: few, because a ring misses or hits all normals on the horizon of a polar sun. With 128, the error that
/// a fit reported for suns at the poles of small maps was up to a tenth too small.
const AZIMUTHS: usize = 32;

/// Irradiance under a map at `fewest` normals or a few more, first those that face up and then their opposites.
///
/// # Errors
///
/// [`Error::TooBright`].
pub fn evaluation_probe(map: &WorkingMap, picture: &Picture, fewest: usize) -> Result<Samples> {
    let (normals, weights) = rings(fewest.div_ceil(2 * AZIMUTHS));
    let even = clamped_cosine(DEGREES.div_ceil(2));
    let lobe = from_fn(|k| match k {
        1 => 2.0 * PI / 3.0,
        _ if k % 2 == 1 => 0.0,
        _ => even[k / 2],
    });
    let cells = picture.cells.scaled_sum(&lobe, &Harmonics::zero(), &lobe);
    let caps: Vec<Cap> = normals.iter().map(|&normal| Cap::new(normal, 0.0)).collect();
    let bright: Vec<BrightPart> = map.parts.iter().map(BrightPart::new).collect();
    let at = |(&normal, cells): (&DVec3, [f64; 3])| {
        let sum = bright.iter().fold(DVec3::from_array(cells), |sum, part| sum + part.at(normal));
        // Clip negative irradiance, which rounding and missing degrees cause in dark maps.
        if sum.is_finite() { Ok(sum.max(DVec3::ZERO)) } else { Err(Error::TooBright) }
    };
    let irradiance = normals.iter().zip(cells.values(&caps)).map(at).collect::<Result<_>>()?;
    Ok(Samples::of(normals, weights, irradiance))
}

/// Light of a bright part of the map: a disc for each channel.
struct BrightPart {
    /// Coordinates of the vector irradiance, each by channel.
    coordinates: [DVec3; 3],
    /// Irradiance at normal incidence by channel.
    irradiance: DVec3,
    /// Angular radius of the disc with the spread of the part.
    radius: f64,
    sine: f64,
}

impl BrightPart {
    fn new(part: &Part) -> Self {
        let coordinates = part.irradiance.map(DVec3::from_array);
        let [x, y, z] = coordinates;
        let irradiance = DVec3::from_array([0, 1, 2].map(|c| DVec3::new(x[c], y[c], z[c]).length()));
        let radius = 2.0 * part.spread.min(0.5).sqrt().asin();
        Self { coordinates, irradiance, radius, sine: radius.sin() }
    }

    /// Irradiance at a normal.
    fn at(&self, normal: DVec3) -> DVec3 {
        let [x, y, z] = self.coordinates;
        let along = x * normal.x + y * normal.y + z * normal.z;
        if !along.abs().cmplt(self.irradiance * self.sine).any() {
            return along.max(DVec3::ZERO);
        }
        let cosines = (along / self.irradiance.max(DVec3::splat(f64::MIN_POSITIVE))).to_array();
        self.irradiance * DVec3::from_array(cosines.map(|cosine| irradiance_share(cosine, self.radius)))
    }
}

/// Normals on `count` rings that face up, then their opposites, and the solid angle of each.
fn rings(count: usize) -> (Vec<DVec3>, Vec<f64>) {
    let (heights, weights) = gauss_legendre(2 * count);
    let (step, golden_section) = (TAU / AZIMUTHS as f64, 0.5 * (5.0_f64.sqrt() - 1.0));
    let ring = |i: usize| {
        let (theta, start) = (heights[i].acos(), ((i as f64 + 0.5) * golden_section).fract());
        (0..AZIMUTHS).map(move |k| direction(theta, step * (start + k as f64)))
    };
    let upper: Vec<DVec3> = (0..count).flat_map(ring).collect();
    let solid_angles = weights[..count].iter().flat_map(|weight| repeat_n(weight * step, AZIMUTHS));
    let solid_angles: Vec<f64> = solid_angles.collect();
    let lower: Vec<DVec3> = upper.iter().map(|&normal| -normal).collect();
    ([upper, lower].concat(), solid_angles.repeat(2))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::relative_rms;
    use crate::kernels::sphere::Registration::{self, BorderSampled, CellCentred};
    use crate::kernels::{image, probe, sphere};
    use ndarray::{Array2, Array3, ArrayView1, ArrayView2};
    use std::f64::consts::PI;

    fn waves(height: usize) -> Array3<f32> {
        let wave = |y: f64, x: f64| (11.0 * x).sin() + (0.5 * (y - x) * height as f64).cos() + 2.0;
        let unit = |i: usize| i as f64 / height as f64;
        Array3::from_shape_fn((height, 2 * height, 3), |(y, x, c)| {
            (wave(unit(y), unit(x)) * (c + 1) as f64) as f32
        })
    }

    fn working_map(radiance: &Array3<f32>, registration: Registration) -> WorkingMap {
        image::reduce(radiance.view(), registration, 256, 5e-3, false).unwrap()
    }

    fn evaluate(map: &WorkingMap) -> Samples {
        evaluation_probe(map, &Picture::new(map), 5120).unwrap()
    }

    /// Relative RMS error against exact irradiance, summed over all cells.
    fn error(map: &WorkingMap, exact: impl Fn(ArrayView2<'_, f64>) -> Result<Array2<f64>>) -> f64 {
        let samples = evaluate(map);
        let normals = sphere::from_vectors(samples.normals.iter().copied());
        let exact = exact(normals.view()).unwrap();
        let fast = sphere::from_vectors(samples.irradiance.iter().copied());
        relative_rms(fast.view(), exact.view(), ArrayView1::from(&samples.weights)).unwrap()
    }

    /// Checks cells of several pixels, cells of one pixel, and few cells.
    #[test]
    fn irradiance_is_the_sum_over_all_cells() {
        let both = |height| [(height, CellCentred), (height, BorderSampled)];
        for (height, registration) in [128, 125, 32, 9].into_iter().flat_map(both).chain([(256, CellCentred)])
        {
            let map = working_map(&waves(height), registration);
            let error = error(&map, |normals| probe::irradiance(map.radiance.view(), registration, normals));
            assert!(error < 1e-4, "{height} rows, {registration:?}: {error:e}");
        }
    }

    /// A sun whose channels have different directions, and lamps that are bright cells, in front of a dark sky.
    #[test]
    fn bright_parts_are_exact() {
        let mut map = 0.05 * waves(256);
        map[[100, 300, 0]] = 3e4;
        map[[100, 301, 1]] = 3e4;
        for lamp in 0..12 {
            map[[60 + 11 * lamp, 37 * lamp, 2]] = 120.0;
        }
        let reduced = working_map(&map, CellCentred);
        assert_eq!((reduced.sources.dim().0, reduced.bright.len()), (1, 12));
        let error = error(&reduced, |normals| probe::irradiance(map.view(), CellCentred, normals));
        assert!(error < 2e-5, "{error:e}");
    }

    #[test]
    fn normals_represent_the_whole_sphere() {
        let Samples { normals, weights, .. } = evaluate(&working_map(&waves(32), CellCentred));
        assert_eq!(normals.len(), 5120);
        assert!((weights.iter().sum::<f64>() / (4.0 * PI) - 1.0).abs() < 1e-12);
        // The mean of the product of two axes is a third, or 0.
        let mean = |i: usize, k: usize| -> f64 {
            normals.iter().zip(&weights).map(|(n, weight)| weight * n[i] * n[k] / (4.0 * PI)).sum()
        };
        for (i, k) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
            let expected = if i == k { 1.0 / 3.0 } else { 0.0 };
            assert!((mean(i, k) - expected).abs() < 1e-14, "{i} {k}: {}", mean(i, k));
        }
    }
}
