//! Overview of a map: means over blocks, by which Python tells a panorama from other pictures of 2:1.

use ndarray::{Array3, ArrayView3};

use super::block_layout::BlockLayout;
use super::cell_flux::CellFlux;
use crate::error::Result;
use crate::kernels::sphere::Registration;

/// Mean radiance by solid angle in the cells of a map that is reduced to `columns`, (rows, columns, 3).
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::UnusableSamples`].
pub fn overview(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    columns: usize,
) -> Result<Array3<f32>> {
    let layout = BlockLayout::of_map(radiance, registration, columns)?;
    Ok(CellFlux::of_map(radiance, &layout)?.means(&layout.grid).0)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_means_of_blocks_and_a_constant_map_stays_constant() {
        let map = Array3::from_shape_fn((64, 128, 3), |(_, x, c)| (x / 64 + c) as f32);
        let cells = overview(map.view(), Registration::CellCentred, 32).unwrap();
        assert_eq!(cells.dim(), (16, 32, 3));
        let wanted = Array3::from_shape_fn((16, 32, 3), |(_, x, c)| (x / 16 + c) as f32);
        assert!(cells.iter().zip(&wanted).all(|(cell, wanted)| (cell - wanted).abs() < 1e-6));
    }
}
