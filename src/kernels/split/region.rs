//! The region of each light: its pixels, rim and glare, which are filled, and its glow, which is dimmed.

use glam::Vec3A;

use super::coarse_map::CoarseMap;
use super::glow;
use super::light_pixels::NO_LIGHT;
use super::rings::ring_pixels;
use crate::kernels::image::luminance_f32;

/// Coarse pixels from which light is removed.
pub struct Region {
    /// Light of each coarse pixel, counted from 1.
    pub light_of: Vec<u32>,
    /// True for pixels to fill, false for glow.
    pub is_filled: Vec<bool>,
    threshold: f32,
}

impl Region {
    /// The region of the first `removed` lights of `members`: flat indices, each with its light. The others stay.
    pub fn new(map: &CoarseMap<'_>, members: &[(usize, usize)], removed: usize, threshold: f32) -> Self {
        let mut light_of = vec![NO_LIGHT; map.size.0 * map.size.1];
        for &(pixel, light) in members {
            light_of[pixel] = light as u32 + 1;
        }
        for (pixel, light) in ring_pixels(map, members, &light_of, threshold) {
            if light as usize <= removed {
                light_of[pixel] = light;
            }
        }
        let is_filled = light_of.iter().map(|&light| light != NO_LIGHT).collect();
        glow::add_glow(map, &mut light_of, threshold);
        for (pixel, light) in light_of.iter_mut().enumerate() {
            if *light as usize > removed || map.is_unseen(pixel) {
                *light = NO_LIGHT;
            }
        }
        Self { light_of, is_filled, threshold }
    }

    /// Flat indices of the pixels to fill, in ascending order: those of lights, and those without known radiance.
    pub fn pixels_to_fill(&self, map: &CoarseMap<'_>) -> Vec<usize> {
        let is_of_light = |pixel: usize| self.is_filled[pixel] && self.light_of[pixel] != NO_LIGHT;
        if !(0..self.light_of.len()).any(is_of_light) {
            return Vec::new();
        }
        let is_filled = |&pixel: &usize| is_of_light(pixel) || !map.is_known(pixel);
        (0..self.light_of.len()).filter(is_filled).collect()
    }

    /// Mean radiance of a pixel outside the fill, after the glow is dimmed.
    pub fn rest(&self, map: &CoarseMap<'_>, pixel: usize) -> Vec3A {
        let mean = map.radiance(pixel);
        if self.light_of[pixel] == NO_LIGHT { mean } else { self.dim(mean, 1.0) }
    }

    /// Remaining radiance of a glow; `share` of it is seen, and `radiance` is multiplied by that.
    pub fn dim(&self, radiance: Vec3A, share: f32) -> Vec3A {
        let thresholds = luminance_f32(radiance.to_array()) / (self.threshold * share);
        radiance * glow::remaining_fraction(thresholds)
    }
}
