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
//! where the glow ends before [`FARTHEST`], and the threshold of the rest is not much lower. Where the map was cut off
//! at a white, `y` is expanded luminance, by which lights are told there.
//!
//! A glow with a sharp rim around most of it is a thing of its own, the rest of a softbox or a panel behind a lamp, and
//! would still be found, for that is how detection tells places of low contrast. It goes with the light as a whole.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::f64::consts::PI;
use std::mem::replace;

use glam::DVec3;

use super::working::{Place, Working};
use crate::interrupt;
use crate::kernels::detect::clipped::{compressed, expand};

/// Largest solid angle of a glow with a sharp rim: a little more than that of a window of 40 degrees.
const LARGEST_PLACE: f64 = 0.5;
/// No light: they are counted from 1, so that memory which was never written holds none.
pub const NONE: u32 = 0;
/// Angle from the rings of a light to the end of its glow, at most, in radians: 45 degrees. The sky above a city may
/// be one bright place, and no direction stands for all of it.
const FARTHEST: f64 = PI / 4.0;
/// Where a rim is sharp, a pixel so many steps from the glow is darker than this share of the threshold.
const STEPS: usize = 3;
const DARK: f32 = 0.6;
/// Share of the rim that is sharp, at least, around a thing of its own. Of the glows of 19 real maps, softboxes and panels
/// have 0.83 and more, lit walls and skies up to 0.70, but for a sky above a city that is larger.
const LEAST_SHARP: f64 = 0.75;
/// Of so many thresholds and less all stays.
const LEAST_DIMMED: f32 = 1.5;

/// The bright pixels that are connected to a light.
#[derive(Clone, Default)]
pub struct Glow {
    pub pixels: Vec<u32>,
    solid_angle: f64,
    /// How many pixels are around it, some steps away, and how many of them are dark.
    around: usize,
    dark: usize,
}

impl Glow {
    /// Whether it is a thing of its own, no larger than a place of low contrast may be.
    pub fn is_a_thing(&self) -> bool {
        self.dark as f64 > LEAST_SHARP * self.around as f64 && self.solid_angle <= LARGEST_PLACE
    }
}

/// The glow of each of so many lights: a pixel is part of that of the light which is the fewest steps away, which is
/// counted from 1 in `light_of`.
pub fn glows(working: &Working<'_>, light_of: &mut [u32], lights: usize, threshold: f32) -> Vec<Glow> {
    let mut glows = vec![Glow::default(); lights];
    // What is outside counts once.
    let mut is_outside = vec![false; light_of.len()];
    let mut around = flood(working, light_of, threshold, &mut glows, &mut is_outside);
    // Look at what is some steps farther out.
    for _ in 1..STEPS {
        let step = |(pixel, light)| working.around(pixel).map(|other| (other, light));
        around = around.into_iter().flat_map(step).collect();
        around.retain(|(pixel, _)| {
            light_of[pixel.index] == NONE && !replace(&mut is_outside[pixel.index], true)
        });
    }
    for (pixel, light) in around {
        let glow = &mut glows[light as usize - 1];
        glow.around += 1;
        glow.dark += usize::from(working.luminance(pixel) < DARK * threshold);
    }
    glows
}

/// Take one step from all lights at a time, as long as there are bright pixels; the first pixels outside, each with the
/// light of the glow that it is beside.
fn flood(
    working: &Working<'_>,
    light_of: &mut [u32],
    threshold: f32,
    glows: &mut [Glow],
    is_outside: &mut [bool],
) -> Vec<(Place, u32)> {
    let farthest = (2.0 * (FARTHEST / 2.0).sin()).powi(2);
    // Each pixel knows the middle of the pixel of a light from which it was reached.
    let is_of_light = |pixel: usize| light_of[pixel] != NONE;
    let on_rim = |&pixel: &usize| is_of_light(pixel) && !working.is_inside(pixel, is_of_light);
    let members = (0..light_of.len()).filter(on_rim).map(|pixel| working.place(pixel));
    let mut front: Vec<(Place, DVec3)> = members.map(|pixel| (pixel, working.centre(pixel))).collect();
    let (mut rim, mut is_first) = (Vec::new(), true);
    while !front.is_empty() {
        interrupt::check();
        let mut next = Vec::new();
        for (pixel, source) in front {
            let light = light_of[pixel.index];
            let glow = &mut glows[light as usize - 1];
            for other in working.around(pixel) {
                let is_near = || working.centre(other).distance_squared(source) < farthest;
                if light_of[other.index] != NONE || is_outside[other.index] || !is_near() {
                    continue;
                }
                if working.luminance(other) > threshold {
                    light_of[other.index] = light;
                    next.push((other, source));
                    glow.pixels.push(other.index as u32);
                    glow.solid_angle += working.solid_angle(other);
                } else {
                    is_outside[other.index] = true;
                    rim.extend((!is_first).then_some((other, light)));
                }
            }
        }
        (front, is_first) = (next, false);
    }
    rim
}

/// What counts as bright.
#[derive(Clone, Copy)]
pub struct Bright {
    /// Luminance above which a place is bright.
    pub threshold: f32,
    /// Luminance at which the map was cut off.
    pub end: Option<f32>,
}

impl Bright {
    /// Share that is left of a pixel of the glow.
    #[inline(always)]
    pub fn share_left(self, luminance: f32) -> f32 {
        let Some(end) = self.end else { return share_left(luminance / self.threshold) };
        let (expanded, threshold) = (expand(luminance / end), expand(self.threshold / end));
        let left = compressed(expanded * share_left(expanded / threshold), end);
        // Not to round what is not dimmed.
        if expanded > LEAST_DIMMED * threshold { left / luminance } else { 1.0 }
    }
}

/// Share that is left of so many thresholds.
#[inline(always)]
fn share_left(thresholds: f32) -> f32 {
    let excess = thresholds.max(LEAST_DIMMED);
    (2.0 - 0.25 / (excess - 1.0)) / excess
}
