//! The probe under a map at the normals that evaluate a rig.
//!
//! The clamped cosine `max(0, n.w)` is half of `n.w` plus half of `|n.w|`, which is even. With the factors A of its even
//! degrees (`kernel.rs`), the integral F of `L w dw` over the map, and the vector irradiance f of each bright part,
//!
//! ```text
//!   E(n) = n.F / 2 + sum over even l of A_l L_lm Y_lm(n) + sum over bright parts of |n.f| / 2
//! ```
//!
//! A bright part that the horizon of the normal cuts adds more, as a disc of the same spread (`disc.rs`). As points, parts
//! of maps of 14 to 200 columns changed the error of a fit by up to 4e-4.
//!
//! The normal -n has the same irradiance, with the other sign of the first term. A cell with the fraction s of the flux
//! loses about 5e-3 s of the irradiance with its higher degrees, so cells of 1.5e-3 or more of the flux are bright parts.
//! On 17 real maps, the error of 1 to 32 lights is within 1e-5 to 5e-5 of the exact one.
//!
//! The normals lie on rings at the nodes of a Gauss-Legendre rule, evenly spaced in azimuth. Each ring is turned against
//! the one before by the golden section of a step. With evenly spaced heights, errors scatter twice as much.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]
#![allow(clippy::needless_range_loop, reason = "loops, not closures, are inlined")]

use std::f64::consts::TAU;
use std::sync::LazyLock;

use glam::DVec3;
use nalgebra::DMatrix;
use pulp::{Arch, Simd, WithSimd};

use super::kernel::clamped_cosine;
use crate::error::{Error, Result};
use crate::kernels::cache::Cache;
use crate::kernels::disc::irradiance_share;
use crate::kernels::expansion::{AssociatedLegendre, DEGREES, Harmonics};
use crate::kernels::fit::picture::Picture;
use crate::kernels::fit::samples::Samples;
use crate::kernels::image::{Part, WorkingMap};
use crate::kernels::sampling::gauss_legendre;
use crate::kernels::sphere::direction;

/// Normals of a ring: few, because a ring misses or hits all normals on the horizon of a polar sun. With 128, the error that
/// a fit reported for suns at the poles of small maps was up to a tenth too small.
const AZIMUTHS: usize = 32;

/// Cosine and sine of `m phi` of each order m, where phi is the azimuth from the first normal of a ring.
static TURNS: LazyLock<DMatrix<f64>> = LazyLock::new(|| {
    DMatrix::from_fn(AZIMUTHS, 2 * DEGREES, |i, column| {
        let (sin, cos) = (TAU * (i * (column / 2) % AZIMUTHS) as f64 / AZIMUTHS as f64).sin_cos();
        if column % 2 == 0 { cos } else { sin }
    })
});

/// Irradiance under a map at `fewest` normals or a few more, first those that face up and then their opposites.
///
/// # Errors
///
/// [`Error::TooBright`].
pub fn evaluation_probe(map: &WorkingMap, picture: &Picture, fewest: usize) -> Result<Samples> {
    static RINGS: Cache<usize, Rings> = Cache::new();
    let count = fewest.div_ceil(2 * AZIMUTHS);
    let rings = RINGS.get(&count, || Rings::new(count));
    let bright: Vec<BrightPart> = map.parts.iter().flat_map(BrightPart::of).collect();
    // Sum the part that is equal at opposite normals.
    let mut even = &*TURNS * rings.coefficients(&picture.cells);
    Arch::new().dispatch(BrightHalves { halves: &rings.halves, bright: &bright, even: even.as_mut_slice() });
    // Add the part that changes its sign there.
    let mut whole = [0, 1, 2].map(|channel| picture.cells.moments(channel).1);
    for (c, whole) in whole.iter_mut().enumerate() {
        *whole += bright.iter().map(|part| part.direction * part.irradiance[c]).sum::<DVec3>();
    }
    let both = |(i, normal): (usize, &DVec3)| {
        let (ring, azimuth) = (i / AZIMUTHS, i % AZIMUTHS);
        let even = DVec3::from_array([0, 1, 2].map(|c| even[(azimuth, 3 * ring + c)]));
        let odd = DVec3::from_array(whole.map(|flux| 0.5 * normal.dot(flux)));
        // Clip negative irradiance, which rounding and missing degrees cause in dark maps.
        [even + odd, even - odd].map(|sum| if sum.is_finite() { sum.max(DVec3::ZERO) } else { sum })
    };
    let (front, behind): (Vec<DVec3>, Vec<DVec3>) =
        rings.upper().iter().enumerate().map(both).map(|[front, behind]| (front, behind)).unzip();
    let irradiance = [front, behind].concat();
    if !irradiance.iter().all(|sum| sum.is_finite()) {
        return Err(Error::TooBright);
    }
    Ok(Samples::of(rings.normals.clone(), rings.weights.clone(), irradiance))
}

/// Light of a bright part of the map: a disc.
struct BrightPart {
    direction: DVec3,
    /// Irradiance at normal incidence by channel.
    irradiance: [f64; 3],
    /// Angular radius of the disc with the spread of the part.
    radius: f64,
    /// Half the sine of the radius.
    half_sine: f64,
}

impl BrightPart {
    /// The light of a part: one disc, or one for each channel if these have different directions.
    fn of(&Part { irradiance: [x, y, z], spread }: &Part) -> Vec<Self> {
        /// Relative difference of directions that differ by rounding alone.
        const SAME: f64 = 1e-12;
        let vectors = [0, 1, 2].map(|c| DVec3::new(x[c], y[c], z[c]));
        let radius = 2.0 * spread.min(0.5).sqrt().asin();
        let direction = vectors.iter().sum::<DVec3>().normalize_or(DVec3::Y);
        let irradiance = vectors.map(DVec3::length);
        if (0..3).all(|c| (vectors[c] - irradiance[c] * direction).length() <= SAME * irradiance[c]) {
            return vec![Self::new(direction, irradiance, radius)];
        }
        let channel = |c: usize| {
            let mut own = [0.0; 3];
            own[c] = irradiance[c];
            Self::new(vectors[c].normalize_or(DVec3::Y), own, radius)
        };
        (0..3).map(channel).collect()
    }

    fn new(direction: DVec3, irradiance: [f64; 3], radius: f64) -> Self {
        Self { direction, irradiance, radius, half_sine: 0.5 * radius.sin() }
    }

    /// Add the even irradiance that the radius adds at the normals of a ring whose horizon cuts the disc.
    ///
    /// The `halves` are half the cosines between normals and disc.
    fn add_spread(&self, halves: &[f64; AZIMUTHS], even: &mut [f64; 3 * AZIMUTHS]) {
        for (i, half) in halves.iter().enumerate().filter(|(_, half)| **half < self.half_sine) {
            let more = irradiance_share(2.0 * half, self.radius) - 2.0 * half;
            (0..3).for_each(|c| even[c * AZIMUTHS + i] += self.irradiance[c] * more);
        }
    }
}

/// Rings of normals around the vertical axis.
struct Rings {
    /// Normals that face up, ring after ring, then their opposites.
    normals: Vec<DVec3>,
    /// Half of each normal that faces up, axis by axis.
    halves: [Vec<f64>; 3],
    /// Solid angle of each normal.
    weights: Vec<f64>,
    /// Azimuth of the first normal of each ring.
    starts: Vec<f64>,
    /// Height of each ring.
    heights: Vec<f64>,
}

impl Rings {
    /// Place `count` rings of normals that face up, and their opposites.
    fn new(count: usize) -> Self {
        let (heights, weights) = gauss_legendre(2 * count);
        let (heights, weights) = (heights[..count].to_vec(), &weights[..count]);
        let (step, golden_section) = (TAU / AZIMUTHS as f64, 0.5 * (5.0_f64.sqrt() - 1.0));
        let starts: Vec<f64> =
            (0..count).map(|i| ((i as f64 + 0.5) * golden_section).fract() * step).collect();
        let of_ring = |(height, start): (&f64, &f64)| {
            let (theta, start) = (height.acos(), *start);
            (0..AZIMUTHS).map(move |i| direction(theta, start + step * i as f64))
        };
        let upper: Vec<DVec3> = heights.iter().zip(&starts).flat_map(of_ring).collect();
        let halves = [0, 1, 2].map(|axis| upper.iter().map(|normal| 0.5 * normal[axis]).collect());
        let normals = upper.iter().copied().chain(upper.iter().map(|&normal| -normal)).collect();
        let solid_angles = weights.iter().chain(weights).map(|weight| weight * step);
        let weights = solid_angles.flat_map(|one| std::iter::repeat_n(one, AZIMUTHS)).collect();
        Self { normals, halves, weights, starts, heights }
    }

    fn upper(&self) -> &[DVec3] {
        &self.normals[..self.normals.len() / 2]
    }

    /// Coefficients of `cos m phi` and `sin m phi` of the even irradiance, a column for each ring and channel.
    fn coefficients(&self, cells: &Harmonics) -> DMatrix<f64> {
        let lobe = clamped_cosine(DEGREES.div_ceil(2));
        let mut out = DMatrix::zeros(2 * DEGREES, 3 * self.starts.len());
        for (ring, (height, start)) in self.heights.iter().zip(&self.starts).enumerate() {
            let mut legendre = AssociatedLegendre::new(*height, (1.0 - height * height).sqrt());
            for (order, values) in cells.orders().enumerate() {
                let column = legendre.column(order);
                let mut sum = [0.0; 8];
                for degree in (order + order % 2..DEGREES).step_by(2) {
                    let weight = lobe[degree / 2] * column[degree];
                    (0..8).for_each(|i| sum[i] += weight * values[degree - order][i]);
                }
                let (sin, cos) = (order as f64 * start).sin_cos();
                for c in 0..3 {
                    out[(2 * order, 3 * ring + c)] = sum[c] * cos + sum[4 + c] * sin;
                    out[(2 * order + 1, 3 * ring + c)] = sum[4 + c] * cos - sum[c] * sin;
                }
            }
        }
        out
    }
}

/// Arguments of [`add_bright`], for the widest vectors. A closure would not use them.
struct BrightHalves<'a> {
    halves: &'a [Vec<f64>; 3],
    bright: &'a [BrightPart],
    even: &'a mut [f64],
}

impl WithSimd for BrightHalves<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        add_bright(self.halves, self.bright, self.even);
    }
}

/// Add `|n.f| / 2` of all bright parts to the `even` part of each ring, channel and normal, and what their radius adds.
#[inline(always)]
fn add_bright(halves: &[Vec<f64>; 3], bright: &[BrightPart], even: &mut [f64]) {
    for (ring, even) in even.as_chunks_mut::<{ 3 * AZIMUTHS }>().0.iter_mut().enumerate() {
        let [x, y, z] = [0, 1, 2].map(|axis| &halves[axis].as_chunks::<AZIMUTHS>().0[ring]);
        for part @ BrightPart { direction: l, irradiance: [red, green, blue], half_sine, .. } in bright {
            let mut cosines = [0.0; AZIMUTHS];
            let mut cut = 0_u32;
            for i in 0..AZIMUTHS {
                let cosine = (x[i] * l.x + y[i] * l.y + z[i] * l.z).abs();
                cosines[i] = cosine;
                cut += u32::from(cosine < *half_sine);
                even[i] += red * cosine;
                even[AZIMUTHS + i] += green * cosine;
                even[2 * AZIMUTHS + i] += blue * cosine;
            }
            if cut > 0 {
                part.add_spread(&cosines, even);
            }
        }
    }
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
