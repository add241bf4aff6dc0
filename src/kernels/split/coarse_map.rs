//! A map averaged over square blocks of pixels. Few blocks lie near a light, so radiance is averaged on demand.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3A};
use ndarray::ArrayView2;

use super::light_pixels::LightPixels;
use crate::error::{Error, Result};
use crate::kernels::fill::LEAST_SHARE;
use crate::kernels::image::{CellCentres, Grid, SeenPart, block_fractions};
use crate::kernels::sphere::{self, Registration};

/// Share of a map that is seen, by which its radiance is multiplied.
pub struct SeenShares<'a> {
    /// Share of each pixel, row after row.
    pixels: &'a [f32],
    /// Share of each coarse pixel.
    blocks: SeenPart,
    /// Least share of a coarse pixel with known radiance.
    least: f32,
}

impl<'a> SeenShares<'a> {
    /// Shares of the pixels, and their means over blocks.
    fn new(
        pixels: &'a [f32],
        map_size: (usize, usize),
        registration: Registration,
        block: usize,
    ) -> Result<Self> {
        let (wanted, seen) = (map_size.0 * map_size.1, pixels.len());
        let view = ArrayView2::from_shape(map_size, pixels);
        let view = view.map_err(|_| Error::LengthMismatch { what: "seen", other: "pixels", wanted, seen })?;
        let blocks = SeenPart::of(view, registration, block);
        let least = LEAST_SHARE * blocks.shares().iter().copied().fold(0.0, f32::max);
        Ok(Self { pixels, blocks, least })
    }
}

/// A map averaged over square blocks of pixels; each block is one coarse pixel.
pub struct CoarseMap<'a> {
    /// Pixels of the map, row after row.
    pub pixels: &'a [[f32; 3]],
    /// Height and width of the map.
    pub map_size: (usize, usize),
    /// Cells of the map's own pixels.
    pub pixel_grid: Grid,
    /// Rows and columns of coarse pixels.
    pub size: (usize, usize),
    /// Cells of the coarse pixels.
    pub grid: Grid,
    /// Pixels of the map along each side of a coarse pixel.
    pub block: usize,
    luminance: &'a [f32],
    /// Share that is seen; none if all is.
    seen: Option<SeenShares<'a>>,
    /// Fraction of each row and column of the map in the coarse pixel that holds it.
    fractions: [Vec<f32>; 2],
    centres: CellCentres,
}

impl<'a> CoarseMap<'a> {
    /// A map of this height and width in the blocks in which its `lights` were detected.
    ///
    /// # Errors
    ///
    /// [`crate::error::Error::LengthMismatch`] if the luminance belongs to another number of blocks.
    pub fn new(
        pixels: &'a [[f32; 3]],
        map_size: (usize, usize),
        registration: Registration,
        lights: &'a LightPixels<'_>,
        seen: Option<&'a [f32]>,
    ) -> Result<Self> {
        let block = lights.block.max(1);
        let pixel_grid = Grid::of_pixels(map_size.0, map_size.1, registration);
        let grid = pixel_grid.in_blocks(block);
        let centres = CellCentres::new(&grid);
        let size = (centres.rows.len(), centres.columns.len());
        sphere::check_lengths("pixels", size.0 * size.1, [("luminance", lights.luminance.len())])?;
        let fractions = block_fractions(&pixel_grid, block);
        let luminance = lights.luminance;
        let seen = seen.map(|seen| SeenShares::new(seen, map_size, registration, block)).transpose()?;
        Ok(Self { pixels, map_size, pixel_grid, size, grid, block, luminance, seen, fractions, centres })
    }

    /// True if enough of a coarse pixel is seen for its radiance.
    pub fn is_known(&self, pixel: usize) -> bool {
        self.seen.as_ref().is_none_or(|seen| seen.blocks.shares()[pixel] >= seen.least)
    }

    /// True if nothing of a coarse pixel is seen.
    pub fn is_unseen(&self, pixel: usize) -> bool {
        self.seen.as_ref().is_some_and(|seen| seen.blocks.shares()[pixel] == 0.0)
    }

    /// Share of a coarse pixel that is seen, by which its mean radiance is divided; 1 if too little is seen.
    fn share(&self, pixel: usize) -> f32 {
        match &self.seen {
            Some(seen) if seen.blocks.shares()[pixel] >= seen.least => seen.blocks.shares()[pixel],
            _ => 1.0,
        }
    }

    /// Share of a pixel of the map that is seen.
    pub fn share_of_pixel(&self, row: usize, column: usize) -> f32 {
        self.seen.as_ref().map_or(1.0, |seen| seen.pixels[row * self.map_size.1 + column])
    }

    /// Mean radiance of the seen part of a coarse pixel by solid angle: exact if all its pixels are equal.
    pub fn radiance(&self, pixel: usize) -> Vec3A {
        let (row, column) = (pixel / self.size.1 * self.block, pixel % self.size.1 * self.block);
        let (height, width) = self.map_size;
        let columns = column..(column + self.block).min(width);
        let first = Vec3A::from_array(self.pixels[row * width + column]);
        let mut difference = Vec3A::ZERO;
        for row in row..(row + self.block).min(height) {
            let pixels = &self.pixels[row * width + columns.start..row * width + columns.end];
            let weighted = pixels.iter().zip(&self.fractions[1][columns.clone()]);
            let sum: Vec3A = weighted.map(|(&rgb, &weight)| weight * (Vec3A::from_array(rgb) - first)).sum();
            difference += self.fractions[0][row] * sum;
        }
        (first + difference) / self.share(pixel)
    }

    /// Mean luminance of the seen part of a coarse pixel.
    pub fn luminance(&self, pixel: usize) -> f32 {
        self.luminance[pixel] / self.share(pixel)
    }

    /// Integral of the luminance over the sphere.
    pub fn flux(&self) -> f64 {
        let widths = self.grid.widths();
        let sum = |row: &[f32]| row.iter().zip(&widths).map(|(&y, width)| f64::from(y) * width).sum::<f64>();
        let rows = self.luminance.chunks(self.size.1).zip(sphere::band_heights(&self.grid.theta_edges));
        rows.map(|(row, band)| band * sum(row)).sum()
    }

    /// Direction of the middle of a coarse pixel.
    pub fn centre(&self, pixel: usize) -> DVec3 {
        self.centres.direction(pixel)
    }

    /// Upper bound of the angle from the middle of a coarse pixel to its corners.
    pub fn half_diagonal(&self) -> f64 {
        0.5 * (PI / self.size.0 as f64).hypot(TAU / self.size.1 as f64)
    }

    /// True if a condition holds for a coarse pixel and all its neighbours; false at the seam and the poles.
    pub fn is_interior(&self, pixel: usize, holds: impl Fn(usize) -> bool) -> bool {
        let (height, width) = self.size;
        let is_at_pole = pixel < width || pixel + width >= height * width;
        let is_at_seam = pixel.is_multiple_of(width) || (pixel + 1).is_multiple_of(width);
        let rows = [pixel.wrapping_sub(width), pixel, pixel + width];
        !is_at_pole && !is_at_seam && rows.into_iter().all(|middle| (middle - 1..=middle + 1).all(&holds))
    }

    /// The eight neighbours of a coarse pixel, across the seam and the poles.
    pub fn neighbours(&self, pixel: usize) -> [usize; 8] {
        let (height, width) = self.size;
        let (row, column) = (pixel / width, pixel % width);
        let left = if column > 0 { column - 1 } else { width - 1 };
        let right = if column + 1 < width { column + 1 } else { 0 };
        // Beyond a pole lies the same row, half a turn away.
        let across = |column: usize| row * width + (column + width / 2) % width;
        let above = |column| if row > 0 { (row - 1) * width + column } else { across(column) };
        let below = |column| if row + 1 < height { (row + 1) * width + column } else { across(column) };
        let [own_left, own_right] = [left, right].map(|column| row * width + column);
        [
            above(left),
            above(column),
            above(right),
            own_left,
            own_right,
            below(left),
            below(column),
            below(right),
        ]
    }
}
