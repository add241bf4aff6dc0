//! The moments of a light: sums over its pixels, and the properties that follow from them.
//!
//! For the luminance Y, the direction d and the solid angle dw of each pixel:
//!
//! ```text
//!   flux         F = sum Y dw             direction    v / |v|,   v = sum Y d dw
//!   RGB flux         sum L dw             solid angle  F^2 / Q,   Q = sum Y^2 dw
//!   second moments   S = sum Y d d^T dw   elongation   from the eigenvalues of S across the direction
//! ```
//!
//! A pixel adds its own width to the second moments, dw / 12 in every direction, so that a light of one
//! pixel is round.
//!
//! The solid angle is that of a light of constant radiance with the same `F` and `Q`, so it needs no outline. But
//! pixels that the edge cuts make it too large: see [`LightMoments::solid_angle`]. Moments add up, so lights can be
//! merged without the map.

use std::cmp::Ordering;
use std::f64::consts::PI;

use glam::DVec3;

use crate::kernels::detect::clipping::{Ceiling, Top};
use crate::kernels::image::luminance_f32;
use crate::kernels::sphere::{band_heights, tangents};

/// Least coverage of a pixel that counts; smaller values are noise.
const LEAST_COVERAGE: f32 = 0.05;
/// Pixels of this fraction of a light's peak and more are its top.
const TOP: f64 = 0.99;

/// The moments of one light.
#[derive(Clone, Debug, Default)]
pub struct LightMoments {
    /// Integral of the luminance.
    pub flux: f64,
    /// Integral of the radiance, RGB.
    pub flux_rgb: [f64; 3],
    /// Integral of the radiance above the local background, RGB.
    above_background: [f64; 3],
    /// Integral of the coverage.
    covered: f64,
    /// Largest luminance of a pixel.
    pub peak: f64,
    /// Its largest sample, and the number of pixels that hold it.
    pub largest: Top,
    flux_vector: DVec3,
    /// Second moments: the diagonal, and the entries xy, yz, zx.
    second: [DVec3; 2],
    /// Second moments of the pixels' own widths.
    width_squared: f64,
    /// `sum Y^2 dw`, `sum Y^3 dw`.
    luminance_squared: f64,
    luminance_cubed: f64,
    top: DVec3,
}

impl LightMoments {
    /// A light of this peak, with no pixel added yet.
    pub fn of_peak(luminance: f32) -> Self {
        Self { peak: f64::from(luminance), ..Self::default() }
    }

    /// A point.
    #[cfg(test)]
    pub fn towards(direction: DVec3, flux: f64) -> Self {
        Self { flux, flux_vector: direction * flux, ..Self::default() }
    }

    /// The order of lights: most flux first.
    pub fn most_flux_first(one: &Self, other: &Self) -> Ordering {
        other.flux.total_cmp(&one.flux)
    }

    /// Flux centroid, a unit vector.
    pub fn direction(&self) -> DVec3 {
        self.flux_vector.normalize_or(self.top.normalize_or(DVec3::Y))
    }

    /// Move the flux centroid to another `direction`, a unit vector.
    pub fn turn_to(&mut self, direction: DVec3) {
        self.flux_vector = direction * self.flux_vector.length();
    }

    /// Subtract the radiance of the local background from the irradiance of the light.
    pub fn subtract(&mut self, background: [f64; 3]) {
        self.above_background = [0, 1, 2].map(|c| (self.flux_rgb[c] - background[c] * self.covered).max(0.0));
    }

    /// RGB irradiance at normal incidence, above the local background: `|int (L - B) w dw|`.
    ///
    /// A wide light contributes less than the integral of its radiance, because its rays arrive at an angle. That factor
    /// is `|v| / F` of the luminance, so it is exact for a light of one colour.
    pub fn irradiance(&self) -> [f64; 3] {
        let factor = self.flux_vector.length() / self.flux;
        self.above_background.map(|value| if self.flux > 0.0 { factor * value } else { 0.0 })
    }

    /// Unit vector towards the centroid of the pixels at the peak.
    pub fn peak_direction(&self) -> DVec3 {
        self.top.normalize_or(self.direction())
    }

    /// True if its samples are cut off at this ceiling.
    pub fn is_clipped(&self, ceiling: Ceiling) -> bool {
        self.largest.is_clipped(ceiling)
    }

    /// Solid angle in steradians, of a light of constant luminance Y whose edge cuts pixels of the side a.
    ///
    /// Across an edge of the length l, the coverage of pixels grows from 0 to 1 evenly. With T for the sum of cubes,
    ///
    /// ```text
    ///   F = Y W      Q = Y^2 (W - l a / 6)      T = Y^3 (W - l a / 4)      so  F Y^2 - 3 Q Y + 2 T = 0
    /// ```
    ///
    /// The smaller solution Y is the light's. If it is not near the peak, the luminance varies, and W is F^2 / Q, as it
    /// is if no pixel is cut. W is at least the solid angle of a disc with the same F and Q, see [`without_edge`].
    pub fn solid_angle(&self) -> f64 {
        /// Least fraction of the peak. Discs of at least 1.4 pixels have 0.93 and more at any position, discs of 0.8
        /// pixels 0.87 and more. Evenly distributed noise of a fourth of the mean has 0.86 and less.
        const NEAR: f64 = 0.87;
        let (flux, square, cube) = (self.flux, self.luminance_squared, self.luminance_cubed);
        let plain = flux * flux / square;
        let root = (9.0 * square * square - 8.0 * flux * cube).max(0.0).sqrt();
        let luminance = (3.0 * square - root) / (2.0 * flux);
        if luminance < NEAR * self.peak {
            return plain;
        }
        (flux / luminance).max(without_edge(plain, self.pixel())).min(plain)
    }

    /// Solid angle of a pixel: the mean over the light.
    fn pixel(&self) -> f64 {
        12.0 * self.width_squared / self.flux
    }

    /// Length over breadth, and the unit vector along the light.
    ///
    /// The eigenvalues of the symmetric 2 x 2 matrix `(a b; b c)` of the second moments across the
    /// direction are `m +- r`, with `m = (a + c) / 2` and `r = hypot((a - c) / 2, b)`; the
    /// larger one's eigenvector has the angle `atan2(b, (a - c) / 2) / 2`.
    pub fn elongation(&self) -> (f64, DVec3) {
        // Project the second moments onto the tangent plane.
        let [right, up] = tangents(self.direction());
        let a = self.second_moment(right, right) + self.width_squared;
        let b = self.second_moment(right, up);
        let c = self.second_moment(up, up) + self.width_squared;
        // Take the eigenvalues, and the eigenvector of the larger one.
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
        let sum = |one: [f64; 3], other: [f64; 3]| [0, 1, 2].map(|c| one[c] + other[c]);
        // Keep the top of the brighter light, and that of the dimmer one if it is as bright.
        let (brighter, dimmer) = if self.peak >= other.peak { (self, other) } else { (other, self) };
        let shares_top = dimmer.peak >= TOP * brighter.peak;
        let top = if shares_top { dimmer.top } else { DVec3::ZERO };
        // Add all other sums.
        Self {
            flux: self.flux + other.flux,
            flux_rgb: sum(self.flux_rgb, other.flux_rgb),
            above_background: sum(self.above_background, other.above_background),
            covered: self.covered + other.covered,
            peak: brighter.peak,
            largest: self.largest.and(other.largest),
            flux_vector: self.flux_vector + other.flux_vector,
            second: [self.second[0] + other.second[0], self.second[1] + other.second[1]],
            width_squared: self.width_squared + other.width_squared,
            luminance_squared: self.luminance_squared + other.luminance_squared,
            luminance_cubed: self.luminance_cubed + other.luminance_cubed,
            top: brighter.top + top,
        }
    }

    /// Add the covered pixels of a row.
    ///
    /// For `d = (sin phi sin theta, cos theta, -cos phi sin theta)` each sum is one over the azimuths, times a factor
    /// of the row.
    pub fn add(&mut self, pixels: &[[f32; 3]], columns: &[ColumnAngle], row: RowAngle, edge: LightEdge) {
        let RowAngle { sin, cos, band } = row;
        // Sum over the azimuths.
        let [mut flux, mut flux_sin, mut flux_cos, mut sin_sin, mut sin_cos] = [0.0; 5];
        let mut top = DVec3::ZERO;
        for (&pixel, column) in pixels.iter().zip(columns) {
            let y = luminance_f32(pixel);
            let Some([coverage, fraction]) = edge.coverage_and_fraction(y) else { continue };
            let (y, whole) = (f64::from(y), column.width * band);
            let solid_angle = f64::from(fraction) * whole;
            let own = y * solid_angle;
            flux += own;
            flux_sin += own * column.sin;
            flux_cos += own * column.cos;
            sin_sin += own * column.sin * column.sin;
            sin_cos += own * column.sin * column.cos;
            for (sum, value) in self.flux_rgb.iter_mut().zip(pixel) {
                *sum += f64::from(value) * solid_angle;
            }
            self.covered += f64::from(coverage) * whole;
            self.width_squared += own * solid_angle / 12.0;
            self.luminance_squared += own * y;
            self.luminance_cubed += own * y * y;
            if y >= TOP * self.peak {
                top += solid_angle * DVec3::new(column.sin, 1.0, -column.cos);
            }
        }
        // Add to the moments of order 0, 1 and 2.
        let [flux_sin, flux_cos] = [flux_sin, flux_cos].map(|sum| sin * sum);
        let [sin_sin, sin_cos] = [sin_sin, sin_cos].map(|sum| sin * sin * sum);
        self.flux += flux;
        self.flux_vector += DVec3::new(flux_sin, flux * cos, -flux_cos);
        self.second[0] += DVec3::new(sin_sin, flux * cos * cos, flux * sin * sin - sin_sin);
        self.second[1] += DVec3::new(flux_sin * cos, -flux_cos * cos, -sin_cos);
        self.top += top * DVec3::new(sin, cos, sin);
    }
}

/// Azimuth of a column of the map.
#[derive(Clone, Copy, Debug)]
pub struct ColumnAngle {
    width: f64,
    sin: f64,
    cos: f64,
}

impl ColumnAngle {
    /// The column between two azimuths.
    pub fn new(edges: &[f64]) -> Self {
        let (sin, cos) = (0.5 * (edges[0] + edges[1])).sin_cos();
        Self { width: edges[1] - edges[0], sin, cos }
    }
}

/// Polar angle of a row of the map.
#[derive(Clone, Copy, Debug)]
pub struct RowAngle {
    sin: f64,
    cos: f64,
    /// `cos theta_top - cos theta_bottom`.
    band: f64,
}

impl RowAngle {
    /// The row between two polar angles.
    pub fn new(edges: &[f64]) -> Self {
        let (sin, cos) = (0.5 * (edges[0] + edges[1])).sin_cos();
        Self { sin, cos, band: band_heights(edges)[0] }
    }
}

/// Luminance on both sides of a light's edge, which determines the coverage of the pixels that the edge cuts.
///
/// For the peak `P` and the background `B`, the light covers the fraction `c = (y - B) / (P - B)` of a pixel of the
/// luminance `y`, and owns the fraction `1 - (1 - c) B / y` of its radiance.
#[derive(Clone, Copy, Debug)]
pub struct LightEdge {
    /// Peak of the light.
    pub peak: f32,
    /// Local background.
    pub background: f32,
}

impl LightEdge {
    /// Coverage of a pixel of this luminance, and the light's fraction of its radiance; `None` for noise.
    fn coverage_and_fraction(self, y: f32) -> Option<[f32; 2]> {
        let coverage = ((y - self.background) / (self.peak - self.background)).min(1.0);
        let fraction = 1.0 - (1.0 - coverage) * self.background / y;
        (coverage >= LEAST_COVERAGE).then_some([coverage, fraction])
    }
}

/// Solid angle of a disc that has this F^2 / Q, `plain`, in pixels of the solid angle `pixel`.
///
/// For the radius r of the disc, and R of a disc of the solid angle `plain`, `R^2 = r^2 / (1 - a / 3r)`. This is a
/// cubic equation for r; the code has its largest root (Viete). A disc smaller than a pixel has none, and gets the
/// smallest solid angle with a root.
fn without_edge(plain: f64, pixel: f64) -> f64 {
    let cosine = -(0.75 * PI * pixel / plain).sqrt();
    let radius = 2.0 / 3.0_f64.sqrt() * (cosine.max(-1.0).acos() / 3.0).cos();
    plain * radius * radius
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The light of a row of pixels, by the row and by the formulas for each pixel.
    fn both_ways(pixels: &[[f32; 3]], theta: f64) -> [LightMoments; 2] {
        let band = 0.02;
        let (peak, background) = (10.0_f32, 1.0_f32);
        let edges: Vec<f64> = (0..=pixels.len()).map(|i| 0.03 * i as f64 + 2.0).collect();
        let columns: Vec<ColumnAngle> = edges.windows(2).map(ColumnAngle::new).collect();
        let row = RowAngle { sin: theta.sin(), cos: theta.cos(), band };
        let mut light = LightMoments::of_peak(peak);
        light.add(pixels, &columns, row, LightEdge { peak, background });
        let mut plain = LightMoments::of_peak(peak);
        for (pixel, edge) in pixels.iter().zip(edges.windows(2)) {
            let y = crate::kernels::image::luminance(pixel.map(f64::from));
            let coverage = ((y - 1.0) / 9.0).min(1.0);
            if coverage >= 0.05 {
                let solid_angle = band * 0.03 * (y - (1.0 - coverage)) / y;
                let towards = crate::kernels::sphere::direction(theta, 0.5 * (edge[0] + edge[1]));
                plain.add_pixel(pixel.map(f64::from), y, towards, solid_angle);
                plain.covered += band * 0.03 * coverage;
            }
        }
        [light, plain]
    }

    impl LightMoments {
        fn add_pixel(&mut self, rgb: [f64; 3], y: f64, d: DVec3, solid_angle: f64) {
            let flux = y * solid_angle;
            self.flux += flux;
            self.flux_rgb.iter_mut().zip(rgb).for_each(|(sum, value)| *sum += value * solid_angle);
            self.flux_vector += flux * d;
            self.second[0] += flux * d * d;
            self.second[1] += flux * DVec3::new(d.x * d.y, d.y * d.z, d.z * d.x);
            self.width_squared += flux * solid_angle / 12.0;
            self.luminance_squared += flux * y;
            self.luminance_cubed += flux * y * y;
            if y >= TOP * self.peak {
                self.top += solid_angle * d;
            }
        }
    }

    proptest! {
        #[test]
        fn a_row_adds_the_sums_of_its_pixels(
            levels in prop::collection::vec(prop_oneof![0.0..9.0_f32, Just(9.9999)], 1..40),
            theta in 0.1..3.0,
        ) {
            let pixels: Vec<[f32; 3]> = levels.iter().map(|&level| [level, level, 1.001 * level]).collect();
            let [light, plain] = both_ways(&pixels, theta);
            let whole = plain.flux + plain.luminance_squared + plain.luminance_cubed;
            let near = |one: f64, other: f64| (one - other).abs() <= 1e-6 * whole + 1e-12;
            let numbers = |light: &LightMoments| {
                let mut all = vec![light.flux, light.width_squared, light.luminance_squared, light.luminance_cubed];
                all.extend(light.flux_rgb);
                all.push(light.covered);
                let vectors = [light.flux_vector, light.second[0], light.second[1], light.top];
                all.extend(vectors.iter().flat_map(DVec3::to_array));
                all
            };
            for (sum, expected) in numbers(&light).into_iter().zip(numbers(&plain)) {
                prop_assert!(near(sum, expected), "{sum} {expected}");
            }
        }
    }
}
