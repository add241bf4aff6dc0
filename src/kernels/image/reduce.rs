//! Reduction of a map to fewer cells, for approximate probes.

use std::array::from_fn;
use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use ndarray::{Array3, ArrayView3, Axis, s};
use rayon::prelude::*;

use super::block_rows::BlockRow;
use super::grid::Grid;
use super::parts::{BrightCell, PART_SHARE, Part, Pixel, PixelBlock, parts};
use super::samples::check_samples;
use crate::error::Result;
use crate::kernels::sphere::{Registration, angles, band_heights};

/// A map in fewer cells, for approximate probes.
#[derive(Clone, Debug)]
pub struct WorkingMap {
    /// Mean radiance of each cell by solid angle, (rows, columns, 3); 0 where the cell became a source.
    pub radiance: Array3<f32>,
    /// Edges of the cells.
    pub grid: Grid,
    /// Vector irradiance of the cells that became sources, (n, 3 axes, 3 channels).
    pub sources: Array3<f64>,
    /// Rows and columns of other bright cells, whose light is in `radiance`.
    pub bright: Vec<(usize, usize)>,
    /// The light of sources and bright cells in parts, so that a sun of a few pixels has its shape, and a lamp its rim.
    pub parts: Vec<Part>,
    /// Sides of a pixel of the map itself.
    pub pixel: Pixel,
}

impl WorkingMap {
    /// Spread of the light of one pixel of the map in a direction: the mean of 1 - cos.
    pub fn pixel_spread(&self, direction: DVec3) -> f64 {
        self.pixel.spread(angles(direction).0)
    }
}

/// Reduce `radiance` to at most `columns` columns, with its bright cells as point sources.
///
/// The light of a cell on the horizon of a normal is smeared over the width of the cell, which matters only for a cell with
/// much light. So each cell with more than `source_share` of the flux of any channel becomes a source with the vector
/// `F = integral of L w dw` over its pixels. `max(0, n.F)` is exact for a sun of one pixel at any position in its cell.
/// Shadows depend on the shape of a light as well, so the map also has parts of these and of other bright cells.
///
/// A floor hides all light from below the horizon. A row on the horizon keeps the part of its flux that is above it.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`] when the array is not (height, width, 3) or smaller than 2 x 2;
/// [`crate::error::Error::UnusableSamples`]: this pass reads all samples.
pub fn reduce(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    columns: usize,
    source_share: f64,
    has_floor: bool,
) -> Result<WorkingMap> {
    let (pixels, grid, block) = Grid::of_map(radiance, registration, columns)?;
    let (height, width, _) = radiance.dim();
    let mut flux = Flux::new(radiance, &pixels, block)?;
    if has_floor {
        flux.hide_below(&grid);
    }
    let whole = flux.whole();
    let cells = flux.sources(whole, source_share);
    for &cell in &cells {
        flux.remove(cell);
    }
    let (means, bright) = flux.means(&grid);
    let (pixel, worth) = (Pixel::of(&pixels), PART_SHARE * whole.iter().sum::<f64>());
    let apart = |&(row, column): &(usize, usize)| {
        let rows = row * block..((row + 1) * block).min(height);
        let columns = column * block..((column + 1) * block).min(width);
        BrightCell::new(&PixelBlock { rows, columns }, radiance, &pixels, worth, pixel)
    };
    let apart_cells: Vec<BrightCell> = cells.par_iter().chain(&bright).map(apart).collect();
    let is_seen = |part: &Part| !has_floor || part.is_up();
    let sources = Array3::from_shape_fn((cells.len(), 3, 3), |(i, axis, c)| {
        let BrightCell { whole, .. } = &apart_cells[i];
        if is_seen(whole) { whole.irradiance[axis][c] } else { 0.0 }
    });
    let mut parts = parts(apart_cells);
    parts.retain(is_seen);
    Ok(WorkingMap { radiance: means, grid, sources, bright, parts, pixel })
}

/// Least ratio of a bright cell to the mean of all cells.
const CONTRAST: f64 = 8.0;

/// Integral of the radiance over each cell.
struct Flux {
    /// (rows, columns, 3)
    cells: Array3<f64>,
    /// Integral over each row.
    rows: Vec<[f64; 3]>,
}

impl Flux {
    /// Integrals over the blocks of a map's pixels.
    fn new(radiance: ArrayView3<'_, f32>, pixels: &Grid, block: usize) -> Result<Self> {
        let (height, width, _) = radiance.dim();
        let widths = pixels.widths();
        let mut cells = Array3::zeros((height.div_ceil(block), width.div_ceil(block), 3));
        let rows = rows_mut(&mut cells).enumerate().map(|(row, cells)| {
            let has_signs =
                add_across(cells, &BlockRow::new(radiance, &pixels.theta_edges, block, row), &widths, block);
            (has_signs, sum(cells))
        });
        let (signs, rows): (Vec<bool>, Vec<[f64; 3]>) = rows.unzip();
        // NaN and infinity persist in every sum.
        if signs.contains(&true) || !rows.as_flattened().iter().all(|sum| sum.is_finite()) {
            check_samples(radiance)?;
        }
        Ok(Self { cells, rows })
    }

    /// Remove the part of each row below the horizon.
    fn hide_below(&mut self, grid: &Grid) {
        let rows = self.cells.outer_iter_mut().zip(&mut self.rows);
        for ((mut cells, sum), edges) in rows.zip(grid.theta_edges.windows(2)) {
            let visible = ((FRAC_PI_2 - edges[0]) / (edges[1] - edges[0])).clamp(0.0, 1.0);
            cells.mapv_inplace(|value| visible * value);
            *sum = sum.map(|value| visible * value);
        }
    }

    /// Integral over the map in each channel.
    fn whole(&self) -> [f64; 3] {
        sum(&self.rows)
    }

    /// Remove a cell.
    fn remove(&mut self, (row, column): (usize, usize)) {
        self.cells.slice_mut(s![row, column, ..]).fill(0.0);
        let others = self.cells.index_axis(Axis(0), row);
        self.rows[row] = from_fn(|channel| others.column(channel).sum());
    }

    /// Cells with more than a `share` of the `whole` flux of a channel, and with [`CONTRAST`] times the mean flux of a cell.
    fn sources(&self, whole: [f64; 3], share: f64) -> Vec<(usize, usize)> {
        let (rows, columns, _) = self.cells.dim();
        let share = share.max(CONTRAST / (rows * columns) as f64);
        let least = whole.map(|whole| share * whole);
        let is_source = |cell: &[f64; 3]| (0..3).any(|c| cell[c] > least[c]);
        let in_row = |(row, cells): (usize, &[[f64; 3]])| {
            let columns = cells.iter().enumerate().filter(|(_, cell)| is_source(cell));
            columns.map(|(column, _)| (row, column)).collect::<Vec<_>>()
        };
        rows_of(&self.cells).enumerate().flat_map_iter(in_row).collect()
    }

    /// Mean radiance of the cells, and the bright cells, for which harmonics are not sharp enough.
    ///
    /// A cell with the flux F and the radiance L is bright if `F / F_0 * L / L_0 > 0.012` and `L > 8 L_0`, with the flux
    /// `F_0` and the mean radiance `L_0` of the map. So 1.5e-3 of the flux is enough at 8 times the mean radiance, and less
    /// beside a sun.
    fn means(&self, grid: &Grid) -> (Array3<f32>, Vec<(usize, usize)>) {
        const WORTH: f64 = 0.012;
        // Avoid divisions: `L / L_0` is the fraction of the flux over the fraction of the sphere.
        let over_whole = 1.0 / self.whole().iter().sum::<f64>();
        let is_bright = |cell: &[f64; 3], solid_angle: f64| {
            let share = cell.iter().sum::<f64>() * over_whole;
            let dense = share * 4.0 * PI;
            dense > CONTRAST * solid_angle && share * dense > WORTH * solid_angle
        };
        let widths = grid.widths();
        let of_row = |row: usize, means: &mut [[f32; 3]], cells: &[[f64; 3]], band: f64| {
            let mut bright = Vec::new();
            for (column, ((mean, cell), width)) in means.iter_mut().zip(cells).zip(&widths).enumerate() {
                let solid_angle = band * width;
                let over = 1.0 / solid_angle;
                *mean = cell.map(|flux| (flux * over) as f32);
                if is_bright(cell, solid_angle) {
                    bright.push((row, column));
                }
            }
            bright
        };
        let mut means = Array3::zeros(self.cells.dim());
        let bands = band_heights(&grid.theta_edges);
        let rows = rows_mut(&mut means).zip(rows_of(&self.cells)).zip(&bands);
        let bright = rows.enumerate();
        let bright =
            bright.flat_map_iter(|(row, ((means, cells), band))| of_row(row, means, cells, *band)).collect();
        (means, bright)
    }
}

/// Sum rows of pixels of these `widths` into their cells; true if a sample has a minus sign.
fn add_across(cells: &mut [[f64; 3]], pixels: &BlockRow<'_>, widths: &[f64], block: usize) -> bool {
    let mut cells = cells.iter_mut();
    let height = pixels.height;
    pixels.mean(|columns, mean| {
        let blocks = mean.as_chunks::<3>().0.chunks(block).zip(widths[columns].chunks(block));
        for ((pixels, widths), cell) in blocks.zip(&mut cells) {
            let mut sum = [0.0; 3];
            for (pixel, width) in pixels.iter().zip(widths) {
                (0..3).for_each(|c| sum[c] += f64::from(pixel[c]) * width);
            }
            *cell = sum.map(|sum| sum * height);
        }
    })
}

fn sum(fluxes: &[[f64; 3]]) -> [f64; 3] {
    fluxes.iter().fold([0.0; 3], |sum, flux| from_fn(|c| sum[c] + flux[c]))
}

/// Cells of each row.
fn rows_of<T: Sync>(cells: &Array3<T>) -> impl IndexedParallelIterator<Item = &[[T; 3]]> {
    let samples = cells.as_slice().unwrap_or(&[]); // as it was made, row after row
    samples.as_chunks::<3>().0.par_chunks(cells.dim().1)
}

fn rows_mut<T: Send>(cells: &mut Array3<T>) -> impl IndexedParallelIterator<Item = &mut [[T; 3]]> {
    let columns = cells.dim().1;
    let samples = cells.as_slice_mut().unwrap_or(&mut []); // as it was made, row after row
    samples.as_chunks_mut::<3>().0.par_chunks_mut(columns)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use approx::assert_relative_eq;

    use super::super::parts::MOST_PARTS;
    use super::*;
    use crate::kernels::sphere::direction;

    #[test]
    fn reduction_keeps_the_flux() {
        let map = Array3::from_shape_fn((30, 60, 3), |(y, x, c)| ((y * 7 + x * 3 + c) % 11) as f32);
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            let pixels = Grid::of_pixels(30, 60, registration);
            let before = Flux::new(map.view(), &pixels, 1).unwrap().cells.sum();
            let small = reduce(map.view(), registration, 16, 2.0, false).unwrap();
            let bands = band_heights(&small.grid.theta_edges);
            let after: f64 = small
                .radiance
                .indexed_iter()
                .map(|((row, column, _), &value)| {
                    let edges = &small.grid.phi_edges;
                    f64::from(value) * bands[row] * (edges[column + 1] - edges[column])
                })
                .sum();
            assert_relative_eq!(before, after, max_relative = 1e-6);
        }
    }

    /// A disc of 1.7 degrees before black, in few cells: its rim cuts most of them.
    fn lamp(row: usize, column: usize) -> Array3<f32> {
        Array3::from_shape_fn((512, 1024, 3), |(y, x, c)| {
            let away = (y as f64 - row as f64).hypot(x as f64 - column as f64);
            if away < 5.0 { 1.0 + c as f32 } else { 0.0 }
        })
    }

    /// The flux of all parts, and its middle.
    fn whole(parts: &[Part]) -> (f64, DVec3) {
        let vector = |part: &Part| DVec3::from_array(part.irradiance.map(|axis| axis.iter().sum()));
        (parts.iter().map(|part| vector(part).length()).sum(), parts.iter().map(vector).sum())
    }

    #[test]
    fn parts_of_bright_cells_hold_their_light_where_it_is() {
        for share in [2e-3, 1.0] {
            let map = reduce(lamp(200, 407).view(), Registration::CellCentred, 256, share, false).unwrap();
            assert_eq!(map.bright.is_empty(), share < 1.0);
            let (flux, vector) = whole(&map.parts);
            let bands = band_heights(&Registration::CellCentred.theta_edges(512));
            let all: f64 = lamp(200, 407)
                .indexed_iter()
                .map(|((y, ..), value)| f64::from(*value) * bands[y] * PI / 512.0)
                .sum();
            assert!((flux / all - 1.0).abs() < 3e-3, "{flux} {all}");
            // The pixels lie around the middle of one of them.
            let middle = direction(200.5 * PI / 512.0, 407.5 * PI / 512.0);
            assert!(vector.normalize().distance(middle) < 1e-4);
        }
    }

    /// A lamp has little of the flux of a map with a sun, and much of the flux without the sun.
    #[test]
    fn bright_cells_are_compared_with_the_map_without_its_sources() {
        let mut map = Array3::from_elem((64, 128, 3), 0.05_f32);
        map.slice_mut(s![20, 30, ..]).fill(1e6);
        map.slice_mut(s![40, 90, ..]).fill(50.0);
        let working = reduce(map.view(), Registration::CellCentred, 256, 5e-3, false).unwrap();
        assert_eq!((working.sources.dim().0, working.bright), (1, vec![(40, 90)]));
    }

    /// Each of sixteen lamps would have about fifteen parts by itself.
    #[test]
    fn many_lamps_have_at_most_the_largest_number_of_parts() {
        let lamps = |count: usize| {
            (0..count).fold(Array3::zeros((512, 1024, 3)), |sum, i| {
                sum + lamp(150 + 50 * (i % 4), 40 + 60 * i) * (1.0 + i as f32)
            })
        };
        let parts = |count| {
            let map = reduce(lamps(count).view(), Registration::CellCentred, 256, 2e-3, false).unwrap();
            (map.sources.dim().0 + map.bright.len(), map.parts)
        };
        let (cells, few) = parts(2);
        assert!(few.len() > 2 * cells, "{} {cells}", few.len());
        let (cells, many) = parts(16);
        assert!(cells < many.len() && many.len() <= MOST_PARTS, "{cells} {}", many.len());
        // The brightest cells are divided.
        let most = many.iter().map(|part| part.spread).fold(0.0, f64::max);
        assert!(many[0].spread < 0.1 * most, "{} {most}", many[0].spread);
    }
}
