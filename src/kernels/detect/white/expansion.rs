//! Expanded luminance: what is close to white stands for much more.
//!
//! The curve of Schlick (1994), backwards, with y the share of the end of the picture:
//!
//! ```text
//!   y' = y / (1 + e - y)        e = 0.02:  y' = 50 at white, y in the dark
//!   y  = (1 + e) y' / (1 + y')
//! ```

use rayon::prelude::*;

use super::super::tree::working_image::WorkingImage;

/// White becomes one over this.
const DISTANCE: f32 = 0.02;
/// The threshold is at most the expansion of this share of the end.
const HIGHEST_THRESHOLD: f64 = 0.97;
/// A sphere with more than this share at white has no light that stands out.
const MOSTLY_WHITE: f64 = 0.5;
/// Pixels that are expanded at once.
const PIXELS_AT_ONCE: usize = 1 << 14;

/// The image in expanded luminance; `end` becomes 50.
pub fn expanded(working: &WorkingImage, end: f64) -> WorkingImage {
    let per_end = (1.0 / end) as f32;
    let mut luminance = vec![0.0; working.luminance.len()];
    luminance.par_chunks_mut(PIXELS_AT_ONCE).zip(working.luminance.par_chunks(PIXELS_AT_ONCE)).for_each(
        |(out, luminance)| {
            for (out, &luminance) in out.iter_mut().zip(luminance) {
                let share = luminance * per_end;
                let share = if share < 1.0 { share } else { 1.0 };
                *out = share / (1.0 + DISTANCE - share);
            }
        },
    );
    working.with_luminance(luminance)
}

/// The threshold, but below white where most of the sphere is: a light at white must be able to exceed it.
pub fn below_white(threshold: f64, share_at_white: f64) -> f64 {
    let highest = HIGHEST_THRESHOLD / (1.0 + f64::from(DISTANCE) - HIGHEST_THRESHOLD);
    if share_at_white < MOSTLY_WHITE { threshold.min(highest) } else { threshold }
}

/// The luminance that became `expanded`.
pub fn compressed(expanded: f64, end: f64) -> f64 {
    end * (1.0 + f64::from(DISTANCE)) * expanded / (1.0 + expanded)
}
