//! An equirectangular map of the whole sphere, or a rectangle of one.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use glam::{DMat3, DVec2, DVec3};
use pulp::{Arch, Simd, WithSimd};

use super::cells::{Cells, diamonds};
use super::directions::{DirectionArrays, Line, Places};
use super::interface::{NO_PIXEL, PictureNumbers, SphereProjection, check};
use super::places::EvenPlaces;
use crate::error::Result;
use crate::kernels::cell_integrals::{ColumnIntegrals, RowIntegrals};
use crate::kernels::sphere::{self, Registration};

/// Rectangle of cells of an equirectangular map.
pub struct Equirectangular {
    /// Cells of the whole map.
    cells: Cells,
    size: [usize; 2],
    /// Row and column of the first pixel in the whole map.
    corner: [usize; 2],
    rows: Vec<RowIntegrals>,
    columns: Vec<ColumnIntegrals>,
}

impl Equirectangular {
    /// Layout of a picture, or a refusal of numbers that it cannot have.
    pub(super) fn of(picture: &PictureNumbers) -> Result<Self> {
        let size = picture.size;
        check(!picture.border_sampled, "samples on the border must be converted to cells first")?;
        let (whole, corner) = (picture.whole.unwrap_or(size), picture.corner);
        check(
            size[0] + corner[0] <= whole[0] && size[1] <= whole[1] && corner[1] < whole[1],
            "a crop must lie inside of its panorama",
        )?;
        Ok(Self::crop(size, whole, corner))
    }

    /// Whole map of this many rows and columns.
    pub fn new(size: [usize; 2]) -> Self {
        Self::crop(size, size, [0, 0])
    }

    /// Rectangle of `size` at a `corner` of the map `whole`; its columns may cross the seam.
    pub fn crop(size: [usize; 2], whole: [usize; 2], corner: [usize; 2]) -> Self {
        let [height, width] = whole;
        Self {
            cells: Cells::new(height, width),
            size,
            corner,
            rows: RowIntegrals::of_rows(&Registration::CellCentred.theta_edges(height)),
            columns: ColumnIntegrals::of_columns(&Registration::CellCentred.phi_edges(width)),
        }
    }

    fn whole(&self) -> [f64; 2] {
        [self.cells.height as f64, self.cells.width as f64]
    }

    /// Pixel of the cell with these [`diamonds`], or [`NO_PIXEL`].
    #[inline(always)]
    fn pixel_of(&self, angles: [f64; 2]) -> u32 {
        let cell = self.cells.at(angles);
        if self.is_whole() {
            return cell as u32;
        }
        let (row, column) = (cell / self.cells.width, cell % self.cells.width);
        let row = row.wrapping_sub(self.corner[0]);
        let column = (column + self.cells.width - self.corner[1]) % self.cells.width;
        let is_inside = row < self.size[0] && column < self.size[1];
        if is_inside { (row * self.size[1] + column) as u32 } else { NO_PIXEL }
    }

    /// Row and column in the whole map.
    fn in_whole(&self, pixel: usize) -> [usize; 2] {
        let (row, column) = (pixel / self.size[1], pixel % self.size[1]);
        [row + self.corner[0], (column + self.corner[1]) % self.cells.width]
    }
}

impl SphereProjection for Equirectangular {
    fn size(&self) -> [usize; 2] {
        self.size
    }

    fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        let ([height, width], [top, left]) = (self.whole(), self.corner.map(|at| at as f64));
        Some(sphere::direction(PI * (y + top) / height, TAU * (x + left) / width))
    }

    fn place(&self, direction: DVec3) -> Option<DVec2> {
        let ([height, width], [top, left]) = (self.whole(), self.corner.map(|at| at as f64));
        let (theta, phi) = sphere::angles(direction);
        let place = DVec2::new((phi / TAU * width - left).rem_euclid(width), theta / PI * height - top);
        let [rows, columns] = self.size.map(|pixels| pixels as f64);
        (place.x <= columns && place.y >= 0.0 && place.y <= rows).then_some(place)
    }

    fn density(&self, _: f64, y: f64) -> f64 {
        let [height, width] = self.whole();
        PI / height * TAU / width * (PI * (y + self.corner[0] as f64) / height).sin()
    }

    fn solid_angle(&self, pixel: usize) -> f64 {
        self.cells.areas[self.in_whole(pixel)[0]]
    }

    fn solid_angles_of_row(&self, row: usize) -> Vec<f64> {
        vec![self.cells.areas[row + self.corner[0]]; self.size[1]]
    }

    fn is_whole(&self) -> bool {
        self.size == [self.cells.height, self.cells.width]
    }

    fn beyond(&self, row: isize, column: isize) -> Option<usize> {
        if !self.is_whole() {
            return None;
        }
        let [height, width] = self.size.map(|pixels| pixels as isize);
        // The other side of a pole is half a turn away.
        let (row, column) = match row {
            ..0 => (-1 - row, column + width / 2),
            row if row >= height => (2 * height - 1 - row, column + width / 2),
            row => (row, column),
        };
        Some((row * width + column.rem_euclid(width)) as usize)
    }

    fn pixel(&self, direction: [f64; 3]) -> u32 {
        self.pixel_of(diamonds(direction))
    }

    fn pixels(&self, directions: &DirectionArrays, pixels: &mut [u32]) {
        // Compute the angles in vectors first: the searches that follow are not done in vectors.
        let mut angles = vec![[f64::NAN; 2]; pixels.len()];
        Arch::new().dispatch(Diamonds { directions, angles: &mut angles });
        for ((pixel, angles), x) in pixels.iter_mut().zip(angles).zip(directions.components()[0]) {
            *pixel = if x.is_nan() { NO_PIXEL } else { self.pixel_of(angles) };
        }
    }

    fn places(&self, side: usize, turn: DMat3) -> Box<dyn Places + '_> {
        if self.is_whole() {
            return Box::new(Parallels::new(&self.cells, side, turn));
        }
        Box::new(EvenPlaces { projection: self, side, turn })
    }

    fn moment(&self, pixel: usize) -> DVec3 {
        let [row, column] = self.in_whole(pixel);
        self.rows[row].direction(&self.columns[column])
    }
}

/// Diamond angles of many directions, with the vectors of the processor.
struct Diamonds<'a> {
    directions: &'a DirectionArrays,
    angles: &'a mut [[f64; 2]],
}

impl WithSimd for Diamonds<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let [x, y, z] = self.directions.components();
        for (((&x, &y), &z), angles) in x.iter().zip(y).zip(z).zip(self.angles) {
            *angles = diamonds([x, y, z]);
        }
    }
}

/// Places of equal solid angles on parallels: even in the cosine and in the azimuth.
struct Parallels<'a> {
    cells: &'a Cells,
    side: usize,
    /// Turned directions of the pole and of the azimuths on the equator.
    pole: DVec3,
    equator: [Vec<f64>; 3],
}

impl<'a> Parallels<'a> {
    fn new(cells: &'a Cells, side: usize, turn: DMat3) -> Self {
        let azimuths = Registration::CellCentred.phis(cells.width * side);
        let turned: Vec<DVec3> =
            azimuths.into_iter().map(|phi| turn * sphere::direction(0.5 * PI, phi)).collect();
        let equator = std::array::from_fn(|axis| turned.iter().map(|direction| direction[axis]).collect());
        Self { cells, side, pole: turn * DVec3::Y, equator }
    }

    fn sub_columns(&self, line: &Line) -> Range<usize> {
        line.first * self.side..(line.first + line.columns) * self.side
    }
}

impl Places for Parallels<'_> {
    fn directions(&self, line: &Line, out: &mut DirectionArrays) {
        let (top, bottom) = (self.cells.cosines[line.row], self.cells.cosines[line.row + 1]);
        let cosine = top + (bottom - top) * (line.line as f64 + 0.5) / self.side as f64;
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let pole = (cosine * self.pole).to_array();
        for ((out, equator), pole) in out.components_mut().into_iter().zip(&self.equator).zip(pole) {
            for (out, equator) in out.iter_mut().zip(&equator[self.sub_columns(line)]) {
                *out = sine * equator + pole;
            }
        }
    }
}
