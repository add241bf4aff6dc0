//! Step 7 of Loghin (2021): samples near a brighter one.

use std::collections::HashMap;

use ndarray::{ArrayView1, ArrayView2, Axis};

use crate::error::Result;
use crate::kernels::sphere::check_rows;

/// For each of `points`, (n, 2) or (n, 3), brightest first, the survivor that it belongs to: itself,
/// or the brightest survivor closer than `distance`.
///
/// Only survivors suppress. Cells of the size of `distance` hold them, so a point is compared with
/// those in its own and the touching cells alone.
///
/// # Errors
///
/// [`crate::error::Error::WrongColumns`], [`crate::error::Error::NotFinite`].
pub fn suppress(points: ArrayView2<'_, f64>, distance: f64) -> Result<Vec<usize>> {
    check_rows("points", points, if points.ncols() == 3 { 3 } else { 2 })?;
    if distance.is_nan() || distance <= 0.0 {
        return Ok((0..points.nrows()).collect());
    }
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let mut survivor = Vec::with_capacity(points.nrows());
    for (index, point) in points.axis_iter(Axis(0)).enumerate() {
        let cell = cell_of(point, distance);
        let is_near = |&other: &usize| squared_distance(point, points.row(other)) < distance * distance;
        let near = around(cell).filter_map(|cell| cells.get(&cell)).flatten().copied().filter(is_near);
        let home = near.min().unwrap_or(index);
        if home == index {
            cells.entry(cell).or_default().push(index);
        }
        survivor.push(home);
    }
    Ok(survivor)
}

fn cell_of(point: ArrayView1<'_, f64>, size: f64) -> [i64; 3] {
    [0, 1, 2].map(|axis| point.get(axis).map_or(0, |x| (x / size).floor() as i64))
}

/// A cell and the 26 that touch it.
fn around([x, y, z]: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    let near = |i: i64| [i.saturating_sub(1), i, i.saturating_add(1)];
    near(x).into_iter().flat_map(move |x| near(y).into_iter().flat_map(move |y| near(z).map(|z| [x, y, z])))
}

pub(super) fn squared_distance(one: ArrayView1<'_, f64>, other: ArrayView1<'_, f64>) -> f64 {
    one.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum()
}
