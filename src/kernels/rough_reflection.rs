//! Radiance that a rough surface reflects of a map, as a sum over all pixels.
//!
//! ```text
//!   I(n, v) = sum over pixels of L omega f(l, v) (n.l)      f = F D G / (4 (n.l) (n.v))
//! ```
//!
//! D and G are those of Walter et al. 2007 (equations 33 and 34, separable), F is that of Schlick (1994). With the sum
//! `s = n.l + n.v` and the square `q = |l + v|^2 = 2 + 2 l.v`, one root and one division remain for each pixel:
//!
//! ```text
//!   D = alpha^2 q^2 / (pi (q - (1 - alpha^2) s^2)^2)
//! ```
//!
//! The pixels are points, in single precision: a relative error of up to `4e-7 / alpha^2`. Sums over rows are in double precision.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]
#![allow(clippy::needless_range_loop, reason = "loops, not closures, become wide vectors")]

use std::f64::consts::PI;

use glam::DVec3;
use ndarray::{Array2, ArrayView2, ArrayView3};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::sphere::{Registration, band_heights, check_lengths, unit_vectors};
use crate::error::{Error, Result};
use crate::interrupt;

/// Numbers of one chunk of a row; each has a sum of its own.
const CHUNK: usize = 8;
/// Smallest roughness: below, single precision is not enough for the peak of a lobe.
pub const LEAST_ROUGHNESS: f64 = 0.1;

/// Radiance, (n, channels), that a surface of a `roughness` reflects from a cell-centred map towards `views`.
///
/// The microfacets reflect `specular` at normal incidence, and all at grazing incidence.
///
/// # Inputs
///
/// - `radiance`: (height, width, channels), finite and not negative.
/// - `normals`, `views`: (n, 3), unit vectors in the frame of [`super::sphere`].
///
/// # Errors
///
/// [`Error::WrongShape`], [`Error::NotFinite`], [`Error::Negative`] for the map, [`Error::OutOfRange`] for the surface; for the vectors
/// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NotUnit`], [`Error::LengthMismatch`].
pub fn rough_reflection(
    radiance: ArrayView3<'_, f32>,
    normals: ArrayView2<'_, f64>,
    views: ArrayView2<'_, f64>,
    roughness: f64,
    specular: f64,
) -> Result<Array2<f64>> {
    let planes = Planes::new(radiance)?;
    for (what, value, least) in [("roughness", roughness, LEAST_ROUGHNESS), ("specular", specular, 0.0)] {
        if !(least..=1.0).contains(&value) {
            return Err(Error::OutOfRange { what, value, least, most: 1.0 });
        }
    }
    let (normals, views) = (unit_vectors("normals", normals)?, unit_vectors("views", views)?);
    check_lengths("views", views.len(), [("normals", normals.len())])?;
    let channels = planes.channels;
    let mut out = Array2::zeros((normals.len(), channels));
    let lobe = Lobe { square: roughness.powi(4) as f32, specular: specular as f32 };
    let rows = out.as_slice_mut().unwrap_or_default().par_chunks_mut(channels);
    rows.zip(normals.par_iter().zip(&views)).for_each(|(sums, (&normal, &view))| {
        interrupt::check();
        Arch::new().dispatch(Reflection { planes: &planes, lobe, normal, view, sums });
    });
    Ok(out)
}

/// Microfacets of a surface.
#[derive(Clone, Copy, Debug)]
struct Lobe {
    /// `alpha^2`, the fourth power of the roughness.
    square: f32,
    specular: f32,
}

/// Light of each pixel, channel by channel, in rows of whole chunks.
struct Planes {
    channels: usize,
    /// Numbers of one row.
    length: usize,
    /// Sine and cosine of the polar angle of each row.
    rows: Vec<(f32, f32)>,
    /// Sine and cosine of the azimuth of each column.
    columns: Vec<(f64, f64)>,
    /// Radiance times solid angle over `scale`, by row, channel and column.
    light: Vec<f32>,
    /// Largest sample of the map, so that sums do not overflow.
    scale: f64,
}

impl Planes {
    fn new(radiance: ArrayView3<'_, f32>) -> Result<Self> {
        let (height, width, channels) = radiance.dim();
        if height < 2 || width < 2 || channels == 0 {
            let wanted = "(height, width, channels), with height and width at least 2";
            return Err(Error::WrongShape { what: "radiance", wanted, shape: radiance.shape().to_vec() });
        }
        let scale = f64::from(check_samples(radiance)?).max(f64::from(f32::MIN_POSITIVE));
        let registration = Registration::CellCentred;
        let bands = band_heights(&registration.theta_edges(height));
        let length = width.next_multiple_of(CHUNK);
        let mut light = vec![0.0; height * channels * length];
        for (index, line) in light.chunks_exact_mut(length).enumerate() {
            let (row, channel) = (index / channels, index % channels);
            let solid_angle = bands[row] * 2.0 * PI / width as f64;
            for column in 0..width {
                line[column] = (f64::from(radiance[[row, column, channel]]) / scale * solid_angle) as f32;
            }
        }
        let as_f32 = |angle: &f64| (angle.sin() as f32, angle.cos() as f32);
        let rows = registration.thetas(height).iter().map(as_f32).collect();
        let columns = registration.phis(width).iter().map(|angle| angle.sin_cos()).collect();
        Ok(Self { channels, length, rows, columns, light, scale })
    }

    /// Part of the product of a vector and the pixels of a row that the sine of the row multiplies, by column.
    fn wave(&self, vector: DVec3) -> Vec<f32> {
        let mut out = vec![0.0; self.length];
        for (value, (sine, cosine)) in out.iter_mut().zip(&self.columns) {
            *value = (vector.x * sine - vector.z * cosine) as f32;
        }
        out
    }
}

/// Largest sample, or a refusal of one that is not finite or is negative.
fn check_samples(radiance: ArrayView3<'_, f32>) -> Result<f32> {
    let mut largest = 0.0_f32;
    for ((row, ..), &sample) in radiance.indexed_iter() {
        let value = f64::from(sample);
        if !sample.is_finite() {
            return Err(Error::NotFinite { what: "radiance", index: row, value });
        }
        if sample < 0.0 {
            return Err(Error::Negative { what: "radiance", index: row, value });
        }
        largest = largest.max(sample);
    }
    Ok(largest)
}

/// Sum for one normal and view, in the widest vectors. A closure would not use them.
struct Reflection<'a> {
    planes: &'a Planes,
    lobe: Lobe,
    normal: DVec3,
    view: DVec3,
    sums: &'a mut [f64],
}

impl WithSimd for Reflection<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { planes, lobe, normal, view, sums } = self;
        let towards = normal.dot(view);
        if towards <= 0.0 {
            return; // the surface is seen from behind
        }
        let (normal_wave, view_wave) = (planes.wave(normal), planes.wave(view));
        let mut weights = vec![0.0; planes.length];
        let lines = planes.light.chunks_exact(planes.length * planes.channels);
        for (&(sine, cosine), lines) in planes.rows.iter().zip(lines) {
            let heights = [normal.y as f32 * cosine, view.y as f32 * cosine, towards as f32];
            // Skip rows behind the surface.
            if heights[0] + (1.0 - normal.y * normal.y).max(0.0).sqrt() as f32 * sine <= 0.0 {
                continue;
            }
            weigh(lobe, sine, heights, &normal_wave, &view_wave, &mut weights);
            for (sum, line) in sums.iter_mut().zip(lines.chunks_exact(planes.length)) {
                *sum += f64::from(dot(&weights, line));
            }
        }
        // Smith's masking of the view, over twice its cosine.
        let square = f64::from(lobe.square);
        let masking = 1.0 / (towards + (square + (1.0 - square) * towards * towards).sqrt());
        for sum in sums {
            *sum *= planes.scale * square * masking / PI;
        }
    }
}

/// Reflectance times the cosine for the pixels of a row, without the factors of all pixels.
#[inline(always)]
fn weigh(
    lobe: Lobe,
    sine: f32,
    [normal_height, view_height, towards]: [f32; 3],
    normal_wave: &[f32],
    view_wave: &[f32],
    weights: &mut [f32],
) {
    let rest = 1.0 - lobe.square;
    let count = weights.len().min(normal_wave.len()).min(view_wave.len());
    for i in 0..count {
        let cosine = normal_height + sine * normal_wave[i];
        let both = cosine + towards;
        // The square of the length of light plus view, which rounding may make negative.
        let length = 2.0 + 2.0 * (view_height + sine * view_wave[i]);
        let length = if length > 0.0 { length } else { 0.0 };
        let spread = length - rest * both * both;
        let masking = cosine + (lobe.square + rest * cosine * cosine).sqrt();
        let off = 1.0 - 0.5 * length.sqrt();
        let fourth = off * off * off * off;
        let fresnel = lobe.specular + (1.0 - lobe.specular) * fourth * off;
        let value = cosine * fresnel * length * length / (spread * spread * masking);
        weights[i] = if cosine > 0.0 { value } else { 0.0 };
    }
}

/// Sum of products, in the same order on every processor.
#[inline(always)]
fn dot(weights: &[f32], line: &[f32]) -> f32 {
    let mut sums = [0.0_f32; CHUNK];
    for (weights, line) in weights.chunks_exact(CHUNK).zip(line.chunks_exact(CHUNK)) {
        for i in 0..CHUNK {
            sums[i] += weights[i] * line[i];
        }
    }
    sums.iter().sum()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::sampling;
    use crate::kernels::sphere::{pixel_solid_angles, row_directions};
    use ndarray::{Array3, Axis};

    /// The formulas of Walter et al. and Schlick, term by term.
    fn reflectance(normal: DVec3, view: DVec3, light: DVec3, alpha: f64, specular: f64) -> f64 {
        let (in_front, towards) = (normal.dot(light), normal.dot(view));
        if in_front <= 0.0 {
            return 0.0;
        }
        let half = (light + view).normalize();
        let tangent = |cosine: f64| (1.0 - cosine * cosine) / (cosine * cosine);
        let masking = |cosine: f64| 2.0 / (1.0 + (1.0 + alpha * alpha * tangent(cosine)).sqrt());
        let cosine = normal.dot(half);
        let facets = alpha * alpha / (PI * cosine.powi(4) * (alpha * alpha + tangent(cosine)).powi(2));
        let fresnel = specular + (1.0 - specular) * (1.0 - half.dot(view)).powi(5);
        fresnel * facets * masking(in_front) * masking(towards) / (4.0 * towards)
    }

    #[test]
    fn a_reflection_is_the_sum_over_the_pixels() {
        let map = Array3::from_shape_fn((20, 42, 3), |(y, x, c)| {
            if (y, x) == (6, 9) { 1e4 } else { ((7 * y + 3 * x + c) % 11) as f32 }
        });
        let (directions, angles) = (
            row_directions(20, 42, Registration::CellCentred, 0..20).unwrap(),
            pixel_solid_angles(20, 42, Registration::CellCentred).unwrap(),
        );
        let normals = sampling::even_sphere(12);
        let views = Array2::from_shape_fn((12, 3), |(i, k)| normals[[(i + 1) % 12, k]]);
        for (roughness, specular) in [(0.2_f64, 1.0), (0.5, 0.04), (1.0, 0.8)] {
            let out =
                rough_reflection(map.view(), normals.view(), views.view(), roughness, specular).unwrap();
            for (i, row) in out.axis_iter(Axis(0)).enumerate() {
                let [normal, view] =
                    [&normals, &views].map(|of| DVec3::new(of[[i, 0]], of[[i, 1]], of[[i, 2]]));
                let mut expected = 0.0;
                for ((y, x), angle) in angles.indexed_iter() {
                    let light = DVec3::from_array([0, 1, 2].map(|k| directions[[y, x, k]]));
                    let value = reflectance(normal, view, light, roughness * roughness, specular);
                    expected += f64::from(map[[y, x, 1]]) * angle * value;
                }
                let expected = if normal.dot(view) > 0.0 { expected } else { 0.0 };
                let tolerance = f64::max(1e-4, 4e-7 / roughness.powi(4));
                let error = (row[1] - expected).abs();
                assert!(error <= tolerance * expected, "{roughness} {i} {} {expected}", row[1]);
            }
        }
    }

    #[test]
    fn refusals_name_the_argument() {
        let (map, one) = (Array3::ones((4, 8, 3)), ndarray::arr2(&[[0.0, 1.0, 0.0]]));
        let call = |map: &Array3<f32>, roughness| {
            rough_reflection(map.view(), one.view(), one.view(), roughness, 1.0).unwrap_err().to_string()
        };
        assert!(call(&map, 0.01).starts_with("roughness must be from 0.1 to 1"));
        assert!(call(&(&map * -1.0), 0.5).starts_with("radiance must not be negative; row 0"));
        assert!(call(&Array3::ones((1, 8, 3)), 0.5).starts_with("radiance must have the shape"));
    }
}
