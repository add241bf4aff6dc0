//! The common interface of all layouts, and the search for the pixels of many directions.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use glam::{DMat3, DVec2, DVec3};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::directions::{DirectionArrays, Places};
use crate::error::{Error, Result};

/// Number in place of a pixel for a direction that the picture does not show.
pub const NO_PIXEL: u32 = u32::MAX;

/// Size of a picture, and the numbers that describe its projection; each projection takes its own.
pub struct PictureNumbers {
    /// Rows and columns.
    pub size: [usize; 2],
    /// True if the outer samples lie on the borders of the picture or of each face.
    pub border_sampled: bool,
    /// Rows and columns of the whole panorama, if the picture is a part of one.
    pub whole: Option<[usize; 2]>,
    /// Row and column of a part in the whole panorama.
    pub corner: [usize; 2],
    /// Horizontal field of view in radians.
    pub field_of_view: f64,
    /// Row coordinate of elevation 0; `None` for the middle.
    pub horizon: Option<f64>,
    /// Name of the mapping of a circle.
    pub mapping: String,
    /// Angle between the axis and the edge of a circle, in radians.
    pub reach: f64,
    /// Centre x, centre y and radius of a circle, in pixels; `None` for the largest.
    pub circle: Option<(f64, f64, f64)>,
}

/// Refuse numbers that no picture has.
pub(super) fn check(is_valid: bool, what: &'static str) -> Result<()> {
    if is_valid { Ok(()) } else { Err(Error::NoSuchLayout { what }) }
}

/// Layout of the sphere, or of a part of it, in a picture.
pub trait SphereProjection: Send + Sync {
    /// Rows and columns.
    fn size(&self) -> [usize; 2];

    /// Unit direction of a place; `None` outside of the picture of the sphere.
    fn direction(&self, x: f64, y: f64) -> Option<DVec3>;

    /// Place of a unit direction; `None` if the picture does not show it.
    fn place(&self, direction: DVec3) -> Option<DVec2>;

    /// Solid angle for each unit of area in the picture, at a place inside of it.
    fn density(&self, x: f64, y: f64) -> f64;

    /// Exact solid angle of a pixel, by its number: row after row.
    fn solid_angle(&self, pixel: usize) -> f64;

    /// True if the picture shows the whole sphere.
    fn is_whole(&self) -> bool;

    /// Number of the pixel whose centre continues the grid beyond the border; `None` if the picture ends there.
    fn beyond(&self, _row: isize, _column: isize) -> Option<usize> {
        None
    }

    /// Number of the pixel some rows below and columns to the right of another; `None` if the picture ends there.
    fn neighbour(&self, pixel: usize, [down, right]: [isize; 2]) -> Option<usize> {
        let [height, width] = self.size();
        let (row, column) = ((pixel / width) as isize + down, (pixel % width) as isize + right);
        let is_inside = (0..height as isize).contains(&row) && (0..width as isize).contains(&column);
        if is_inside { Some(row as usize * width + column as usize) } else { self.beyond(row, column) }
    }

    /// Number of the pixel that shows a direction of any length, or [`NO_PIXEL`].
    #[inline(always)]
    fn pixel(&self, direction: [f64; 3]) -> u32 {
        let [height, width] = self.size();
        let place = self.place(DVec3::from_array(direction).normalize());
        place.map_or(NO_PIXEL, |place| {
            let (row, column) = ((place.y as usize).min(height - 1), (place.x as usize).min(width - 1));
            (row * width + column) as u32
        })
    }

    /// Numbers of the pixels that show directions of any length; NaN becomes [`NO_PIXEL`].
    fn pixels(&self, directions: &DirectionArrays, pixels: &mut [u32]);

    /// Places on a grid of `side` x `side` in each pixel, as directions multiplied by `turn`.
    fn places(&self, side: usize, turn: DMat3) -> Box<dyn Places + '_>;

    /// Solid angle of the picture, and the number of the pixels that show a part of the sphere.
    fn extent(&self) -> (f64, usize) {
        let rows = (0..self.size()[0]).into_par_iter().map(|row| {
            let angles = self.solid_angles_of_row(row);
            (angles.iter().sum::<f64>(), angles.iter().filter(|&&angle| angle > 0.0).count())
        });
        let add = |(sum, count), (angle, pixels)| (sum + angle, count + pixels);
        rows.collect::<Vec<_>>().into_iter().fold((0.0, 0), add)
    }

    /// Exact solid angles of the pixels of a row.
    fn solid_angles_of_row(&self, row: usize) -> Vec<f64> {
        let width = self.size()[1];
        (row * width..(row + 1) * width).map(|pixel| self.solid_angle(pixel)).collect()
    }

    /// Mean solid angle of the pixels that show a part of the sphere.
    fn mean_solid_angle(&self) -> f64 {
        let (sum, count) = self.extent();
        sum / count.max(1) as f64
    }

    /// Integral of the direction over a pixel.
    fn moment(&self, pixel: usize) -> DVec3;
}

/// Search for the pixels of directions, with the vectors of the processor.
pub fn search<P: SphereProjection>(projection: &P, directions: &DirectionArrays, pixels: &mut [u32]) {
    Arch::new().dispatch(PixelSearch { projection, directions, pixels });
}

struct PixelSearch<'a, P> {
    projection: &'a P,
    directions: &'a DirectionArrays,
    pixels: &'a mut [u32],
}

impl<P: SphereProjection> WithSimd for PixelSearch<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let [x, y, z] = self.directions.components();
        for (((&x, &y), &z), pixel) in x.iter().zip(y).zip(z).zip(self.pixels) {
            let found = self.projection.pixel([x, y, z]);
            *pixel = if x.is_nan() { NO_PIXEL } else { found };
        }
    }
}
