//! Rotation of a map that preserves its flux, and the flux of each bright cell.
//!
//! The map is piecewise constant, with one value in each cell, as in the exact probe. Each new cell is the mean over a
//! grid of samples. Bright cells, which small lights consist of, are sampled more finely. The rest is rotated and scaled
//! to its flux first, then the bright cells are added, each scaled to its flux.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use glam::{DMat3, DVec3};
use ndarray::{Array3, ArrayView3};
use pulp::Arch;
use rayon::prelude::*;

use super::block_rows::samples_of;
use super::cells::{Cells, diamonds};
use super::samples::check_rgb;
use crate::error::Result;
use crate::interrupt;
use crate::kernels::sphere::{self, Registration};

/// Settings of a rotation.
struct RotationSettings {
    /// Samples along each side of a cell.
    side: usize,
    /// Samples along each side of a cell that may hold a part of a bright cell.
    fine_side: usize,
    /// A bright cell has more than this fraction of the flux of any channel.
    bright_fraction: f64,
    /// Least ratio of a bright cell to the mean radiance.
    bright_contrast: f64,
    /// Hits from which on the sampled solid angle of a cell is accurate; a cell with fewer is smaller than the new ones.
    enough_hits: u64,
}

const ROTATION: RotationSettings = RotationSettings {
    side: 3,
    fine_side: 16,
    bright_fraction: 1e-4,
    bright_contrast: 10.0,
    enough_hits: 64,
};

impl RotationSettings {
    /// Samples of a cell that may hold a part of a bright cell.
    const fn fine(&self) -> f64 {
        (self.fine_side * self.fine_side) as f64
    }
}

type Rgb = [f32; 3];

/// Rotate `radiance`, (height, width, 3) and cell-centred: light from the direction d then comes from `rotation * d`.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::NoMemory`].
#[allow(clippy::missing_panics_doc, reason = "each pixel has three samples")]
pub fn rotate(radiance: ArrayView3<'_, f32>, rotation: DMat3) -> Result<Array3<f32>> {
    let (height, width, _) = radiance.dim();
    check_rgb(radiance)?;
    sphere::check_memory(&[height, width, 6])?;
    let cells = Cells::new(height, width);
    let samples = samples_of(radiance, 0..height);
    let old = samples.as_chunks::<3>().0;
    // Rotate the map without its bright cells.
    let bright = bright_cells(old, &cells);
    let rest = without(&bright, old, width);
    let mut new = means(&rest, &cells, rotation);
    let factors = ratio(flux(&rest, &cells), flux(&new, &cells));
    new.par_chunks_mut(width).for_each(|line| {
        interrupt::check();
        for rgb in line {
            *rgb = finite(scale(*rgb, factors));
        }
    });
    // Add the bright cells.
    add_bright(&mut new, old, &bright, &cells, rotation);
    Ok(Array3::from_shape_vec((height, width, 3), new.into_flattened()).expect("three samples a pixel"))
}

/// Samples of the cells after a rotation, and the cells before it that hold them.
struct RotatedGrid<'a> {
    cells: &'a Cells,
    side: usize,
    /// Directions before the rotation of the new pole and of the azimuths on the new equator.
    pole: DVec3,
    equator: [Vec<f64>; 3],
    widest: Arch,
}

impl<'a> RotatedGrid<'a> {
    fn new(cells: &'a Cells, rotation: DMat3, side: usize) -> Self {
        let back = rotation.transpose();
        let azimuths = Registration::CellCentred.phis(cells.width * side);
        let before: Vec<DVec3> =
            azimuths.into_iter().map(|phi| back * sphere::direction(0.5 * PI, phi)).collect();
        let equator = std::array::from_fn(|axis| before.iter().map(|direction| direction[axis]).collect());
        Self { cells, side, pole: back * DVec3::Y, equator, widest: Arch::new() }
    }

    /// The old cells of the samples in some columns of a new row, by parallels and along them.
    ///
    /// The samples have equal solid angles: they are even in the cosine and in the azimuth.
    fn of(&self, row: usize, columns: Range<usize>) -> Vec<usize> {
        let (top, bottom) = (self.cells.cosines[row], self.cells.cosines[row + 1]);
        let columns = columns.start * self.side..columns.end * self.side;
        let equator = self.equator.each_ref().map(|axis| &axis[columns.clone()]);
        let mut angles = vec![[0.0; 2]; columns.len()];
        let mut old = Vec::with_capacity(columns.len() * self.side);
        for i in 0..self.side {
            let cosine = top + (bottom - top) * (i as f64 + 0.5) / self.side as f64;
            let (pole, sine) = (cosine * self.pole, (1.0 - cosine * cosine).max(0.0).sqrt());
            self.widest.dispatch(|| parallel(equator, sine, pole.to_array(), &mut angles));
            old.extend(angles.iter().map(|&angles| self.cells.at(angles)));
        }
        old
    }

    /// The old cells of a new cell, in their order, each with its number of samples.
    fn counts(&self, cell: usize) -> Vec<(usize, u64)> {
        let (row, column) = (cell / self.cells.width, cell % self.cells.width);
        let mut met = self.of(row, column..column + 1);
        met.sort_unstable();
        met.chunk_by(|a, b| a == b).map(|same| (same[0], same.len() as u64)).collect()
    }
}

/// Diamond angles of points of the equator after they are moved to a parallel.
#[inline(always)]
fn parallel([x, y, z]: [&[f64]; 3], sine: f64, pole: [f64; 3], angles: &mut [[f64; 2]]) {
    for (((x, y), z), angles) in x.iter().zip(y).zip(z).zip(angles) {
        *angles = diamonds([sine * x + pole[0], sine * y + pole[1], sine * z + pole[2]]);
    }
}

/// The mean of `old` over each new cell, from a few samples.
fn means(old: &[Rgb], cells: &Cells, rotation: DMat3) -> Vec<Rgb> {
    let samples = RotatedGrid::new(cells, rotation, ROTATION.side);
    let mut new = vec![[0.0; 3]; old.len()];
    new.par_chunks_mut(cells.width).enumerate().for_each(|(row, line)| {
        interrupt::check();
        let met = samples.of(row, 0..cells.width);
        for (column, rgb) in line.iter_mut().enumerate() {
            let mut sum = [0.0; 3];
            let parallels = met
                .chunks(ROTATION.side * cells.width)
                .map(|cells| &cells[ROTATION.side * column..][..ROTATION.side]);
            parallels.flatten().for_each(|&cell| add(&mut sum, old[cell].map(f64::from)));
            *rgb = sum.map(|value| (value / (ROTATION.side * ROTATION.side) as f64) as f32);
        }
    });
    new
}

/// Cells whose own flux is preserved.
fn bright_cells(old: &[Rgb], cells: &Cells) -> Vec<usize> {
    let flux = flux(old, cells);
    let in_row = |row: usize| {
        interrupt::check();
        let most = (ROTATION.bright_fraction / cells.areas[row]).max(ROTATION.bright_contrast / (4.0 * PI));
        let limits = flux.map(|flux| most * flux);
        let is_bright =
            move |rgb: &Rgb| rgb.iter().zip(limits).any(|(&value, limit)| f64::from(value) > limit);
        (row * cells.width..(row + 1) * cells.width).filter(move |&cell| is_bright(&old[cell]))
    };
    (0..cells.height).into_par_iter().flat_map_iter(in_row).collect()
}

/// The map `old` of this `width`, with black `bright` cells.
fn without(bright: &[usize], old: &[Rgb], width: usize) -> Vec<Rgb> {
    let mut rest = vec![[0.0; 3]; old.len()];
    rest.par_chunks_mut(width).zip(old.par_chunks(width)).for_each(|(rest, old)| {
        interrupt::check();
        rest.copy_from_slice(old);
    });
    for &cell in bright {
        rest[cell] = [0.0; 3];
    }
    rest
}

/// Add the `bright` cells of `old` to the rotated map, each with its flux.
fn add_bright(new: &mut [Rgb], old: &[Rgb], bright: &[usize], cells: &Cells, rotation: DMat3) {
    if bright.is_empty() {
        return;
    }
    let new_cells = new_cells_of(bright, cells, rotation);
    // Count the samples in each bright cell, and sum their solid angle.
    let samples = RotatedGrid::new(cells, rotation, ROTATION.fine_side);
    let met: Vec<Vec<(usize, u64)>> =
        new_cells.par_iter().map(|&new_cell| bright_counts(&samples, new_cell, bright)).collect();
    let (mut hits, mut measured) = (vec![0; bright.len()], vec![0.0; bright.len()]);
    for (&new_cell, met) in new_cells.iter().zip(&met) {
        for &(number, count) in met {
            hits[number] += count;
            measured[number] += count as f64 * cells.area(new_cell) / ROTATION.fine();
        }
    }
    // Scale these cells to their flux.
    for (&new_cell, met) in new_cells.iter().zip(&met) {
        let mut sum = new[new_cell].map(f64::from);
        for &(number, count) in met.iter().filter(|(number, _)| hits[*number] >= ROTATION.enough_hits) {
            let factor = cells.area(bright[number]) / measured[number] * count as f64 / ROTATION.fine();
            add(&mut sum, scale(old[bright[number]], [factor; 3]));
        }
        new[new_cell] = finite(sum);
    }
    // Add the others cell by cell, from samples of the old cell.
    let few: Vec<usize> = (0..bright.len()).filter(|&number| hits[number] < ROTATION.enough_hits).collect();
    if few.is_empty() {
        return;
    }
    let forward = RotatedGrid::new(cells, rotation.transpose(), ROTATION.fine_side);
    for cell in few.into_iter().map(|number| bright[number]) {
        for (new_cell, count) in forward.counts(cell) {
            let factor = cells.area(cell) / cells.area(new_cell) * count as f64 / ROTATION.fine();
            let mut sum = new[new_cell].map(f64::from);
            add(&mut sum, scale(old[cell], [factor; 3]));
            new[new_cell] = finite(sum);
        }
    }
}

/// Numbers of the bright cells in a new cell, each with its number of samples.
fn bright_counts(samples: &RotatedGrid<'_>, new_cell: usize, bright: &[usize]) -> Vec<(usize, u64)> {
    interrupt::check();
    let counts = samples.counts(new_cell).into_iter();
    counts.filter_map(|(cell, count)| Some((bright.binary_search(&cell).ok()?, count))).collect()
}

/// New cells that may hold a part of a bright cell: those around its rotated corners, middles of sides and centre.
fn new_cells_of(bright: &[usize], cells: &Cells, rotation: DMat3) -> Vec<usize> {
    let mut marked = vec![false; cells.height * cells.width];
    for &cell in bright {
        interrupt::check();
        let (row, column) = (cell / cells.width, cell % cells.width);
        for (down, across) in (0..9).map(|i| (f64::from(i / 3) / 2.0, f64::from(i % 3) / 2.0)) {
            let theta = PI * (row as f64 + down) / cells.height as f64;
            let phi = TAU * (column as f64 + across) / cells.width as f64;
            let turned = rotation * sphere::direction(theta, phi);
            mark_around(cells.at(diamonds(turned.to_array())), cells, &mut marked);
        }
    }
    (0..marked.len()).filter(|&cell| marked[cell]).collect()
}

/// Mark the cells within one row of `cell`, and as far along the rows.
fn mark_around(cell: usize, cells: &Cells, marked: &mut [bool]) {
    let (row, column, width) = (cell / cells.width, cell % cells.width, cells.width);
    for row in row.saturating_sub(1)..(row + 2).min(cells.height) {
        // The cells of a row narrow with its sine: near the poles, mark all of a row.
        let sine = (PI * (row as f64 + 0.5) / cells.height as f64).sin();
        let reach = ((1.5 / sine).ceil() as usize).min(width / 2);
        for step in 0..=2 * reach {
            marked[row * width + (column + width + step - reach) % width] = true;
        }
    }
}

/// Flux of each channel, summed by rows and then in their order.
fn flux(map: &[Rgb], cells: &Cells) -> [f64; 3] {
    let rows = map.par_chunks(cells.width).zip(&cells.areas).map(|(line, &area)| {
        interrupt::check();
        let mut sum = [0.0; 3];
        for &rgb in line {
            add(&mut sum, scale(rgb, [area; 3]));
        }
        sum
    });
    let mut total = [0.0; 3];
    rows.collect::<Vec<_>>().into_iter().for_each(|row| add(&mut total, row));
    total
}

/// `above` over `below`, channel by channel; 0 for a channel without flux.
fn ratio(above: [f64; 3], below: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| if below[i] > 0.0 { above[i] / below[i] } else { 0.0 })
}

/// Single precision, limited to its largest value, because scaled samples may exceed it.
fn finite(rgb: [f64; 3]) -> Rgb {
    rgb.map(|value| value.min(f64::from(f32::MAX)) as f32)
}

fn scale(rgb: Rgb, factors: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| f64::from(rgb[i]) * factors[i])
}

fn add(sum: &mut [f64; 3], other: [f64; 3]) {
    sum.iter_mut().zip(other).for_each(|(sum, value)| *sum += value);
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn flux_is_preserved(
            values in prop::collection::vec(0.0_f32..1.0, 8 * 16 * 3), suns in prop::collection::vec(0_usize..128, 0..4),
            axis in prop::array::uniform3(-1.0..1.0_f64), angle in 0.0..PI,
        ) {
            let axis = DVec3::from_array(axis);
            prop_assume!(axis.length() > 0.1);
            let mut map = Array3::from_shape_vec((8, 16, 3), values).unwrap();
            for sun in suns {
                map[[sun / 16, sun % 16, 1]] = 1e5;
            }
            let turned = rotate(map.view(), DMat3::from_axis_angle(axis.normalize(), angle)).unwrap();
            let areas = Cells::new(8, 16).areas;
            let flux = |map: &Array3<f32>, channel: usize| -> f64 {
                map.indexed_iter()
                    .filter(|((_, _, i), _)| *i == channel)
                    .map(|((row, _, _), &value)| f64::from(value) * areas[row])
                    .sum()
            };
            for channel in 0..3 {
                let (measured, expected) = (flux(&turned, channel), flux(&map, channel));
                prop_assert!((measured / expected - 1.0).abs() < 1e-6, "{measured} {expected}");
            }
        }
    }

    #[test]
    fn a_map_near_the_largest_float_stays_finite() {
        let map = Array3::from_shape_fn((8, 16, 3), |(row, _, _)| if row < 4 { f32::MAX } else { 0.0 });
        let turned = rotate(map.view(), DMat3::from_rotation_x(0.3)).unwrap();
        assert!(turned.iter().all(|value| value.is_finite()));
    }
}
