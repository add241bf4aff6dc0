//! The glow of a light: the bright place that it stands in.
//!
//! Detection takes a bright place that is connected to a brighter light for a part of it, down to the threshold.
//! With that light gone, the clouds around a sun or the dim part of a softbox would be found in its stead. But they are
//! no part of the light, and stand elsewhere. So only what is too bright to stay is taken with the light. Of a pixel
//! that is connected to it, of the luminance `y` in units of the threshold, there remains
//!
//! ```text
//!   y' = 2 - 1/4 / (y - 1)        above y = 3/2
//! ```
//!
//! which goes on smoothly from `y`, keeps clouds apart, and stays below 2, while a light rises to 2.25. None is found
//! where the glow ends before [`FARTHEST`], and the threshold of the rest is not much lower.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::f64::consts::PI;

use super::working::Working;
use crate::interrupt;

/// No light: they are counted from 1, so that memory which was never written holds none.
pub const NONE: u32 = 0;
/// Angle from the rings of a light to the end of its glow, at most, in radians: 45 degrees. The sky above a city may
/// be one bright place, and no direction stands for all of it.
const FARTHEST: f64 = PI / 4.0;

/// The bright pixels that are connected to a light, each with the light that is the fewest steps away, counted from 1;
/// those are written into `light_of` as well.
pub fn glow(working: &Working<'_>, light_of: &mut [u32], threshold: f64) -> Vec<(u32, u32)> {
    let (threshold, farthest) = (threshold as f32, 2.0 * (FARTHEST / 2.0).sin());
    // No pixel is read twice: its mean takes time.
    let mut is_dark = vec![false; light_of.len()];
    // Each pixel knows the pixel of a light from which it was reached.
    let lights = (0..light_of.len()).filter(|&pixel| light_of[pixel] != NONE);
    let mut front: Vec<(usize, usize)> = lights.map(|pixel| (pixel, pixel)).collect();
    let mut glow = Vec::new();
    // Take one step from all lights at a time.
    while !front.is_empty() {
        interrupt::check();
        let mut next = Vec::new();
        for (pixel, source) in front {
            let light = light_of[source];
            for other in working.around(pixel) {
                let is_near = || working.centre(other).distance(working.centre(source)) < farthest;
                if light_of[other] != NONE || is_dark[other] || !is_near() {
                    continue;
                }
                is_dark[other] = working.luminance(other) <= threshold;
                if !is_dark[other] {
                    light_of[other] = light;
                    next.push((other, source));
                    glow.push((other as u32, light));
                }
            }
        }
        front = next;
    }
    glow
}

/// Share that is left of a pixel of the glow.
#[inline(always)]
pub fn share_left(luminance: f32, threshold: f32) -> f32 {
    let excess = (luminance / threshold).max(1.5);
    (2.0 - 0.25 / (excess - 1.0)) / excess
}
