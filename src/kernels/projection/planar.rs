//! A photograph: pinhole projection on a plane.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::interface::{PictureNumbers, SphereProjection, check};
use super::places::pixel_by_pixel;
use super::plane_angles::{plane_angles, plane_density};
use crate::error::Result;

/// Photograph of a camera without distortion.
pub struct Planar {
    size: [usize; 2],
    /// Distance of the plane in pixels.
    focal: f64,
    angles: Vec<f64>,
}

impl Planar {
    /// Layout of a picture, or a refusal of numbers that it cannot have.
    pub(super) fn of(picture: &PictureNumbers) -> Result<Self> {
        let fov = picture.field_of_view;
        check(fov > 0.0 && fov < PI, "a photograph has a field of view between 0 and pi")?;
        Ok(Self::new(picture.size, fov))
    }

    /// Photograph with a horizontal field of view in radians.
    pub fn new(size: [usize; 2], field_of_view: f64) -> Self {
        let [height, width] = size.map(|pixels| pixels as f64);
        let focal = 0.5 * width / (0.5 * field_of_view).tan();
        let edges = |pixels: f64| {
            (0..=pixels as usize).map(|i| (i as f64 - 0.5 * pixels) / focal).collect::<Vec<_>>()
        };
        Self { size, focal, angles: plane_angles(&edges(width), &edges(height)) }
    }

    /// Place on the plane at distance 1, y up.
    fn on_plane(&self, x: f64, y: f64) -> DVec2 {
        let [height, width] = self.size.map(|pixels| pixels as f64);
        DVec2::new(x - 0.5 * width, 0.5 * height - y) / self.focal
    }
}

impl SphereProjection for Planar {
    fn size(&self) -> [usize; 2] {
        self.size
    }

    fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        let place = self.on_plane(x, y);
        Some(DVec3::new(-place.x, place.y, 1.0).normalize())
    }

    #[inline(always)]
    fn place(&self, direction: DVec3) -> Option<DVec2> {
        let [height, width] = self.size.map(|pixels| pixels as f64);
        let x = 0.5 * width + self.focal * -direction.x / direction.z;
        let y = 0.5 * height - self.focal * direction.y / direction.z;
        let is_inside = direction.z > 0.0 && x >= 0.0 && x <= width && y >= 0.0 && y <= height;
        is_inside.then_some(DVec2::new(x, y))
    }

    fn density(&self, x: f64, y: f64) -> f64 {
        let place = self.on_plane(x, y);
        plane_density(place.x, place.y) / (self.focal * self.focal)
    }

    fn solid_angle(&self, pixel: usize) -> f64 {
        self.angles[pixel]
    }

    fn is_whole(&self) -> bool {
        false
    }

    pixel_by_pixel!();
}
