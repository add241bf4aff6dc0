//! A map after a rotation. Its flux is kept, and that of each bright cell.
//!
//! A map is piecewise constant here: a pixel stands for its cell, as in the exact probe. Each new cell is the mean
//! over a grid of samples. Bright cells, which small lights are made of, are sampled more finely and scaled so that
//! each keeps its flux: the rest is turned and scaled to its own first, then they are added.

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

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

/// Samples along each side of a cell, and of one that may hold a part of a bright cell.
const SIDE: usize = 3;
const FINE_SIDE: usize = 16;
/// Samples of such a cell.
const FINE: f64 = (FINE_SIDE * FINE_SIDE) as f64;
/// A cell with more than this share of the flux of any channel, and this many times the mean radiance, is bright.
const BRIGHT_SHARE: f64 = 1e-4;
const BRIGHT_CONTRAST: f64 = 10.0;
/// With fewer hits, the solid angle of a cell is not known well enough: the cell is smaller than the new ones.
const ENOUGH_HITS: u64 = 64;

type Rgb = [f32; 3];

/// `radiance`, (height, width, 3) and cell-centred, after `rotation`: what was in the direction d is then in
/// `rotation * d`.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::NoMemory`].
#[allow(clippy::missing_panics_doc, reason = "each pixel has three samples")]
pub fn rotated(radiance: ArrayView3<'_, f32>, rotation: DMat3) -> Result<Array3<f32>> {
    let (height, width, _) = radiance.dim();
    check_rgb(radiance)?;
    sphere::check_memory(&[height, width, 6])?;
    let cells = Cells::new(height, width);
    let samples = samples_of(radiance, 0..height);
    let old = samples.as_chunks::<3>().0;
    // Turn the map without its bright cells.
    let bright = bright_cells(old, &cells);
    let rest = without(&bright, old, width);
    let mut new = means(&rest, &cells, rotation);
    let factors = ratio(flux(&rest, &cells), flux(&new, &cells));
    new.par_chunks_mut(width).for_each(|line| {
        interrupt::check();
        for rgb in line {
            *rgb = finite(scaled(*rgb, factors));
        }
    });
    // Add those.
    add_bright(&mut new, old, &bright, &cells, rotation);
    Ok(Array3::from_shape_vec((height, width, 3), new.into_flattened()).expect("three samples a pixel"))
}

/// The cells before a rotation that samples of the cells after it fall into.
struct Samples<'a> {
    cells: &'a Cells,
    side: usize,
    /// What the pole, and each azimuth on the equator, was before.
    pole: DVec3,
    equator: [Vec<f64>; 3],
    widest: Arch,
}

impl<'a> Samples<'a> {
    fn new(cells: &'a Cells, rotation: DMat3, side: usize) -> Self {
        let back = rotation.transpose();
        let azimuths = Registration::CellCentred.phis(cells.width * side);
        let before: Vec<DVec3> =
            azimuths.into_iter().map(|phi| back * sphere::direction(0.5 * PI, phi)).collect();
        let equator = std::array::from_fn(|axis| before.iter().map(|direction| direction[axis]).collect());
        Self { cells, side, pole: back * DVec3::Y, equator, widest: Arch::new() }
    }

    /// The old cells of the samples in some columns of a new row, by parallels and along them. The samples stand for
    /// equal solid angles: they are even in the cosine and in the azimuth.
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

    /// The old cells of a new cell, in their order, and how many samples are in each.
    fn counts(&self, cell: usize) -> Vec<(usize, u64)> {
        let (row, column) = (cell / self.cells.width, cell % self.cells.width);
        let mut met = self.of(row, column..column + 1);
        met.sort_unstable();
        met.chunk_by(|a, b| a == b).map(|same| (same[0], same.len() as u64)).collect()
    }
}

/// Diamond angles of places on the equator after they are moved to a parallel.
#[inline(always)]
fn parallel([x, y, z]: [&[f64]; 3], sine: f64, pole: [f64; 3], angles: &mut [[f64; 2]]) {
    for (((x, y), z), angles) in x.iter().zip(y).zip(z).zip(angles) {
        *angles = diamonds([sine * x + pole[0], sine * y + pole[1], sine * z + pole[2]]);
    }
}

/// The mean of `old` over each new cell, from a few samples.
fn means(old: &[Rgb], cells: &Cells, rotation: DMat3) -> Vec<Rgb> {
    let samples = Samples::new(cells, rotation, SIDE);
    let mut new = vec![[0.0; 3]; old.len()];
    new.par_chunks_mut(cells.width).enumerate().for_each(|(row, line)| {
        interrupt::check();
        let met = samples.of(row, 0..cells.width);
        for (column, rgb) in line.iter_mut().enumerate() {
            let mut sum = [0.0; 3];
            let parallels = met.chunks(SIDE * cells.width).map(|cells| &cells[SIDE * column..][..SIDE]);
            parallels.flatten().for_each(|&cell| add(&mut sum, old[cell].map(f64::from)));
            *rgb = sum.map(|value| (value / (SIDE * SIDE) as f64) as f32);
        }
    });
    new
}

/// The cells that keep their own flux.
fn bright_cells(old: &[Rgb], cells: &Cells) -> Vec<usize> {
    let flux = flux(old, cells);
    let in_row = |row: usize| {
        interrupt::check();
        let most = (BRIGHT_SHARE / cells.areas[row]).max(BRIGHT_CONTRAST / (4.0 * PI));
        let limits = flux.map(|flux| most * flux);
        let is_bright =
            move |rgb: &Rgb| rgb.iter().zip(limits).any(|(&value, limit)| f64::from(value) > limit);
        (row * cells.width..(row + 1) * cells.width).filter(move |&cell| is_bright(&old[cell]))
    };
    (0..cells.height).into_par_iter().flat_map_iter(in_row).collect()
}

/// The map `old` of this `width` with those cells black.
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

/// Add the `bright` cells of `old` to the turned map, each with its flux.
fn add_bright(new: &mut [Rgb], old: &[Rgb], bright: &[usize], cells: &Cells, rotation: DMat3) {
    if bright.is_empty() {
        return;
    }
    let places = places_of(bright, cells, rotation);
    // Measure how often each bright cell is met, and over what solid angle.
    let samples = Samples::new(cells, rotation, FINE_SIDE);
    let met: Vec<Vec<(usize, u64)>> =
        places.par_iter().map(|&place| bright_counts(&samples, place, bright)).collect();
    let (mut hits, mut measured) = (vec![0; bright.len()], vec![0.0; bright.len()]);
    for (&place, met) in places.iter().zip(&met) {
        for &(number, count) in met {
            hits[number] += count;
            measured[number] += count as f64 * cells.area(place) / FINE;
        }
    }
    // Scale these cells to their flux.
    for (&place, met) in places.iter().zip(&met) {
        let mut sum = new[place].map(f64::from);
        for &(number, count) in met.iter().filter(|(number, _)| hits[*number] >= ENOUGH_HITS) {
            let factor = cells.area(bright[number]) / measured[number] * count as f64 / FINE;
            add(&mut sum, scaled(old[bright[number]], [factor; 3]));
        }
        new[place] = finite(sum);
    }
    // Add the others cell by cell, from samples of the old cell.
    let few: Vec<usize> = (0..bright.len()).filter(|&number| hits[number] < ENOUGH_HITS).collect();
    if few.is_empty() {
        return;
    }
    let forward = Samples::new(cells, rotation.transpose(), FINE_SIDE);
    for cell in few.into_iter().map(|number| bright[number]) {
        for (place, count) in forward.counts(cell) {
            let factor = cells.area(cell) / cells.area(place) * count as f64 / FINE;
            let mut sum = new[place].map(f64::from);
            add(&mut sum, scaled(old[cell], [factor; 3]));
            new[place] = finite(sum);
        }
    }
}

/// Numbers of the bright cells in a new cell, and how many samples are in each.
fn bright_counts(samples: &Samples<'_>, place: usize, bright: &[usize]) -> Vec<(usize, u64)> {
    interrupt::check();
    let counts = samples.counts(place).into_iter();
    counts.filter_map(|(cell, count)| Some((bright.binary_search(&cell).ok()?, count))).collect()
}

/// New cells that may hold a part of a bright cell: those around its turned corners, middles of sides and centre.
fn places_of(bright: &[usize], cells: &Cells, rotation: DMat3) -> Vec<usize> {
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
        // Cells of a row are as narrow as its sine: of rows at the poles, all are near.
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
            add(&mut sum, scaled(rgb, [area; 3]));
        }
        sum
    });
    let mut total = [0.0; 3];
    rows.collect::<Vec<_>>().into_iter().for_each(|row| add(&mut total, row));
    total
}

/// `wanted` over `found`, channel by channel; 0 where nothing is found.
fn ratio(wanted: [f64; 3], found: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| if found[i] > 0.0 { wanted[i] / found[i] } else { 0.0 })
}

/// In single precision, and finite: sampled flux may be scaled up past its largest value.
fn finite(rgb: [f64; 3]) -> Rgb {
    rgb.map(|value| value.min(f64::from(f32::MAX)) as f32)
}

fn scaled(rgb: Rgb, factors: [f64; 3]) -> [f64; 3] {
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
        fn flux_is_kept(
            values in prop::collection::vec(0.0_f32..1.0, 8 * 16 * 3), suns in prop::collection::vec(0_usize..128, 0..4),
            axis in prop::array::uniform3(-1.0..1.0_f64), angle in 0.0..PI,
        ) {
            let axis = DVec3::from_array(axis);
            prop_assume!(axis.length() > 0.1);
            let mut map = Array3::from_shape_vec((8, 16, 3), values).unwrap();
            for sun in suns {
                map[[sun / 16, sun % 16, 1]] = 1e5;
            }
            let turned = rotated(map.view(), DMat3::from_axis_angle(axis.normalize(), angle)).unwrap();
            let areas = Cells::new(8, 16).areas;
            let flux = |map: &Array3<f32>, channel: usize| -> f64 {
                map.indexed_iter()
                    .filter(|((_, _, i), _)| *i == channel)
                    .map(|((row, _, _), &value)| f64::from(value) * areas[row])
                    .sum()
            };
            for channel in 0..3 {
                let (seen, wanted) = (flux(&turned, channel), flux(&map, channel));
                prop_assert!((seen / wanted - 1.0).abs() < 1e-6, "{seen} {wanted}");
            }
        }
    }

    #[test]
    fn a_map_near_the_largest_float_stays_finite() {
        let map = Array3::from_shape_fn((8, 16, 3), |(row, _, _)| if row < 4 { f32::MAX } else { 0.0 });
        let turned = rotated(map.view(), DMat3::from_rotation_x(0.3)).unwrap();
        assert!(turned.iter().all(|value| value.is_finite()));
    }
}
