//! The glow of a light: bright surroundings that are connected to it.
//!
//! Without the light, detection would find the clouds around a sun or the dim part of a softbox instead. They are no part
//! of the light and may lie far to one side, so only the excess is removed with it. A luminance of `y` thresholds is
//! reduced to
//!
//! ```text
//!   y' = 2 - 1/4 / (y - 1)        above y = 3/2
//! ```
//!
//! which continues `y` smoothly, preserves the contrast of clouds, and stays below 2 thresholds.

use glam::DVec3;

use super::coarse_map::CoarseMap;
use super::light_pixels::NO_LIGHT;
use crate::interrupt;

/// Largest angle from a light to its glow: 45 degrees, in radians. Without it, the sky over a city at night would be
/// removed as one light.
const FARTHEST: f64 = std::f64::consts::FRAC_PI_4;

/// Extend the lights of `light_of` by connected pixels above the threshold; each joins the light that is the fewest steps away.
pub fn add_glow(map: &CoarseMap<'_>, light_of: &mut [u32], threshold: f32) {
    let farthest = (2.0 * (FARTHEST / 2.0).sin()).powi(2);
    // Start at the outlines of all lights; each pixel inherits the outline pixel from which it was reached.
    let is_of_light = |pixel: usize| light_of[pixel] != NO_LIGHT;
    let is_outline = |&pixel: &usize| is_of_light(pixel) && !map.is_interior(pixel, is_of_light);
    let mut front: Vec<(usize, DVec3)> =
        (0..light_of.len()).filter(is_outline).map(|pixel| (pixel, map.centre(pixel))).collect();
    while !front.is_empty() {
        interrupt::check();
        let mut next = Vec::new();
        for (pixel, source) in front {
            for other in map.neighbours(pixel) {
                let is_near = || map.centre(other).distance_squared(source) < farthest;
                if light_of[other] == NO_LIGHT && map.luminance(other) > threshold && is_near() {
                    light_of[other] = light_of[pixel];
                    next.push((other, source));
                }
            }
        }
        front = next;
    }
}

/// Remaining fraction of the radiance of a glow, by its luminance in thresholds. Pixels up to 1.5 are not dimmed.
pub fn remaining_fraction(thresholds: f32) -> f32 {
    let excess = thresholds.max(1.5);
    (2.0 - 0.25 / (excess - 1.0)) / excess
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_remaining_luminance_continues_smoothly_and_stays_below_two_thresholds() {
        let remains = |y: f32| y * remaining_fraction(y);
        for y in [1.0, 1.5] {
            assert!((remaining_fraction(y) - 1.0).abs() < 1e-6);
        }
        let derivative = (remains(1.51) - remains(1.5)) / 0.01;
        assert!((derivative - 1.0).abs() < 0.05, "{derivative}");
        let values: Vec<f32> = (0..100).map(|i| remains(1.5 * 1.1_f32.powi(i))).collect();
        assert!(values.windows(2).all(|pair| pair[0] <= pair[1] && pair[1] <= 2.0));
    }
}
