//! Step 7 of Loghin (2021): samples near a brighter one.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use glam::DVec3;
use ndarray::ArrayView2;

use super::places;
use crate::error::Result;

/// For each of `points`, (n, 2) or (n, 3), brightest first, the survivor that it belongs to: itself,
/// or the brightest survivor closer than `distance`.
///
/// Only survivors suppress. Cells of the size of `distance` hold them, so a point is compared with
/// those in its own and the touching cells alone: few, for survivors are far apart.
///
/// # Errors
///
/// [`crate::error::Error::WrongColumns`], [`crate::error::Error::NotFinite`].
pub fn suppress(points: ArrayView2<'_, f64>, distance: f64) -> Result<Vec<usize>> {
    let points_in_space = places(points)?;
    if distance.is_nan() || distance <= 0.0 {
        return Ok((0..points_in_space.len()).collect());
    }
    let layers: &[f64] = if points.ncols() == 3 { &[-1.0, 0.0, 1.0] } else { &[0.0] };
    let mut cells: HashMap<Cell, Vec<usize>, BuildHasherDefault<CellHasher>> = HashMap::default();
    let mut survivor = Vec::with_capacity(points_in_space.len());
    for (index, point) in points_in_space.iter().enumerate() {
        let is_near = |&other: &usize| point.distance_squared(points_in_space[other]) < distance * distance;
        let cell = (point / distance).floor();
        let near = layers.iter().flat_map(|&layer| around(cell, layer));
        let near = near.filter_map(|cell| cells.get(&cell)).flatten().copied().filter(is_near);
        let home = near.min().unwrap_or(index);
        if home == index {
            cells.entry(key(cell)).or_default().push(index);
        }
        survivor.push(home);
    }
    Ok(survivor)
}

/// A cell's place, as the bits of its floats: whole numbers would end where a `distance` is tiny.
type Cell = (i64, i64, i64);

fn key(cell: DVec3) -> Cell {
    // Minus zero becomes zero.
    let [x, y, z] = (cell + 0.0).to_array().map(|at| at.to_bits().cast_signed());
    (x, y, z)
}

/// A cell and the 8 around it, in the `layer` above, below or its own.
fn around(cell: DVec3, layer: f64) -> impl Iterator<Item = Cell> {
    let step = move |i: u8| DVec3::new(f64::from(i % 3) - 1.0, f64::from(i / 3) - 1.0, layer);
    (0..9).map(move |i| key(cell + step(i)))
}

/// A few instructions for three whole numbers; the standard hash took most of the step's time.
#[derive(Default)]
struct CellHasher(u64);

impl Hasher for CellHasher {
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_i64(i64::from(byte));
        }
    }

    fn write_i64(&mut self, number: i64) {
        // An odd number near 2^64 over the golden ratio spreads neighbours far (Knuth, 6.4).
        self.0 = (self.0.rotate_left(21) ^ number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }

    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 32)
    }
}
