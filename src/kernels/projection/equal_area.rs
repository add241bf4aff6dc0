//! An octahedral square in which all pixels have the same solid angle (Clarberg 2008), as in pbrt-v4:
//! forward at the centre, backward in the corners.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::f64::consts::{FRAC_PI_4, PI};

use glam::{DVec2, DVec3};

use super::interface::{PictureNumbers, SphereProjection, check};
use super::octahedral::{beyond_fold, pixel_of_square};
use super::places::pixel_by_pixel;
use crate::error::Result;

/// Square of pixels of equal solid angle.
pub struct EqualArea {
    side: usize,
}

impl EqualArea {
    /// Layout of a picture, or a refusal of numbers that it cannot have.
    pub(super) fn of(picture: &PictureNumbers) -> Result<Self> {
        let [height, width] = picture.size;
        check(height == width, "an octahedral picture is a square")?;
        Ok(Self::new(width))
    }

    /// Square of `side` x `side` pixels.
    pub fn new(side: usize) -> Self {
        Self { side }
    }
}

impl SphereProjection for EqualArea {
    fn size(&self) -> [usize; 2] {
        [self.side; 2]
    }

    fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        let (s, t) = (2.0 * x / self.side as f64 - 1.0, 2.0 * y / self.side as f64 - 1.0);
        let signed = 1.0 - (s.abs() + t.abs());
        let radius = 1.0 - signed.abs();
        let phi = if radius > 0.0 { ((t.abs() - s.abs()) / radius + 1.0) * FRAC_PI_4 } else { 0.0 };
        let forward = (1.0 - radius * radius).copysign(signed);
        let sine = radius * (2.0 - radius * radius).sqrt();
        let (right, down) = ((sine * phi.cos()).copysign(s), (sine * phi.sin()).copysign(t));
        Some(DVec3::new(-right, -down, forward))
    }

    #[inline(always)]
    fn place(&self, direction: DVec3) -> Option<DVec2> {
        let (right, down, forward) = (-direction.x, -direction.y, direction.z);
        // Not sqrt(1 - |forward|), which loses half of the digits at the centre.
        let radius = ((right * right + down * down) / (1.0 + forward.abs())).sqrt();
        let phi = down.abs().atan2(right.abs());
        let along = radius * phi / (2.0 * FRAC_PI_4);
        let (s, t) = (radius - along, along);
        let (s, t) = if forward < 0.0 { (1.0 - t, 1.0 - s) } else { (s, t) };
        Some(DVec2::new(s.copysign(right) + 1.0, t.copysign(down) + 1.0) * (0.5 * self.side as f64))
    }

    fn density(&self, _: f64, _: f64) -> f64 {
        self.solid_angle(0)
    }

    fn solid_angle(&self, _: usize) -> f64 {
        4.0 * PI / (self.side * self.side) as f64
    }

    fn is_whole(&self) -> bool {
        true
    }

    fn beyond(&self, row: isize, column: isize) -> Option<usize> {
        Some(beyond_fold(self.side, row, column))
    }

    #[inline(always)]
    fn pixel(&self, direction: [f64; 3]) -> u32 {
        let direction = DVec3::from_array(direction);
        pixel_of_square(self.side, self.place(direction / direction.length()))
    }

    pixel_by_pixel!();
}
