//! Which part of each pixel of a row a light covers.
//!
//! A pixel of the luminance `y` that a light of the peak `P` covers in the share `c`, before the background
//! `B`, has
//!
//! ```text
//!   y = B + c (P - B),      of which      y - (1 - c) B      is the light's
//! ```
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::ops::Range;

use crate::kernels::image::LUMINANCE;

/// A pixel counts if the light covers this share of it: less is noise.
const LEAST_COVERAGE: f32 = 0.05;

/// Of columns side by side: width, and of the azimuth sine and cosine, the sine's square, the product of both.
#[derive(Default)]
pub struct Columns<Values> {
    pub width: Values,
    pub sin: Values,
    pub cos: Values,
    pub sin_sin: Values,
    pub sin_cos: Values,
}

impl Columns<Vec<f64>> {
    /// One more column between these azimuths; of one that no light covers the azimuth is not needed.
    pub fn push(&mut self, edges: &[f64], is_covered: bool) {
        let (sin, cos) = if is_covered { (0.5 * (edges[0] + edges[1])).sin_cos() } else { (0.0, 0.0) };
        self.width.push(edges[1] - edges[0]);
        self.sin.push(sin);
        self.cos.push(cos);
        self.sin_sin.push(sin * sin);
        self.sin_cos.push(sin * cos);
    }

    pub fn at(&self, range: Range<usize>) -> Columns<&[f64]> {
        let Self { width, sin, cos, sin_sin, sin_cos } = self;
        let [width, sin, cos, sin_sin, sin_cos] =
            [width, sin, cos, sin_sin, sin_cos].map(|of| &of[range.clone()]);
        Columns { width, sin, cos, sin_sin, sin_cos }
    }
}

/// Pixels of a row, one list for each quantity: what is summed stands side by side.
#[derive(Default)]
pub struct Covered {
    pub rgb: [Vec<f32>; 3],
    pub luminance: Vec<f32>,
    /// What the light covers of each pixel, in steradians.
    pub solid_angle: Vec<f64>,
    /// Luminance times solid angle.
    pub flux: Vec<f64>,
}

impl Covered {
    /// The same lists for other pixels, in a row of the height `band`.
    #[inline(always)]
    pub fn refill(&mut self, pixels: &[[f32; 3]], widths: &[f64], band: f64, peak: f32, background: f32) {
        for (channel, values) in self.rgb.iter_mut().enumerate() {
            refill(values, pixels.iter().map(|pixel| pixel[channel]));
        }
        refill(&mut self.luminance, pixels.iter().copied().map(luminance));
        let share = share(peak, background);
        let lit = self.luminance.iter().zip(widths);
        refill(&mut self.solid_angle, lit.map(|(&y, width)| f64::from(share(y)) * width * band));
        let lit = self.luminance.iter().zip(&self.solid_angle);
        refill(&mut self.flux, lit.map(|(&y, solid_angle)| f64::from(y) * solid_angle));
    }
}

/// The light's share of a pixel, by the pixel's luminance.
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

#[inline(always)]
pub fn luminance([red, green, blue]: [f32; 3]) -> f32 {
    let weights = LUMINANCE.map(|weight| weight as f32);
    weights[0] * red + weights[1] * green + weights[2] * blue
}
