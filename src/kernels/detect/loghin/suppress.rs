//! Step 7 of Loghin (2021): samples near a brighter one.

use std::iter::successors;

use glam::DVec3;
use ndarray::ArrayView2;
use rustc_hash::FxHashMap;

use super::image::points_in_space;
use crate::error::Result;
use crate::interrupt;
use crate::kernels::sphere::check_memory;

/// For each of `points`, (n, 2) or (n, 3), brightest first, the survivor that it belongs to.
///
/// This is the brightest survivor closer than `distance`, or the point itself. Survivors lie in cells of the size of
/// `distance`, so a point is compared only with the few survivors in its own and the adjacent cells.
///
/// # Errors
///
/// [`crate::error::Error::WrongColumns`], [`crate::error::Error::NotFinite`], [`crate::error::Error::NoMemory`].
pub fn suppress(points: ArrayView2<'_, f64>, distance: f64) -> Result<Vec<usize>> {
    // A point in space, its survivor, and its entry in a cell.
    check_memory(&[points.nrows(), 72])?;
    let in_space = points_in_space(points)?;
    if distance.is_nan() || distance <= 0.0 {
        return Ok((0..in_space.len()).collect());
    }
    let layers: &[f64] = if points.ncols() == 3 { &[-1.0, 0.0, 1.0] } else { &[0.0] };
    // The last survivor of each cell, and for each the one before it: freeing a list for each cell would be slow.
    let mut last: FxHashMap<Cell, usize> = FxHashMap::default();
    let mut before: Vec<Option<usize>> = vec![None; in_space.len()];
    let mut survivors = Vec::with_capacity(in_space.len());
    for (index, point) in in_space.iter().enumerate() {
        interrupt::check();
        // Find the brightest survivor nearby.
        let is_near = |&other: &usize| point.distance_squared(in_space[other]) < distance * distance;
        let cell = (point / distance).floor();
        let near = layers.iter().flat_map(|&layer| around(cell, layer));
        let of_cell = |cell| successors(last.get(&cell).copied(), |&other| before[other]);
        let survivor = near.flat_map(of_cell).filter(is_near).min().unwrap_or(index);
        // Without one, the point survives: put it into its cell.
        if survivor == index {
            before[index] = last.insert(key(cell), index);
        }
        survivors.push(survivor);
    }
    Ok(survivors)
}

/// Coordinates of a cell, as the bits of its floats: integers would overflow for a tiny `distance`.
type Cell = (u64, u64, u64);

fn key(cell: DVec3) -> Cell {
    // Minus zero becomes zero. Swap the bytes: the last bits of a whole number's float are 0, and would stay 0 in the
    // hash, a product.
    let [x, y, z] = (cell + 0.0).to_array().map(|at| at.to_bits().swap_bytes());
    (x, y, z)
}

/// A cell and the 8 around it, in the `layer` above, below or its own.
fn around(cell: DVec3, layer: f64) -> impl Iterator<Item = Cell> {
    let step = move |i: u8| DVec3::new(f64::from(i % 3) - 1.0, f64::from(i / 3) - 1.0, layer);
    (0..9).map(move |i| key(cell + step(i)))
}
