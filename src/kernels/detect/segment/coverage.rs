//! Coverage: the share of each pixel that a light covers.
//!
//! A light of the peak `P` that covers the share `c` of a pixel, against the background `B`, gives it the
//! luminance
//!
//! ```text
//!   y = B + c (P - B),      of which      y - (1 - c) B      is the light's
//! ```
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::ops::Range;

use crate::kernels::image::luminance_f32;

/// A pixel counts from this coverage on: less is noise.
const LEAST_COVERAGE: f32 = 0.05;

/// For columns side by side, each width, and of each azimuth the sine, the cosine, the sine's square and
/// the product of both.
#[derive(Default)]
pub struct ColumnAngles<Values> {
    pub width: Values,
    pub sin: Values,
    pub cos: Values,
    pub sin_sin: Values,
    pub sin_cos: Values,
}

impl ColumnAngles<Vec<f64>> {
    /// Add the column between these azimuths. Sine and cosine are left 0 where no light covers it.
    pub fn push(&mut self, edges: &[f64], is_covered: bool) {
        let (sin, cos) = if is_covered { (0.5 * (edges[0] + edges[1])).sin_cos() } else { (0.0, 0.0) };
        self.width.push(edges[1] - edges[0]);
        self.sin.push(sin);
        self.cos.push(cos);
        self.sin_sin.push(sin * sin);
        self.sin_cos.push(sin * cos);
    }

    pub fn at(&self, range: Range<usize>) -> ColumnAngles<&[f64]> {
        let Self { width, sin, cos, sin_sin, sin_cos } = self;
        let [width, sin, cos, sin_sin, sin_cos] =
            [width, sin, cos, sin_sin, sin_cos].map(|of| &of[range.clone()]);
        ColumnAngles { width, sin, cos, sin_sin, sin_cos }
    }
}

/// Covered pixels of a row, with one list for each quantity, as dot products want them.
#[derive(Default)]
pub struct CoveredPixels {
    pub rgb: [Vec<f32>; 3],
    pub luminance: Vec<f32>,
    /// The light's share of each pixel, in steradians.
    pub solid_angle: Vec<f64>,
    /// Covered solid angle of each pixel, in steradians.
    pub covered: Vec<f64>,
    /// Luminance times solid angle.
    pub flux: Vec<f64>,
    /// Luminance times flux.
    pub square: Vec<f64>,
    /// 1 for each pixel at the peak, 0 for any other; and the solid angles of those at the peak.
    pub top: (Vec<f32>, Vec<f64>),
}

impl CoveredPixels {
    /// Fill the lists anew, for pixels of a row of the height `band`.
    #[inline(always)]
    pub fn refill(&mut self, pixels: &[[f32; 3]], widths: &[f64], band: f64, peak: f32, background: f32) {
        for (channel, values) in self.rgb.iter_mut().enumerate() {
            refill(values, pixels.iter().map(|pixel| pixel[channel]));
        }
        refill(&mut self.luminance, pixels.iter().copied().map(luminance_f32));
        let coverage = coverage(peak, background);
        let levels = self.luminance.iter().zip(widths);
        refill(&mut self.covered, levels.map(|(&y, width)| f64::from(coverage(y)) * width * band));
        let share = share(peak, background);
        let levels = self.luminance.iter().zip(widths);
        refill(&mut self.solid_angle, levels.map(|(&y, width)| f64::from(share(y)) * width * band));
        let levels = self.luminance.iter().zip(&self.solid_angle);
        refill(&mut self.flux, levels.map(|(&y, solid_angle)| f64::from(y) * solid_angle));
        let levels = self.luminance.iter().zip(&self.flux);
        refill(&mut self.square, levels.map(|(&y, flux)| f64::from(y) * flux));
    }

    /// Find the pixels of the luminance `least` and more, if there are any.
    #[inline(always)]
    pub fn find_top(&mut self, least: f64) -> bool {
        let is_top = self.luminance.iter().map(|&y| f64::from(y) >= least);
        let found = is_top.clone().any(|is_top| is_top);
        if found {
            refill(&mut self.top.0, is_top.map(|is_top| if is_top { 1.0 } else { 0.0 }));
            let flags = self.top.0.iter().zip(&self.solid_angle);
            refill(&mut self.top.1, flags.map(|(&flag, solid_angle)| f64::from(flag) * solid_angle));
        }
        found
    }
}

/// The part of a pixel that the light covers, from the pixel's luminance.
#[inline(always)]
fn coverage(peak: f32, background: f32) -> impl Fn(f32) -> f32 {
    move |y| {
        let coverage = ((y - background) / (peak - background)).min(1.0);
        if coverage >= LEAST_COVERAGE { coverage } else { 0.0 }
    }
}

/// The light's share of a pixel's radiance, from the pixel's luminance.
#[inline(always)]
fn share(peak: f32, background: f32) -> impl Fn(f32) -> f32 {
    move |y| {
        let coverage = ((y - background) / (peak - background)).min(1.0);
        let share = 1.0 - (1.0 - coverage) * background / y;
        if coverage >= LEAST_COVERAGE { share } else { 0.0 }
    }
}

#[inline(always)]
fn refill<T>(values: &mut Vec<T>, new: impl Iterator<Item = T>) {
    values.clear();
    values.extend(new);
}
