//! An octahedron, unfolded on a square: forward at the centre, backward in the four corners (Engelhardt and Dachsbacher
//! 2008).

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use glam::{DVec2, DVec3};

use super::interface::{PictureNumbers, SphereProjection, check};
use super::places::pixel_by_pixel;
use crate::error::Result;
use crate::kernels::sphere::spherical_area;

/// Square of an even number of pixels.
pub struct Octahedral {
    side: usize,
    angles: Vec<f64>,
}

impl Octahedral {
    /// Layout of a picture, or a refusal of numbers that it cannot have.
    pub(super) fn of(picture: &PictureNumbers) -> Result<Self> {
        let [height, width] = picture.size;
        check(height == width && width.is_multiple_of(2), "an octahedral square has an even side")?;
        Ok(Self::new(width))
    }

    /// Square of `side` x `side` pixels; `side` is even, so that no pixel crosses an axis.
    pub fn new(side: usize) -> Self {
        let corners: Vec<Vec<DVec3>> = (0..=side)
            .map(|y| (0..=side).map(|x| unfold(side, x as f64, y as f64).normalize()).collect())
            .collect();
        let angle = |pixel: usize| {
            let (row, column) = (pixel / side, pixel % side);
            let [top, bottom] = [&corners[row], &corners[row + 1]];
            quadrilateral(
                [top[column], top[column + 1], bottom[column + 1], bottom[column]],
                (row < side / 2) == (column < side / 2),
            )
        };
        Self { side, angles: (0..side * side).map(angle).collect() }
    }
}

/// Point of the octahedron |x| + |y| + |z| = 1 at a place of the square.
fn unfold(side: usize, x: f64, y: f64) -> DVec3 {
    let (s, t) = (2.0 * x / side as f64 - 1.0, 2.0 * y / side as f64 - 1.0);
    let forward = 1.0 - s.abs() - t.abs();
    let (right, down) =
        if forward < 0.0 { ((1.0 - t.abs()).copysign(s), (1.0 - s.abs()).copysign(t)) } else { (s, t) };
    DVec3::new(-right, -down, forward)
}

/// Solid angle of a pixel between its corners in turn; it is divided along the fold.
fn quadrilateral([a, b, c, d]: [DVec3; 4], is_rising: bool) -> f64 {
    let halves = if is_rising { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] };
    halves.map(spherical_area).iter().sum()
}

/// Pixel of a square whose edges are folded onto themselves, as far as one row outside of it.
pub(super) fn beyond_fold(side: usize, row: isize, column: isize) -> usize {
    let last = side as isize - 1;
    let mirror = |at: isize, other: isize| {
        if at < 0 {
            (-1 - at, last - other)
        } else if at > last {
            (2 * last + 1 - at, last - other)
        } else {
            (at, other)
        }
    };
    let (column, row) = mirror(column, row);
    let (row, column) = mirror(row, column);
    (row * (last + 1) + column) as usize
}

impl SphereProjection for Octahedral {
    fn size(&self) -> [usize; 2] {
        [self.side; 2]
    }

    fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        Some(unfold(self.side, x, y).normalize())
    }

    #[inline(always)]
    fn place(&self, direction: DVec3) -> Option<DVec2> {
        let DVec3 { x, y, z } = direction / (direction.x.abs() + direction.y.abs() + direction.z.abs());
        let (right, down) = (-x, -y);
        let (s, t) = if z < 0.0 {
            ((1.0 - down.abs()).copysign(right), (1.0 - right.abs()).copysign(down))
        } else {
            (right, down)
        };
        Some(DVec2::new(s + 1.0, t + 1.0) * (0.5 * self.side as f64))
    }

    fn density(&self, x: f64, y: f64) -> f64 {
        let pixel = 2.0 / self.side as f64;
        pixel * pixel / unfold(self.side, x, y).length().powi(3)
    }

    fn solid_angle(&self, pixel: usize) -> f64 {
        self.angles[pixel]
    }

    fn is_whole(&self) -> bool {
        true
    }

    fn beyond(&self, row: isize, column: isize) -> Option<usize> {
        Some(beyond_fold(self.side, row, column))
    }

    #[inline(always)]
    fn pixel(&self, direction: [f64; 3]) -> u32 {
        pixel_of_square(self.side, self.place(DVec3::from_array(direction)))
    }

    pixel_by_pixel!();
}

/// Number of the pixel around a place of a square.
#[inline(always)]
pub(super) fn pixel_of_square(side: usize, place: Option<DVec2>) -> u32 {
    let place = place.unwrap_or_default();
    let last = side as u32 - 1;
    (place.y as u32).min(last) * side as u32 + (place.x as u32).min(last)
}
