//! Removed luminance around a light, in the plane that touches the sphere at the light.

use glam::{DMat3, DVec3};

use super::card_pixels::CardPixels;
use super::soft_shapes::PlanePixel;
use crate::kernels::image::LUMINANCE;
use crate::kernels::sphere;

/// Pixels of a footprint at most.
pub const MOST_SAMPLES: usize = 12_000;

/// Least cosine between the middle of a plane and a direction in it.
const LEAST_COSINE: f64 = 0.15;
/// Largest angle around a light that is searched for its outline, in radians.
pub const FARTHEST: f64 = 1.4;

/// Radiance that was removed from a map, and the light of each pixel.
pub struct RemovedRadiance<'a> {
    pub pixels: CardPixels,
    pub map: &'a [[f32; 3]],
    pub rest: &'a [[f32; 3]],
    /// Number of the light of each block of pixels from 1, or 0.
    pub labels: Vec<u32>,
    /// Pixels along each side of a block, and blocks in a row.
    pub block: usize,
    pub blocks: usize,
}

impl RemovedRadiance<'_> {
    /// Radiance that was removed from a pixel.
    pub fn radiance(&self, pixel: usize) -> DVec3 {
        let channel = |c: usize| f64::from(self.map[pixel][c]) - f64::from(self.rest[pixel][c]);
        DVec3::new(channel(0), channel(1), channel(2)).max(DVec3::ZERO)
    }

    /// Removed luminance of a pixel times its solid angle.
    pub fn luminous_flux(&self, pixel: usize) -> f64 {
        self.radiance(pixel).dot(LUMINANCE.into()) * self.pixels.solid_angle(pixel)
    }

    /// Luminance of the map in a pixel; 0 if it is negative.
    pub fn luminance(&self, pixel: usize) -> f64 {
        let [red, green, blue] = self.map[pixel];
        DVec3::new(red.into(), green.into(), blue.into()).dot(LUMINANCE.into()).max(0.0)
    }

    /// Number of the light of a pixel from 1, or 0.
    pub fn label(&self, pixel: usize) -> u32 {
        let (row, column) = (pixel / self.pixels.width, pixel % self.pixels.width);
        self.labels[row / self.block * self.blocks + column / self.block]
    }

    /// Pixels of each light, by its number from 1.
    pub fn members(&self, lights: usize) -> Vec<Vec<u32>> {
        let mut members = vec![Vec::new(); lights];
        for pixel in 0..self.map.len() {
            let label = self.label(pixel) as usize;
            if (1..=lights).contains(&label) {
                members[label - 1].push(pixel as u32);
            }
        }
        members
    }
}

/// Pixel of a footprint.
#[derive(Clone, Copy)]
pub struct PlaneSample {
    pub pixel: PlanePixel,
    pub luminance: f64,
    pub solid_angle: f64,
}

/// Pixels around a light in a plane.
pub struct Footprint {
    /// Axes x and y of the plane, and its direction.
    pub frame: DMat3,
    pub samples: Vec<PlaneSample>,
    /// Luminance above which half of the flux lies, or 4 medians if that is less.
    pub reference: f64,
    /// Height of a pixel in radians.
    pub step: f64,
}

impl Footprint {
    /// Pixels around these lights with the `members`; `most` pixels at most. Other lights are dark.
    pub fn new(removed: &RemovedRadiance<'_>, lights: &[u32], members: &[u32], most: usize) -> Option<Self> {
        let luminance = |pixel: usize| removed.radiance(pixel).dot(DVec3::from_array(LUMINANCE));
        let pixels = &removed.pixels;
        let weight = |&pixel: &u32| luminance(pixel as usize) * pixels.solid_angle(pixel as usize);
        let sum: DVec3 = members.iter().map(|pixel| weight(pixel) * pixels.direction(*pixel as usize)).sum();
        let centre = sum.try_normalize()?;
        let cosine = |&pixel: &u32| pixels.direction(pixel as usize).dot(centre);
        let far = members.iter().map(cosine).fold(1.0, f64::min).clamp(-1.0, 1.0).acos();
        let near = pixels.near(centre, (1.1 * (far + 4.0 * pixels.step())).min(FARTHEST));
        let [x, y] = sphere::tangents(centre);
        let frame = DMat3::from_cols(x, y, centre);
        let stride = near.len().div_ceil(most);
        // A stride that shares no factor with the width spreads over all columns.
        let stride = if stride > 1 && pixels.width.is_multiple_of(stride) { stride + 1 } else { stride };
        let sample = |pixel: usize| {
            let label = removed.label(pixel);
            let is_dark = label != 0 && !lights.contains(&label);
            Some(PlaneSample {
                pixel: plane_pixel(pixels, &frame, pixel)?,
                luminance: if is_dark { 0.0 } else { luminance(pixel) },
                solid_angle: pixels.solid_angle(pixel),
            })
        };
        let samples = near.into_iter().step_by(stride.max(1)).filter_map(sample).collect();
        let reference = reference(members.iter().map(|&pixel| luminance(pixel as usize)).collect())?;
        Some(Self { frame, samples, reference, step: pixels.step() })
    }

    /// Every n-th of the samples, so that at most this many remain.
    pub fn every_nth(&self, most: usize) -> Self {
        let stride = self.samples.len().div_ceil(most).max(1);
        let samples = self.samples.iter().step_by(stride).copied().collect();
        Self { samples, ..*self }
    }

    /// Part of each pixel that a light with this outer and inner luminance covers.
    pub fn coverage(&self, outer: f64, inner: f64) -> Vec<f64> {
        let part = |sample: &PlaneSample| ((sample.luminance - outer) / (inner - outer)).clamp(0.0, 1.0);
        self.samples.iter().map(part).collect()
    }

    /// Weighted mean of a function of the samples.
    pub fn sum(&self, parts: &[f64], of: impl Fn(&PlaneSample) -> f64) -> f64 {
        self.samples.iter().zip(parts).map(|(sample, part)| part * sample.solid_angle * of(sample)).sum()
    }
}

/// Luminance above which half of the flux lies, at most 4 medians.
fn reference(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let total: f64 = values.iter().sum();
    let mut sum = 0.0;
    let half = values.iter().position(|value| {
        sum += value;
        sum >= 0.5 * total
    })?;
    let (half, median) = (values[half], values[values.len() / 2]);
    let reference = if median > 0.0 { half.min(4.0 * median) } else { half };
    (reference > 0.0).then_some(reference)
}

/// Pixel in a plane, with the sides that its steps in both angles have there.
fn plane_pixel(pixels: &CardPixels, frame: &DMat3, pixel: usize) -> Option<PlanePixel> {
    let local = frame.transpose() * pixels.direction(pixel);
    if local.z < LEAST_COSINE {
        return None;
    }
    let place = local.truncate() / local.z;
    let (theta, phi) = pixels.angles(pixel);
    let [by_theta, by_phi] = sphere::angle_derivatives(theta, phi);
    let side = |step: DVec3| {
        let step = frame.transpose() * step;
        (step.truncate() - place * step.z) / local.z
    };
    let columns = 2.0 * std::f64::consts::PI / pixels.width as f64;
    Some(PlanePixel { place, sides: [side(by_theta * pixels.step()), side(by_phi * columns)] })
}
