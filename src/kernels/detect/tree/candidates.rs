//! Candidates for places of low contrast: groups of broad cells that stand out of what is around them.
//!
//! The map is averaged to 64 columns of cells. From each peak among the cells, the brightest first, a fill takes the
//! connected cells above
//!
//! ```text
//!   peak / 1.35
//! ```
//!
//! It ends where it has taken more of the sphere than a place may cover, or reaches what such a fill has taken: a dimmer
//! peak's fill would take all of that. What is left are islands, and each is a candidate whose flux and whose contrast to
//! the cells around it are large enough. Where no cell stands out, a map is asked no more than that.

use std::ops::Range;

use rayon::prelude::*;

use super::adjacency::Adjacency;
use super::background::median;
use super::top::height;
use super::working_image::WorkingImage;

/// Columns of cells, about.
const COLUMNS: usize = 64;
/// The mean of a cell is taken over one in this many rows: places are broad, and noise averages out.
const EVERY: usize = 8;
/// The fill ends where cells have fallen to the peak's luminance over this. A cell that a place of 2.5 times its
/// background covers by 0.4, the brightest of the smallest, is 1.6 times as bright.
const ISLAND: f32 = 1.35;
/// Least ratio of the peak to the cells two cells out.
const LEAST_CONTRAST: f32 = 1.5;
/// A place has at most this many times the solid angle of its island and the cells around that.
const SPARE: f64 = 2.0;
/// Distance of the background from the rim of an island, in cells.
const DISTANCE: usize = 2;

/// Pixels of the working image: those of one cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    pub rows: Range<usize>,
    pub columns: Range<usize>,
}

/// What stands out: where, and before which background.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Its brightest cell.
    pub cell: Cell,
    /// Mean luminance of that cell.
    pub peak: f32,
    /// Luminance of what is around the island.
    pub background: f32,
    /// Solid angle that its place may have.
    pub largest: f64,
}

/// Find the candidates that may hold `least_flux` on at most the solid angle `largest`, the brightest first; no pixel of their
/// brightest cell has a `label`.
pub fn candidates(working: &WorkingImage, label: &[u32], least_flux: f64, largest: f64) -> Vec<Candidate> {
    let cells = cells(working);
    let adjacency = Adjacency::of(&cells);
    let mut islands = Islands::new(&cells, &adjacency, largest);
    let mut found = Vec::new();
    for peak in peaks(&cells, &adjacency, least_flux / largest / f64::from(ISLAND)) {
        let cell = Cell::of(working, &cells, peak);
        if cell.rows(label, working.size.1).flatten().any(|&label| label != 0) {
            continue;
        }
        let Some(island) = islands.around(peak) else { continue };
        let background = islands.background(&island.cells);
        if cells.luminance[peak] >= LEAST_CONTRAST * background && island.flux >= least_flux {
            let largest = largest.min(SPARE * island.solid_angle);
            found.push(Candidate { cell, peak: cells.luminance[peak], background, largest });
        }
    }
    found
}

impl Cell {
    fn of(working: &WorkingImage, cells: &WorkingImage, index: usize) -> Self {
        let side = cells.block / working.block;
        let first = (index / cells.size.1 * side, index % cells.size.1 * side);
        let end = ((first.0 + side).min(working.size.0), (first.1 + side).min(working.size.1));
        Self { rows: first.0..end.0, columns: first.1..end.1 }
    }

    /// Its rows in an image of `width` columns.
    pub fn rows<'a, T>(&self, image: &'a [T], width: usize) -> impl Iterator<Item = &'a [T]> {
        let columns = self.columns.clone();
        self.rows.clone().map(move |row| &image[row * width..][columns.clone()])
    }
}

/// The mean luminance of squares of pixels.
fn cells(working: &WorkingImage) -> WorkingImage {
    let width = working.size.1;
    let side = width.div_ceil(COLUMNS);
    let grid = working.grid.in_blocks(side);
    let columns = width.div_ceil(side);
    let mut luminance = vec![0.0; working.size.0.div_ceil(side) * columns];
    let rows = working.luminance.par_chunks(side * width);
    luminance.par_chunks_mut(columns).zip(rows).for_each(|(means, rows)| {
        let mut sums = vec![0.0_f32; width];
        let mut count = 0;
        for row in rows.chunks_exact(width).step_by(EVERY) {
            sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
            count += 1;
        }
        for (mean, sums) in means.iter_mut().zip(sums.chunks(side)) {
            *mean = sum(sums) / (count * sums.len()) as f32;
        }
    });
    WorkingImage::of_luminance(grid, working.block * side, luminance)
}

/// Sum in four lanes that do not wait for one another.
fn sum(values: &[f32]) -> f32 {
    let (fours, rest) = values.as_chunks::<4>();
    let mut lanes = [0.0_f32; 4];
    for four in fours {
        lanes.iter_mut().zip(four).for_each(|(lane, value)| *lane += value);
    }
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]) + rest.iter().sum::<f32>()
}

/// Cells above all their neighbours and of the luminance `least` or more, the brightest first.
fn peaks(cells: &WorkingImage, adjacency: &Adjacency, least: f64) -> Vec<usize> {
    let luminance = &cells.luminance;
    let is_peak = |&index: &usize| {
        let own = height(luminance, index);
        adjacency.around(index).into_iter().all(|other| height(luminance, other) <= own)
    };
    // Most cells are too dark, or below the next one: before a row and after it is a neighbour across the seam.
    let (least, last) = ((least as f32).max(f32::MIN_POSITIVE), luminance.len() - 1);
    let may_be = |&index: &usize| {
        let own = luminance[index];
        own >= least && own >= luminance[(index + 1).min(last)] && own >= luminance[index.saturating_sub(1)]
    };
    let mut peaks: Vec<usize> = (0..=last).filter(may_be).filter(is_peak).collect();
    peaks.sort_unstable_by_key(|&peak| !height(luminance, peak));
    peaks
}

/// What a fill has found out about a cell.
#[derive(Clone, Copy, PartialEq)]
enum Taken {
    Free,
    /// By an island, with its number.
    Island(u32),
    /// By a fill that took too much.
    Open,
}

/// Cells that stand out together.
struct Island {
    cells: Vec<usize>,
    /// Flux and solid angle of them and of the cells around them, which the place may cut.
    flux: f64,
    solid_angle: f64,
}

struct Islands<'a> {
    cells: &'a WorkingImage,
    adjacency: &'a Adjacency,
    /// Solid angle of a cell of each row.
    solid_angles: Vec<f64>,
    /// How many columns of each row are as wide as `DISTANCE` rows are high.
    distances: Vec<usize>,
    /// Largest solid angle of an island.
    largest: f64,
    taken: Vec<Taken>,
    /// For each cell the last island that it is around.
    around: Vec<u32>,
    count: u32,
}

impl<'a> Islands<'a> {
    fn new(cells: &'a WorkingImage, adjacency: &'a Adjacency, largest: f64) -> Self {
        let across = std::f64::consts::TAU / cells.size.1 as f64;
        let solid_angles = cells.bands.iter().map(|band| band * across).collect();
        let distances = (0..cells.size.0).map(|row| cells.columns_across(row, DISTANCE)).collect();
        let taken = vec![Taken::Free; cells.luminance.len()];
        let around = vec![0; cells.luminance.len()];
        Self { cells, adjacency, solid_angles, distances, largest, taken, around, count: 0 }
    }

    /// The island around a peak; none where it is not one, or where another fill has taken the peak.
    fn around(&mut self, peak: usize) -> Option<Island> {
        if self.taken[peak] != Taken::Free {
            return None;
        }
        self.count += 1;
        let own = Taken::Island(self.count);
        let shore = self.cells.luminance[peak] / ISLAND;
        let (mut flux, mut with_shore) = (self.flux(peak), self.solid_angle(peak));
        let (mut island, mut solid_angle, mut next) = (vec![peak], 0.0, 0);
        self.taken[peak] = own;
        while let Some(&cell) = island.get(next) {
            next += 1;
            solid_angle += self.solid_angle(cell);
            for other in self.adjacency.around(cell) {
                if self.taken[other] == own || self.around[other] == self.count {
                    continue;
                }
                flux += self.flux(other);
                with_shore += self.solid_angle(other);
                if self.cells.luminance[other] < shore {
                    self.around[other] = self.count;
                    continue;
                }
                if self.taken[other] == Taken::Open || solid_angle > self.largest {
                    for cell in island {
                        self.taken[cell] = Taken::Open;
                    }
                    return None;
                }
                self.taken[other] = own;
                island.push(other);
            }
        }
        Some(Island { cells: island, flux, solid_angle: with_shore })
    }

    fn solid_angle(&self, cell: usize) -> f64 {
        self.solid_angles[cell / self.cells.size.1]
    }

    fn flux(&self, cell: usize) -> f64 {
        f64::from(self.cells.luminance[cell]) * self.solid_angle(cell)
    }

    /// Median luminance of the cells straight out from the rim of an island.
    fn background(&self, island: &[usize]) -> f32 {
        let own = self.taken[island[0]];
        let mut outside: Vec<f32> = Vec::new();
        for &cell in island {
            let columns = self.distances[cell / self.cells.size.1];
            let beyond = self.adjacency.beyond(cell, DISTANCE, columns);
            for (side, beyond) in self.adjacency.sides(cell).into_iter().zip(beyond) {
                if self.taken[side] != own && self.taken[beyond] != own {
                    outside.push(self.cells.luminance[beyond]);
                }
            }
        }
        median(&mut outside) as f32
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::f64::consts::PI;

    use super::super::test_maps::drawn;
    use super::*;

    /// 128 x 256 pixels with a square of `side` pixels and of this luminance, before 1.
    fn square(side: usize, luminance: char) -> WorkingImage {
        let is_inside = |y: usize, x: usize| y.abs_diff(60) < side / 2 && x.abs_diff(100) < side / 2;
        let pixel = |y: usize, x: usize| if is_inside(y, x) { luminance } else { '1' };
        let rows: Vec<String> = (0..128).map(|y| (0..256).map(|x| pixel(y, x)).collect()).collect();
        drawn(&rows.iter().map(String::as_str).collect::<Vec<_>>())
    }

    fn found(working: &WorkingImage, label: u32, least_share: f64) -> Vec<Candidate> {
        let label = vec![label; working.luminance.len()];
        candidates(working, &label, least_share * working.flux, 0.5)
    }

    #[test]
    fn a_cell_is_the_mean_of_its_pixels() {
        let working = square(16, '3');
        let cells = cells(&working);
        assert_eq!(cells.size, (32, 64));
        assert!((cells.luminance[15 * 64 + 25] - 3.0).abs() < 1e-6);
        assert!((cells.luminance[3 * 64 + 25] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_square_before_a_darker_ground_is_a_candidate() {
        let (working, width) = (square(16, '3'), 256);
        let [candidate] = &found(&working, 0, 0.01)[..] else { panic!("one candidate") };
        assert!((candidate.peak - 3.0).abs() < 1e-6 && (candidate.background - 1.0).abs() < 1e-6);
        assert!(candidate.cell.rows(&working.luminance, width).flatten().all(|&value| value > 2.9));
        assert!(candidate.largest > 16.0 * 16.0 * (PI / 128.0).powi(2));
    }

    #[test]
    fn what_is_labelled_large_of_little_flux_or_of_little_contrast_is_none() {
        assert!(found(&square(16, '3'), 1, 0.01).is_empty());
        assert!(found(&square(60, '3'), 0, 0.01).is_empty());
        assert!(found(&square(16, '3'), 0, 0.1).is_empty());
        assert!(found(&square(16, '1'), 0, 0.01).is_empty());
    }
}
