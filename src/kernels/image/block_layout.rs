//! Blocks of pixels that are the cells of a working map.

use std::ops::Range;

use ndarray::ArrayView3;

use super::grid::Grid;
use super::parts::PixelBlock;
use super::samples::check_rgb;
use crate::error::Result;
use crate::kernels::sphere::Registration;

/// Pixels of a map, and the blocks that are the cells of its working map.
#[derive(Clone, Debug)]
pub(crate) struct BlockLayout {
    /// Grid of the pixels.
    pub pixels: Grid,
    /// Grid of the blocks.
    pub grid: Grid,
    /// Pixels along each side of a block; those at the far edges may be smaller.
    pub block: usize,
}

impl BlockLayout {
    /// Blocks of the pixels of a map.
    ///
    /// # Errors
    ///
    /// [`crate::error::Error::NotAMap`].
    pub fn of_map(radiance: ArrayView3<'_, f32>, registration: Registration, columns: usize) -> Result<Self> {
        check_rgb(radiance)?;
        let (height, width, _) = radiance.dim();
        Ok(Self::new(height, width, registration, columns))
    }

    /// Blocks in at most `columns` columns.
    pub fn new(height: usize, width: usize, registration: Registration, columns: usize) -> Self {
        let pixels = Grid::of_pixels(height, width, registration);
        let block = width.div_ceil(columns.max(1));
        let grid = pixels.in_blocks(block);
        Self { pixels, grid, block }
    }

    /// Rows and columns of the pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.pixels.theta_edges.len() - 1, self.pixels.phi_edges.len() - 1)
    }

    /// Rows and columns of the blocks.
    pub fn blocks(&self) -> (usize, usize) {
        (self.grid.theta_edges.len() - 1, self.grid.phi_edges.len() - 1)
    }

    /// Rows of pixels in a row of blocks.
    pub fn pixel_rows(&self, row: usize) -> Range<usize> {
        row * self.block..((row + 1) * self.block).min(self.size().0)
    }

    /// Pixels of a block.
    pub fn pixels_of(&self, (row, column): (usize, usize)) -> PixelBlock {
        let columns = column * self.block..((column + 1) * self.block).min(self.size().1);
        PixelBlock { rows: self.pixel_rows(row), columns }
    }

    /// Copy a block out of the `samples` of its row of blocks.
    pub fn copy<T: Copy>(&self, samples: &[T], block: (usize, usize)) -> Vec<T> {
        let PixelBlock { rows, columns } = self.pixels_of(block);
        let mut pixels = Vec::with_capacity(3 * rows.len() * columns.len());
        for row in samples.chunks_exact(3 * self.size().1) {
            pixels.extend_from_slice(&row[3 * columns.start..3 * columns.end]);
        }
        pixels
    }
}
