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
//! A pixel adds its own width to the second moments, dw / 12 in every direction, so that a light of one
//! pixel is round.
//!
//! The solid angle is that of a light of one radiance which has the same `F` and the same `sum Y^2 dw`:
//! no outline needs to be drawn. Sums of lights add up, so lights can be merged without the map.

use glam::DVec3;
use ndarray::ArrayView3;
use rayon::prelude::*;

use super::components::Regions;
use super::summary::Summary;
use crate::kernels::image::LUMINANCE;
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
    /// Second moments: the diagonal, and the entries xy, yz, zx.
    second: [DVec3; 2],
    /// Second moments of the pixels' own widths.
    width_squared: f64,
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
        let a = self.second_moment(right, right) + self.width_squared;
        let b = self.second_moment(right, up);
        let c = self.second_moment(up, up) + self.width_squared;
        let (middle, radius) = (0.5 * (a + c), (0.5 * (a - c)).hypot(b));
        let angle = 0.5 * b.atan2(0.5 * (a - c));
        let along = right * angle.cos() + up * angle.sin();
        (((middle + radius) / (middle - radius).max(1e-6 * middle)).sqrt(), along)
    }

    /// `v^T S w`.
    fn second_moment(&self, v: DVec3, w: DVec3) -> f64 {
        let [diagonal, off] = self.second;
        let crossed = v * DVec3::new(w.y, w.z, w.x) + w * DVec3::new(v.y, v.z, v.x);
        diagonal.dot(v * w) + off.dot(crossed)
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
            second: [self.second[0] + other.second[0], self.second[1] + other.second[1]],
            width_squared: self.width_squared + other.width_squared,
            luminance_squared: self.luminance_squared + other.luminance_squared,
            top: brighter.top + top,
        }
    }

    /// Add a pixel of the luminance `y`, of which the light covers `solid_angle`.
    fn add(&mut self, rgb: [f32; 3], y: f64, towards: DVec3, solid_angle: f64) {
        let flux = y * solid_angle;
        self.flux += flux;
        for (sum, value) in self.irradiance.iter_mut().zip(rgb) {
            *sum += f64::from(value) * solid_angle;
        }
        let pull = towards * flux;
        self.flux_vector += pull;
        self.second[0] += pull * towards;
        self.second[1] += pull * DVec3::new(towards.y, towards.z, towards.x);
        self.width_squared += flux * solid_angle / 12.0;
        self.luminance_squared += y * flux;
        if y >= TOP * self.peak {
            self.top += solid_angle * towards;
            self.top_pixels += 1;
        }
    }
}

/// Working pixels that are summed at once.
const PIXELS_OF_A_PART: usize = 1024;
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
    let radiance = radiance.as_standard_layout();
    let pixels = radiance.as_slice().map_or(&[][..], |samples| samples.as_chunks::<3>().0);
    let map = Map::new(pixels, radiance.dim(), registration, summary);
    let lights = regions.pixels.par_iter().zip(backgrounds);
    lights.map(|(region, &background)| map.measure(region, background)).collect()
}

/// The map's pixels behind the working image's.
struct Map<'a> {
    pixels: &'a [[f32; 3]],
    height: usize,
    width: usize,
    block: usize,
    working_columns: usize,
    /// Sine and cosine of the polar angle, and `cos theta_top - cos theta_bottom`, of each row.
    rows: Vec<[f64; 3]>,
    /// Width, sine and cosine of the azimuth of each column.
    columns: Vec<[f64; 3]>,
}

impl<'a> Map<'a> {
    fn new(
        pixels: &'a [[f32; 3]],
        (height, width, _): (usize, usize, usize),
        registration: Registration,
        summary: &Summary,
    ) -> Self {
        let middle = |edge: &[f64]| (0.5 * (edge[0] + edge[1])).sin_cos();
        let theta = registration.theta_edges(height);
        let phi = registration.phi_edges(width);
        let rows = theta.windows(2).map(middle).zip(band_heights(&theta));
        let columns = phi.windows(2).map(|edge| (middle(edge), edge[1] - edge[0]));
        let (rows, columns) = rayon::join(
            || rows.map(|((sin, cos), band)| [sin, cos, band]).collect(),
            || columns.map(|((sin, cos), width)| [width, sin, cos]).collect(),
        );
        Self { pixels, height, width, block: summary.block, working_columns: summary.size.1, rows, columns }
    }

    /// Part by part: large lights keep all threads busy, and any number of threads adds in one order.
    fn measure(&self, region: &[u32], background: f64) -> Light {
        let parts = region.par_chunks(PIXELS_OF_A_PART);
        let peak = parts.clone().map(|part| self.peak(part)).reduce(|| 0.0, f64::max);
        let lights: Vec<Light> = parts.map(|part| self.sum(part, peak, background)).collect();
        let dark = Light { peak, ..Light::default() };
        lights.iter().fold(dark, |sum, part| sum.and(part))
    }

    fn peak(&self, part: &[u32]) -> f64 {
        let mut peak = 0.0_f32;
        self.visit(part, |_, _, pixel| peak = peak.max(luminance(pixel)));
        f64::from(peak)
    }

    fn sum(&self, part: &[u32], peak: f64, background: f64) -> Light {
        let mut light = Light { peak, ..Light::default() };
        let per_cover = 1.0 / (peak - background);
        self.visit(part, |row, column, pixel| {
            let y = f64::from(luminance(pixel));
            let coverage = ((y - background) * per_cover).min(1.0);
            if coverage >= LEAST_COVERAGE {
                let share = 1.0 - (1.0 - coverage) * background / y;
                let (towards, solid_angle) = self.pixel(row, column);
                light.add(pixel, y, towards, share * solid_angle);
            }
        });
        light
    }

    fn visit(&self, region: &[u32], mut seen: impl FnMut(usize, usize, [f32; 3])) {
        for &index in region {
            let (row, column) =
                (index as usize / self.working_columns, index as usize % self.working_columns);
            let columns = column * self.block..((column + 1) * self.block).min(self.width);
            for row in row * self.block..((row + 1) * self.block).min(self.height) {
                let pixels = &self.pixels[row * self.width..][columns.clone()];
                for (column, &pixel) in columns.clone().zip(pixels) {
                    seen(row, column, pixel);
                }
            }
        }
    }

    /// Direction and solid angle of a pixel.
    fn pixel(&self, row: usize, column: usize) -> (DVec3, f64) {
        let [sin_theta, cos_theta, band] = self.rows[row];
        let [width, sin_phi, cos_phi] = self.columns[column];
        (DVec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta), band * width)
    }
}

fn luminance([red, green, blue]: [f32; 3]) -> f32 {
    let weights = LUMINANCE.map(|weight| weight as f32);
    weights[0] * red + weights[1] * green + weights[2] * blue
}
