//! A cube, seen from inside: six upright faces, one above the other.
//!
//! ```text
//!            +------+                     +z front: the centre of a panorama
//!            |  up  |                     -x right
//!     +------+------+------+------+       -z back
//!     | left |front |right | back |       +x left
//!     +------+------+------+------+       the lower edge of up touches the upper edge of front
//!            | down |                     the upper edge of down touches the lower edge of front
//!            +------+
//! ```

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use glam::{DVec2, DVec3};

use super::interface::{PictureNumbers, SphereProjection, check};
use super::places::pixel_by_pixel;
use super::plane_angles::{plane_angles, plane_density};
use crate::error::Result;

/// Forward, right and up of each face: front, right, back, left, up, down.
const FACES: [[DVec3; 3]; 6] = [
    [DVec3::Z, DVec3::NEG_X, DVec3::Y],
    [DVec3::NEG_X, DVec3::NEG_Z, DVec3::Y],
    [DVec3::NEG_Z, DVec3::X, DVec3::Y],
    [DVec3::X, DVec3::Z, DVec3::Y],
    [DVec3::Y, DVec3::NEG_X, DVec3::NEG_Z],
    [DVec3::NEG_Y, DVec3::NEG_X, DVec3::Z],
];

/// Six square faces in one column.
pub struct Cube {
    /// Pixels along the side of a face.
    side: usize,
    /// True if the outer pixels of a face lie on its edges.
    is_border_sampled: bool,
    /// Coordinate of the picture's edge on the face's plane: 1, or more for faces wider than 90 degrees. What lies
    /// beyond 1 belongs to the next face, and its pixels have no solid angle.
    reach: f64,
    /// Solid angles of the pixels of one face.
    angles: Vec<f64>,
}

impl Cube {
    /// Layout of a picture, or a refusal of numbers that it cannot have.
    pub(super) fn of(picture: &PictureNumbers) -> Result<Self> {
        let [height, width] = picture.size;
        check(height == 6 * width, "a cube is a column of six square faces")?;
        let has_borders = !picture.border_sampled || width > 1;
        check(has_borders, "a face with samples on its border has two or more")?;
        let reach = if picture.field_of_view == 0.0 { 1.0 } else { (0.5 * picture.field_of_view).tan() };
        check((1.0 - 1e-12..=1e3).contains(&reach), "a face of a cube is at least 90 degrees wide")?;
        Ok(Self::new(width, picture.border_sampled, reach))
    }

    /// Faces of `side` x `side` pixels; for `reach`, see the field.
    pub fn new(side: usize, is_border_sampled: bool, reach: f64) -> Self {
        let mut cube = Self { side, is_border_sampled, reach, angles: Vec::new() };
        let edges: Vec<f64> = (0..=side).map(|i| cube.on_plane(i as f64).clamp(-1.0, 1.0)).collect();
        cube.angles = plane_angles(&edges, &edges);
        cube
    }

    /// Coordinate on the face's plane, -1 to 1 for 90 degrees, of one in pixels.
    fn on_plane(&self, x: f64) -> f64 {
        let place = if self.is_border_sampled {
            (2.0 * x - 1.0) / (self.side as f64 - 1.0) - 1.0
        } else {
            2.0 * x / self.side as f64 - 1.0
        };
        self.reach * place
    }

    /// Coordinate in pixels of one on the face's plane.
    #[inline(always)]
    fn in_pixels(&self, a: f64) -> f64 {
        let scale = self.side as f64 - f64::from(u8::from(self.is_border_sampled));
        let place = (a / self.reach + 1.0) * 0.5 * scale + if self.is_border_sampled { 0.5 } else { 0.0 };
        // A place on the far edge of a face stays in it: one row further, another face begins.
        place.clamp(0.0, (self.side as f64).next_down())
    }

    /// Direction of a place on the plane of a face, also beyond its edges.
    fn direction_on_face(face: usize, a: f64, b: f64) -> DVec3 {
        let [forward, right, up] = FACES[face];
        (forward + a * right + b * up).normalize()
    }

    /// Face of a direction, and coordinates on its plane: to the right and down.
    #[inline(always)]
    fn on_face([x, y, z]: [f64; 3]) -> (usize, f64, f64) {
        let (along_x, along_y, along_z) = (x.abs(), y.abs(), z.abs());
        let is_z = along_z >= along_x && along_z >= along_y;
        let is_x = !is_z && along_x >= along_y;
        let depth = 1.0
            / if is_z {
                along_z
            } else if is_x {
                along_x
            } else {
                along_y
            };
        // Right of the picture: -x in front, x behind, -z on the right, z on the left.
        let side = if z > 0.0 { -x } else { x };
        let across = if is_z {
            side
        } else if is_x {
            if x > 0.0 { z } else { -z }
        } else {
            -x
        };
        let down = if is_z || is_x {
            -y
        } else if y > 0.0 {
            z
        } else {
            -z
        };
        let face = if is_z {
            if z > 0.0 { 0 } else { 2 }
        } else if is_x {
            if x > 0.0 { 3 } else { 1 }
        } else if y > 0.0 {
            4
        } else {
            5
        };
        (face, across * depth, down * depth)
    }
}

impl SphereProjection for Cube {
    fn size(&self) -> [usize; 2] {
        [6 * self.side, self.side]
    }

    fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        let face = ((y / self.side as f64) as usize).min(5);
        let (a, b) = (self.on_plane(x), -self.on_plane(y - (face * self.side) as f64));
        (a.abs().max(b.abs()) <= 1.0 + 1e-12).then(|| Self::direction_on_face(face, a, b))
    }

    fn place(&self, direction: DVec3) -> Option<DVec2> {
        let (face, across, down) = Self::on_face(direction.to_array());
        let (top, y) = ((face * self.side) as f64, self.in_pixels(down));
        // The sum may round up to the first row of the next face.
        let last = (top + self.side as f64).next_down();
        Some(DVec2::new(self.in_pixels(across), (top + y).min(last)))
    }

    fn density(&self, x: f64, y: f64) -> f64 {
        let pixel = self.on_plane(1.0) - self.on_plane(0.0);
        let (a, b) = (self.on_plane(x), self.on_plane(y % self.side as f64));
        pixel * pixel * plane_density(a, b)
    }

    fn solid_angle(&self, pixel: usize) -> f64 {
        self.angles[pixel % self.angles.len()]
    }

    fn is_whole(&self) -> bool {
        true
    }

    fn neighbour(&self, pixel: usize, [down, right]: [isize; 2]) -> Option<usize> {
        let (face, in_face) = (pixel / (self.side * self.side), pixel % (self.side * self.side));
        let row = (in_face / self.side) as isize + down;
        let column = (in_face % self.side) as isize + right;
        let side = 0..self.side as isize;
        if side.contains(&row) && side.contains(&column) {
            let next = pixel.checked_add_signed(down * self.side as isize + right);
            if let Some(visible) = next.filter(|&next| self.solid_angle(next) > 0.0) {
                return Some(visible);
            }
        }
        // Continue the plane of the face, and search the pixel of that direction.
        let (a, b) = (self.on_plane(column as f64 + 0.5), -self.on_plane(row as f64 + 0.5));
        Some(self.pixel(Self::direction_on_face(face, a, b).to_array()) as usize)
    }

    #[inline(always)]
    fn pixel(&self, direction: [f64; 3]) -> u32 {
        let (face, across, down) = Self::on_face(direction);
        let (x, y) = (self.in_pixels(across) as u32, self.in_pixels(down) as u32);
        (face as u32 * self.side as u32 + y) * self.side as u32 + x
    }

    pixel_by_pixel!();
}
