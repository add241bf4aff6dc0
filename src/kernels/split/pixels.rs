//! The map's pixels of lights: bands of rows, which are worked through at the same time, and in them strips of the rows
//! behind one of the working image.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::ops::Range;

use rayon::prelude::*;

use super::cells::Cells;
use super::glow::Bright;
use super::level::Level;
use super::loss::Loss;
use crate::interrupt;
use crate::kernels::detect::segment::run::Run;

/// Rows of the working image in a band: few, so that every thread has work. Another number would add in another order.
const ROWS_OF_A_BAND: usize = 8;
/// Columns of a strip, at most: its sums stay in the first cache.
const PIXELS_OF_A_STRIP: usize = 256;

/// A map, its cells, and the membrane in the pixels of the working image.
pub struct Map<'a> {
    /// Its pixels, row after row, and its height and width.
    pub pixels: &'a [[f32; 3]],
    pub size: (usize, usize),
    pub cells: Cells,
    pub membrane: &'a Level,
    /// Pixels of the map along each side of a pixel of the working image.
    pub block: usize,
    pub bright: Bright,
}

/// The pixels of lights in each band of the working image.
pub struct Bands {
    bands: Vec<Vec<Piece>>,
    pub lights: usize,
}

/// The pixels of one light in a band, row after row.
#[derive(Clone)]
struct Piece {
    light: usize,
    runs: Vec<Run>,
}

/// Some columns of the map in all rows behind one of the working image.
pub struct Strip {
    pub rows: Range<usize>,
    pub columns: Range<usize>,
    /// Their columns in the working image.
    pub behind: Range<usize>,
}

/// Rows of an image that is written.
pub struct Slab<'a> {
    first: usize,
    width: usize,
    pixels: &'a mut [[f32; 3]],
}

impl Bands {
    /// Those of lights, each with its runs in ascending order, in a working image of this height.
    pub fn new(lights: &[Vec<Run>], height: usize) -> Self {
        let mut bands = vec![Vec::new(); height.div_ceil(ROWS_OF_A_BAND)];
        let band = |run: &Run| run.row / ROWS_OF_A_BAND;
        for (light, runs) in lights.iter().enumerate() {
            for runs in runs.chunk_by(|one, other| band(one) == band(other)) {
                bands[band(&runs[0])].push(Piece { light, runs: runs.to_vec() });
            }
        }
        Self { bands, lights: lights.len() }
    }

    /// Those of the lights that are `chosen`.
    pub fn of(&self, chosen: &[bool]) -> Self {
        let pieces = |band: &Vec<Piece>| band.iter().filter(|piece| chosen[piece.light]).cloned().collect();
        Self { bands: self.bands.iter().map(pieces).collect(), lights: self.lights }
    }

    /// What `work` finds in each piece, with what stands beside its band, added up for each light in the order of bands.
    fn sums<T: Send>(
        &self,
        beside: impl IndexedParallelIterator<Item = T>,
        work: impl Fn(&Piece, &mut T) -> Loss + Sync,
    ) -> Vec<Loss> {
        let in_band = |(pieces, mut beside): (&Vec<Piece>, T)| {
            pieces.iter().map(|piece| (piece.light, work(piece, &mut beside))).collect()
        };
        let losses: Vec<Vec<(usize, Loss)>> = self.bands.par_iter().zip(beside).map(in_band).collect();
        let mut sums = vec![Loss::NONE; self.lights];
        for (light, loss) in losses.into_iter().flatten() {
            sums[light] = sums[light].and(loss);
        }
        sums
    }
}

impl Map<'_> {
    /// What each light loses by `work` on each piece of it: the light, its pixels, and a slab of the `rest`.
    pub fn loss_of_each(
        &self,
        bands: &Bands,
        rest: &mut [[f32; 3]],
        work: impl Fn(usize, &[Run], &mut Slab<'_>) -> Loss + Sync,
    ) -> Vec<Loss> {
        let (rows, width) = (ROWS_OF_A_BAND * self.block, self.size.1);
        let slabs = rest.par_chunks_mut(rows * width).enumerate();
        let slabs = slabs.map(|(band, pixels)| Slab { first: band * rows, width, pixels });
        bands.sums(slabs, |piece, slab| work(piece.light, &piece.runs, slab))
    }

    /// The strips of some runs.
    pub fn strips(&self, runs: &[Run]) -> impl Iterator<Item = Strip> {
        interrupt::check();
        let most = (PIXELS_OF_A_STRIP / self.block).max(1);
        runs.iter().flat_map(move |run| {
            let starts = run.columns.clone().step_by(most);
            starts.map(move |start| {
                let behind = start..run.columns.end.min(start + most);
                let columns = behind.start * self.block..(behind.end * self.block).min(self.size.1);
                Strip { rows: self.rows_of(run), columns, behind }
            })
        })
    }

    /// The pixels of a strip in one of its rows.
    #[inline(always)]
    pub fn given(&self, row: usize, strip: &Strip) -> &[[f32; 3]] {
        let start = row * self.size.1;
        &self.pixels[start + strip.columns.start..start + strip.columns.end]
    }

    /// Rows of the map behind a run.
    fn rows_of(&self, run: &Run) -> Range<usize> {
        run.row * self.block..((run.row + 1) * self.block).min(self.size.0)
    }
}

impl Slab<'_> {
    /// The pixels of a strip in one of its rows.
    #[inline(always)]
    pub fn at(&mut self, row: usize, strip: &Strip) -> &mut [[f32; 3]] {
        let start = (row - self.first) * self.width;
        &mut self.pixels[start + strip.columns.start..start + strip.columns.end]
    }
}

#[cfg(test)]
mod tests {
    use rayon::iter::repeat_n;

    use super::*;
    use crate::kernels::detect::segment::run::runs;

    /// Two lights side by side in several bands, the second of which begins where the first ends.
    #[test]
    fn every_pixel_of_a_light_is_in_one_piece() {
        let width = 32;
        let lights: [Vec<u32>; 2] = [(40..300).collect(), (300..777).chain(780..801).collect()];
        let bands = Bands::new(&lights.clone().map(|pixels| runs(&pixels, width)), 30);
        let count = |bands: &Bands| {
            let pixels = |runs: &[Run]| runs.iter().map(|run| run.columns.len()).sum::<usize>();
            let loss = |piece: &Piece| Loss { flux: pixels(&piece.runs) as f64, ..Loss::NONE };
            let sums = bands.sums(repeat_n((), bands.bands.len()), |piece, ()| loss(piece));
            sums.iter().map(|sum| sum.flux as usize).collect::<Vec<_>>()
        };
        assert_eq!(count(&bands), lights.map(|pixels| pixels.len()));
        assert_eq!(count(&bands.of(&[false, true])), [0, 498]);
        for (band, pieces) in bands.bands.iter().enumerate() {
            let rows = pieces.iter().flat_map(|piece| &piece.runs).map(|run| run.row / ROWS_OF_A_BAND);
            assert!(rows.into_iter().all(|place| place == band));
        }
    }
}
