//! Reduction of a map to fewer cells, for approximate probes.

use glam::DVec3;
use ndarray::{Array3, ArrayView2, ArrayView3};
use rayon::prelude::*;

use super::block_layout::BlockLayout;
use super::block_rows::samples_of;
use super::cell_flux::CellFlux;
use super::grid::Grid;
use super::parts::{BrightCell, PART_SHARE, Part, Pixel, parts};
use crate::error::Result;
use crate::kernels::sphere::{Registration, angles};

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
    /// Mean radiance of each cell, without a floor and with all sources.
    pub overview: Array3<f32>,
}

impl WorkingMap {
    /// Edges in theta and cells of each row of a `radiance` of the size of this map.
    pub fn rows<'a>(
        &'a self,
        radiance: &'a Array3<f32>,
    ) -> impl Iterator<Item = (&'a [f64], &'a [[f32; 3]])> {
        let cells = radiance.as_slice().unwrap_or(&[]).as_chunks::<3>().0; // as it was made, row after row
        self.grid.theta_edges.windows(2).zip(cells.chunks_exact(radiance.dim().1))
    }

    /// Vector irradiance of each source, by channel.
    pub fn source_vectors(&self) -> Vec<[DVec3; 3]> {
        let by_channel = |source: ArrayView2<'_, f64>| {
            [0, 1, 2].map(|channel| DVec3::from_array([0, 1, 2].map(|axis| source[[axis, channel]])))
        };
        self.sources.outer_iter().map(by_channel).collect()
    }

    /// Spread of the light of one pixel of the map in a direction: the mean of 1 - cos.
    pub fn pixel_spread(&self, direction: DVec3) -> f64 {
        self.pixel.spread(angles(direction).0)
    }
}

/// Reduce `radiance` to at most `columns` columns, with its bright cells as point sources.
///
/// The light of a cell on the horizon of a normal is smeared over the width of the cell, which matters only for a cell with
/// much light. So each cell with more than `source_fraction` of the flux of any channel becomes a source with the vector
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
    source_fraction: f64,
    has_floor: bool,
) -> Result<WorkingMap> {
    let layout = BlockLayout::of_map(radiance, registration, columns)?;
    let flux = CellFlux::of_map(radiance, &layout)?;
    let reduced = ReducedFlux::new(flux, &layout, source_fraction, has_floor);
    let pixels = pixels_of_cells(radiance, &layout, &reduced.cells());
    Ok(reduced.with_parts(&layout, has_floor, pixels))
}

/// Samples of each of these cells.
fn pixels_of_cells(
    map: ArrayView3<'_, f32>,
    layout: &BlockLayout,
    cells: &[(usize, usize)],
) -> Vec<Vec<f32>> {
    let mut in_order: Vec<usize> = (0..cells.len()).collect();
    in_order.sort_by_key(|&i| cells[i]);
    let rows: Vec<&[usize]> = in_order.chunk_by(|&a, &b| cells[a].0 == cells[b].0).collect();
    let of_row = |row: &&[usize]| {
        let samples = samples_of(map, layout.pixel_rows(cells[row[0]].0));
        row.iter().map(|&i| (i, layout.copy(&samples, cells[i]))).collect::<Vec<_>>()
    };
    let copies: Vec<_> = rows.par_iter().map(of_row).collect();
    let mut pixels = vec![Vec::new(); cells.len()];
    copies.into_iter().flatten().for_each(|(i, samples)| pixels[i] = samples);
    pixels
}

/// Cells of a map without their parts, which need the pixels of some cells.
pub(super) struct ReducedFlux {
    radiance: Array3<f32>,
    /// Flux of the map in all channels.
    whole: f64,
    sources: Vec<(usize, usize)>,
    bright: Vec<(usize, usize)>,
    overview: Array3<f32>,
}

impl ReducedFlux {
    /// Means of the cells, with those that are sources or bright.
    pub fn new(mut flux: CellFlux, layout: &BlockLayout, source_fraction: f64, has_floor: bool) -> Self {
        let overview = flux.means(&layout.grid).0;
        if has_floor {
            flux.hide_below(&layout.grid);
        }
        let whole = flux.whole();
        let sources = flux.sources(whole, source_fraction);
        for &cell in &sources {
            flux.remove(cell);
        }
        let (radiance, bright) = flux.means(&layout.grid);
        Self { radiance, whole: whole.iter().sum(), sources, bright, overview }
    }

    /// Rows and columns of the cells whose pixels are needed: sources, then bright cells.
    pub fn cells(&self) -> Vec<(usize, usize)> {
        [&self.sources[..], &self.bright].concat()
    }

    /// The working map, from the `samples` of [`Self::cells`].
    pub fn with_parts(self, layout: &BlockLayout, has_floor: bool, samples: Vec<Vec<f32>>) -> WorkingMap {
        let (pixel, worth) = (Pixel::of(&layout.pixels), PART_SHARE * self.whole);
        let cells = self.cells();
        let bright_cell = |(&cell, samples): (&(usize, usize), &Vec<f32>)| {
            BrightCell::new(&layout.pixels_of(cell), samples, &layout.pixels, worth, pixel)
        };
        let bright_cells: Vec<BrightCell> = cells.par_iter().zip(&samples).map(bright_cell).collect();
        let is_seen = |part: &Part| !has_floor || part.is_up();
        let sources = Array3::from_shape_fn((self.sources.len(), 3, 3), |(i, axis, c)| {
            let BrightCell { whole, .. } = &bright_cells[i];
            if is_seen(whole) { whole.irradiance[axis][c] } else { 0.0 }
        });
        let mut parts = parts(bright_cells);
        parts.retain(is_seen);
        let (radiance, grid, bright) = (self.radiance, layout.grid.clone(), self.bright);
        WorkingMap { radiance, grid, sources, bright, parts, pixel, overview: self.overview }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::f64::consts::PI;

    use approx::assert_relative_eq;
    use ndarray::s;

    use super::super::parts::MOST_PARTS;
    use super::*;
    use crate::kernels::sphere::{band_heights, direction};

    #[test]
    fn arrays_of_any_order_give_the_same_bits() {
        let mut map = Array3::from_shape_fn((37, 75, 3), |(y, x, c)| ((y * 7 + x * 3 + c) % 11) as f32);
        for (y, x) in [(0, 0), (36, 74), (20, 74), (21, 0), (21, 33)] {
            map.slice_mut(s![y, x, ..]).fill(900.0);
        }
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            let flipped = map.slice(s![..;-1, .., ..]).to_owned();
            let [one, other] = [map.view(), flipped.slice(s![..;-1, .., ..])]
                .map(|map| format!("{:?}", reduce(map, registration, 16, 5e-3, false).unwrap()));
            assert_eq!(one, other);
        }
        map[[3, 3, 0]] = f32::NAN;
        assert!(reduce(map.view(), Registration::CellCentred, 16, 5e-3, false).is_err());
    }

    #[test]
    fn reduction_keeps_the_flux() {
        let map = Array3::from_shape_fn((30, 60, 3), |(y, x, c)| ((y * 7 + x * 3 + c) % 11) as f32);
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            let pixels = BlockLayout::new(30, 60, registration, 60);
            let before = CellFlux::of_map(map.view(), &pixels).unwrap().cells.sum();
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
