//! A cylinder around the vertical axis: columns are even in azimuth, rows in the tangent of the elevation.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::interface::{PictureNumbers, SphereProjection, check};
use super::places::pixel_by_pixel;
use crate::error::Result;

/// Panorama on a cylinder; its centre looks along +z.
pub struct Cylinder {
    size: [usize; 2],
    /// Azimuth that the width covers.
    field_of_view: f64,
    /// Radius in pixels.
    radius: f64,
    /// Row of elevation 0.
    horizon: f64,
    /// Solid angle of a pixel of each row.
    angles: Vec<f64>,
}

impl Cylinder {
    /// Layout of a picture, or a refusal of numbers that it cannot have.
    pub(super) fn of(picture: &PictureNumbers) -> Result<Self> {
        let fov = picture.field_of_view;
        check(fov > 0.0 && fov <= 2.0 * PI, "a cylinder covers an azimuth above 0, up to 2 pi")?;
        let horizon = picture.horizon.unwrap_or(0.5 * picture.size[0] as f64);
        check(horizon.is_finite(), "the horizon of a cylinder must be finite")?;
        Ok(Self::new(picture.size, fov, horizon))
    }

    /// Panorama whose width covers an azimuth in radians; `horizon` is the y of elevation 0.
    pub fn new(size: [usize; 2], field_of_view: f64, horizon: f64) -> Self {
        let radius = size[1] as f64 / field_of_view;
        let sine = |row: usize| {
            let tangent = (horizon - row as f64) / radius;
            tangent / (1.0 + tangent * tangent).sqrt()
        };
        let column = field_of_view / size[1] as f64;
        let angles = (0..size[0]).map(|row| column * (sine(row) - sine(row + 1))).collect();
        Self { size, field_of_view, radius, horizon, angles }
    }
}

impl SphereProjection for Cylinder {
    fn size(&self) -> [usize; 2] {
        self.size
    }

    fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        let phi = PI + (x / self.size[1] as f64 - 0.5) * self.field_of_view;
        let tangent = (self.horizon - y) / self.radius;
        Some(DVec3::new(phi.sin(), tangent, -phi.cos()).normalize())
    }

    #[inline(always)]
    fn place(&self, direction: DVec3) -> Option<DVec2> {
        let [height, width] = self.size.map(|pixels| pixels as f64);
        // Measure the azimuth from the centre of the picture.
        let azimuth = (-direction.x).atan2(direction.z);
        let x = (azimuth / self.field_of_view + 0.5) * width;
        let y = self.horizon - self.radius * direction.y / direction.x.hypot(direction.z);
        (x >= 0.0 && x <= width && y >= 0.0 && y <= height).then_some(DVec2::new(x, y))
    }

    fn density(&self, _: f64, y: f64) -> f64 {
        let tangent = (self.horizon - y) / self.radius;
        (1.0 + tangent * tangent).powf(-1.5) / (self.radius * self.radius)
    }

    fn solid_angle(&self, pixel: usize) -> f64 {
        self.angles[pixel / self.size[1]]
    }

    fn is_whole(&self) -> bool {
        false
    }

    fn beyond(&self, row: isize, column: isize) -> Option<usize> {
        let [height, width] = self.size.map(|pixels| pixels as isize);
        let is_ring = (self.field_of_view - TAU).abs() < 1e-9;
        (is_ring && (0..height).contains(&row)).then_some((row * width + column.rem_euclid(width)) as usize)
    }

    pixel_by_pixel!();
}
