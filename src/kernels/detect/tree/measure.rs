//! What a light sends, summed over the map's own pixels.
//!
//! Everything that is said of a light follows from a few sums over its pixels, with the luminance Y,
//! the direction d and the solid angle dw of each:
//!
//! ```text
//!   flux         F = sum Y dw             direction    v / |v|,   v = sum Y d dw
//!   irradiance       sum L dw  (RGB)      solid angle  F^2 / sum Y^2 dw
//!   second moments   S = sum Y d d^T dw   elongation   from the eigenvalues of S across the direction
//! ```
//!
//! The solid angle is that of a light of one radiance which has the same `F` and the same `sum Y^2 dw`:
//! no outline needs to be drawn. Sums of lights add up, so lights can be merged without the map.

use glam::{DMat3, DVec3};
use ndarray::ArrayView3;
use rayon::prelude::*;

use super::components::Regions;
use super::summary::Summary;
use crate::kernels::image::luminance;
use crate::kernels::sphere::{Registration, band_heights, tangents};

/// Pixels this close to a light's peak are its top.
const TOP: f64 = 0.99;

/// The sums over one light.
#[derive(Clone, Debug, Default)]
pub struct Light {
    /// Integral of the luminance.
    pub flux: f64,
    /// Integral of the radiance: RGB irradiance at normal incidence.
    pub irradiance: [f64; 3],
    /// Largest luminance of a pixel.
    pub peak: f64,
    /// Pixels at the peak.
    pub top_pixels: usize,
    flux_vector: DVec3,
    second: DMat3,
    luminance_squared: f64,
    top: DVec3,
}

impl Light {
    /// Flux centroid, a unit vector.
    pub fn direction(&self) -> DVec3 {
        self.flux_vector.normalize_or(self.top.normalize_or(DVec3::Y))
    }

    /// Unit vector towards the middle of the pixels at the peak.
    pub fn peak_direction(&self) -> DVec3 {
        self.top.normalize_or(self.direction())
    }

    /// In steradians.
    pub fn solid_angle(&self) -> f64 {
        self.flux * self.flux / self.luminance_squared
    }

    /// Length over breadth, and the unit vector along the light.
    ///
    /// The eigenvalues of the symmetric 2 x 2 matrix `(a b; b c)` of the second moments across the
    /// direction are `m +- r`, with `m = (a + c) / 2` and `r = hypot((a - c) / 2, b)`; the
    /// larger one's eigenvector has the angle `atan2(b, (a - c) / 2) / 2`.
    pub fn elongation(&self) -> (f64, DVec3) {
        let [right, up] = tangents(self.direction());
        let a = right.dot(self.second * right);
        let b = right.dot(self.second * up);
        let c = up.dot(self.second * up);
        let (middle, radius) = (0.5 * (a + c), (0.5 * (a - c)).hypot(b));
        let angle = 0.5 * b.atan2(0.5 * (a - c));
        let along = right * angle.cos() + up * angle.sin();
        (((middle + radius) / (middle - radius).max(1e-6 * middle)).sqrt(), along)
    }

    /// Two lights as one.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        let sum = |i: usize| self.irradiance[i] + other.irradiance[i];
        let (brighter, dimmer) = if self.peak >= other.peak { (self, other) } else { (other, self) };
        let shares_top = dimmer.peak >= TOP * brighter.peak;
        let (more, top) = if shares_top { (dimmer.top_pixels, dimmer.top) } else { (0, DVec3::ZERO) };
        Self {
            flux: self.flux + other.flux,
            irradiance: [sum(0), sum(1), sum(2)],
            peak: brighter.peak,
            top_pixels: brighter.top_pixels + more,
            flux_vector: self.flux_vector + other.flux_vector,
            second: self.second + other.second,
            luminance_squared: self.luminance_squared + other.luminance_squared,
            top: brighter.top + top,
        }
    }

    fn add(&mut self, rgb: [f64; 3], y: f64, towards: DVec3, extent: DMat3, solid_angle: f64) {
        let flux = y * solid_angle;
        self.flux += flux;
        for (sum, value) in self.irradiance.iter_mut().zip(rgb) {
            *sum += value * solid_angle;
        }
        self.flux_vector += flux * towards;
        self.second += extent * flux;
        self.luminance_squared += y * flux;
        if y >= TOP * self.peak {
            self.top += solid_angle * towards;
            self.top_pixels += 1;
        }
    }
}

/// A pixel counts if the light covers this share of it: less is noise.
const LEAST_COVERAGE: f64 = 0.05;

/// Measure each region, before its background, in the pixels of the map itself.
pub fn measure(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    summary: &Summary,
    regions: &Regions,
    backgrounds: &[f64],
) -> Vec<Light> {
    let map = Map::new(radiance, registration, summary);
    let lights = regions.pixels.par_iter().zip(backgrounds);
    lights.map(|(pixels, &background)| map.measure(pixels, background)).collect()
}

/// The map's pixels behind the working image's.
struct Map<'a> {
    radiance: ArrayView3<'a, f32>,
    block: usize,
    working_columns: usize,
    /// Height, sine and cosine of the polar angle, and `cos theta_top - cos theta_bottom`, of each row.
    rows: Vec<[f64; 4]>,
    /// Width, sine and cosine of the azimuth of each column.
    columns: Vec<[f64; 3]>,
}

impl<'a> Map<'a> {
    fn new(radiance: ArrayView3<'a, f32>, registration: Registration, summary: &Summary) -> Self {
        let (height, width, _) = radiance.dim();
        let middle = |edge: &[f64]| (0.5 * (edge[0] + edge[1])).sin_cos();
        let theta = registration.theta_edges(height);
        let bands = band_heights(&theta);
        let rows = theta.windows(2).zip(bands).map(|(edge, band)| {
            let (sin, cos) = middle(edge);
            [edge[1] - edge[0], sin, cos, band]
        });
        let columns = registration.phi_edges(width);
        let columns = columns.windows(2).map(|edge| {
            let (sin, cos) = middle(edge);
            [edge[1] - edge[0], sin, cos]
        });
        Self {
            rows: rows.collect(),
            columns: columns.collect(),
            radiance,
            block: summary.block,
            working_columns: summary.size.1,
        }
    }

    fn measure(&self, region: &[u32], background: f64) -> Light {
        // The default matrix of glam is the identity.
        let mut light = Light { second: DMat3::ZERO, ..Light::default() };
        self.visit(region, |rgb, _, _| light.peak = light.peak.max(luminance(rgb)));
        self.visit(region, |rgb, row, column| {
            let y = luminance(rgb);
            let coverage = ((y - background) / (light.peak - background)).min(1.0);
            if coverage >= LEAST_COVERAGE {
                let share = 1.0 - (1.0 - coverage) * background / y;
                let (towards, second, solid_angle) = self.pixel(row, column);
                light.add(rgb, y, towards, second, share * solid_angle);
            }
        });
        light
    }

    fn visit(&self, region: &[u32], mut seen: impl FnMut([f64; 3], usize, usize)) {
        let (height, width, _) = self.radiance.dim();
        for &index in region {
            let (row, column) =
                (index as usize / self.working_columns, index as usize % self.working_columns);
            for row in row * self.block..((row + 1) * self.block).min(height) {
                for column in column * self.block..((column + 1) * self.block).min(width) {
                    let rgb = [0, 1, 2].map(|channel| f64::from(self.radiance[[row, column, channel]]));
                    seen(rgb, row, column);
                }
            }
        }
    }

    /// Direction, second moments and solid angle of a pixel: a light of one pixel is as wide as it.
    fn pixel(&self, row: usize, column: usize) -> (DVec3, DMat3, f64) {
        let [height, sin_theta, cos_theta, band] = self.rows[row];
        let [width, sin_phi, cos_phi] = self.columns[column];
        let towards = DVec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta);
        let down = DVec3::new(sin_phi * cos_theta, -sin_theta, -cos_phi * cos_theta);
        let right = DVec3::new(cos_phi, 0.0, sin_phi);
        let outer = |v: DVec3| DMat3::from_cols(v * v.x, v * v.y, v * v.z);
        let across = width * sin_theta;
        let spread = outer(down) * (height * height / 12.0) + outer(right) * (across * across / 12.0);
        (towards, outer(towards) + spread, band * width)
    }
}
