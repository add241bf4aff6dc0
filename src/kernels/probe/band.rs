//! Step 1: the flux of a band of rows up to any azimuth.
//!
//! In a block of columns of one width d around the azimuth `phi_b`, with `o` the offset of a column,
//!
//! ```text
//!   integral of L cos phi = 2 sin(d/2) (cos phi_b sum L cos o - sin phi_b sum L sin o)
//!   integral of L sin phi = 2 sin(d/2) (sin phi_b sum L cos o + cos phi_b sum L sin o)
//! ```
//!
//! so one small table of cos o and sin o serves all blocks. A block is summed and turned by `phi_b` in
//! f32, as the samples are; the sums over blocks are f64. Sums are kept for whole blocks; a look-up adds
//! the columns from the start of its block, or takes off those to its end, whichever half it falls
//! into. The pull of a normal is turned into the block as the sums are turned out of it. Rows of a band are
//! weighted one by one, so that its vector flux is exact; only its horizon is not.
//!
//! A sum in f32 loses 6e-8 of the brightest pixel in it: of a sun more than a room behind it gives. Blocks
//! above the limits of `bright.rs` are therefore summed in f64, in the prefix sums and in each look-up.

use glam::{DVec3, Vec3, Vec4};

use super::bright::Limits;
use super::rows::{FourPixels, Pull, Rows, Weight, four};
use crate::kernels::image::Grid;

/// Columns of a block: with more the pass over the pixels is faster, the look-up is slower. Of 4, 8,
/// 16 and 32, 16 is fastest for 320 normals and 4096 columns.
const BLOCK: usize = 16;
const HALF: usize = BLOCK / 2;
/// Integrals of L cos phi, L sin phi and L over some azimuths, each for three channels.
pub type Flux = [DVec3; 3];

/// What all rows have in common: where their columns lie, and the integrals over them.
pub struct Columns<'a> {
    grid: &'a Grid,
    /// For each edge the antiderivatives of cos phi, sin phi and 1.
    edges: Vec<DVec3>,
    /// Integrals of cos phi, sin phi and 1 over each column.
    integrals: Vec<DVec3>,
    /// cos o and sin o of the pixels of a block of even width.
    offsets: [[FourPixels; 2]; BLOCK / 4],
    /// For a look-up in each column of a block: 1 for the pixels of its half that it adds, -1 for those
    /// that it takes off, 0 for the others.
    counted: [[FourPixels; HALF / 4]; BLOCK],
    /// For each block the integrals over the column in its middle, if all its columns are as wide.
    middles: Vec<Option<[f32; 3]>>,
    /// How bright a block may be to be summed in f32.
    limits: Limits,
}

impl<'a> Columns<'a> {
    pub fn new(grid: &'a Grid, limits: Limits) -> Self {
        let phi = &grid.phi_edges;
        let edges: Vec<DVec3> = phi.iter().map(|&phi| DVec3::new(phi.sin(), -phi.cos(), phi)).collect();
        let integrals = edges.windows(2).map(|edge| edge[1] - edge[0]);
        // Any column but the outer ones, which the seam may cut.
        let width = phi[phi.len() / 2] - phi[phi.len() / 2 - 1];
        let offset = |i: usize| (i as f64 - 0.5 * (BLOCK - 1) as f64) * width;
        let offsets = |i: usize| [f64::cos, f64::sin].map(|f| four(|pixel| f(offset(4 * i + pixel)) as f32));
        Self {
            integrals: integrals.collect(),
            offsets: std::array::from_fn(offsets),
            counted: std::array::from_fn(|within| {
                std::array::from_fn(|i| four(|pixel| counts(within / HALF * HALF + 4 * i + pixel, within)))
            }),
            middles: phi[..phi.len() - 1]
                .chunks(BLOCK)
                .enumerate()
                .map(|(block, _)| middle(phi, block, width))
                .collect(),
            edges,
            grid,
            limits,
        }
    }

    /// Through u32, which takes two instructions; usize takes ten.
    fn of_azimuth(&self, phi: f64) -> usize {
        ((phi * self.grid.columns_per_radian + self.grid.first_column) as u32 as usize)
            .min(self.integrals.len() - 1)
    }
}

/// The sign with which a look-up `within` a block counts a pixel of the same half, or 0.
fn counts(pixel: usize, within: usize) -> f32 {
    match (within < HALF, pixel < within) {
        (true, true) => 1.0,
        (false, false) => -1.0,
        _ => 0.0,
    }
}

/// Integrals of cos phi, sin phi and 1 over a column of `width` in the middle of `block`; none where
/// the seam cuts a column or the row ends, nor where blocks are so wide that a sum of L cos o does not tell
/// how bright they are.
fn middle(phi_edges: &[f64], block: usize, width: f64) -> Option<[f32; 3]> {
    const WIDEST: f64 = 1.0;
    let edges = phi_edges.get(BLOCK * block..=BLOCK * (block + 1))?;
    let is_even = edges.windows(2).all(|edge| (edge[1] - edge[0] - width).abs() < 1e-9 * width)
        && edges[BLOCK] - edges[0] < WIDEST;
    let (sin, cos) = (0.5 * (edges[0] + edges[BLOCK])).sin_cos();
    let chord = 2.0 * (0.5 * width).sin();
    is_even.then_some([chord * cos, chord * sin, width].map(|x| x as f32))
}

/// Rows that share one horizon, and the prefix sums over their columns.
pub struct Band<'a> {
    columns: &'a Columns<'a>,
    pairs: Vec<Rows<'a, 2>>,
    /// The row that is left of an odd number.
    last: Option<Rows<'a, 1>>,
    /// Flux between the seam and the start of each block, and of the whole.
    prefix: Vec<Flux>,
    /// Middles of the blocks that are summed in f32.
    middles: Vec<Option<[f32; 3]>>,
}

impl<'a> Band<'a> {
    /// A band of no rows; [`Self::set`] fills it, over and over.
    pub fn new(columns: &'a Columns<'a>) -> Self {
        Self { columns, pairs: Vec::new(), last: None, prefix: Vec::new(), middles: Vec::new() }
    }

    pub fn set(&mut self, rows: &[&'a [[f32; 3]]], weights: &[Weight]) {
        // Take the rows in pairs, and what is left by itself.
        let ((pairs, last), (pair_weights, last_weights)) = (rows.as_chunks(), weights.as_chunks());
        self.pairs.clear();
        self.pairs.extend(pairs.iter().zip(pair_weights).map(|(&rows, &weights)| Rows::new(rows, weights)));
        self.last = last.iter().zip(last_weights).map(|(&row, &weight)| Rows::new([row], [weight])).next();
        // Sum the flux block by block.
        self.prefix.clear();
        self.middles.clone_from(&self.columns.middles);
        let limit = self.columns.limits.of_block(BLOCK, weights);
        let mut sum = [DVec3::ZERO; 3];
        for block in 0..self.middles.len() {
            self.prefix.push(sum);
            let even = self.middles[block].and_then(|middle| self.even_block(block, middle, limit));
            let flux = even.unwrap_or_else(|| {
                self.middles[block] = None;
                self.uneven_block(block)
            });
            sum = [sum[0] + flux[0], sum[1] + flux[1], sum[2] + flux[2]];
        }
        self.prefix.push(sum);
    }

    /// The flux of a block in f32; none if it is above the limit.
    #[inline]
    fn even_block(&self, block: usize, [chord_cos, chord_sin, width]: [f32; 3], limit: Vec4) -> Option<Flux> {
        let (first, offsets) = (BLOCK * block, &self.columns.offsets);
        let mut sums = [Vec4::ZERO; 3];
        let mut add = |terms: [Vec4; 3]| sums = [sums[0] + terms[0], sums[1] + terms[1], sums[2] + terms[2]];
        self.pairs.iter().for_each(|rows| add(rows.sums::<BLOCK>(first, offsets)));
        self.last.iter().for_each(|row| add(row.sums::<BLOCK>(first, offsets)));
        // Turn the sums from the middle of the block to the seam.
        let [cos, sin, one] = sums;
        if cos.cmpgt(limit).any() {
            return None;
        }
        let turned = [cos * chord_cos - sin * chord_sin, cos * chord_sin + sin * chord_cos, one * width];
        Some(turned.map(|flux| flux.truncate().as_dvec3()))
    }

    fn uneven_block(&self, block: usize) -> Flux {
        let last = (BLOCK * (block + 1)).min(self.columns.integrals.len());
        let mut flux = [DVec3::ZERO; 3];
        for column in BLOCK * block..last {
            let [cos, sin, one] = self.columns.integrals[column].to_array();
            flux[0] += self.pixel(column, cos, 0.0);
            flux[1] += self.pixel(column, sin, 0.0);
            flux[2] += self.pixel(column, 0.0, one);
        }
        flux
    }

    /// One column of all rows.
    #[inline]
    fn pixel(&self, column: usize, equatorial: f64, polar: f64) -> DVec3 {
        let mut sum = DVec3::ZERO;
        self.pairs.iter().for_each(|rows| sum += rows.pixel(column, equatorial, polar));
        self.last.iter().for_each(|row| sum += row.pixel(column, equatorial, polar));
        sum
    }

    pub fn total(&self) -> &Flux {
        &self.prefix[self.prefix.len() - 1]
    }

    /// `pull . flux` between the seam and the azimuth `phi`; the pixel that it cuts counts in part.
    #[inline]
    pub fn up_to(&self, pull: DVec3, phi: f64, cos_phi: f64, sin_phi: f64) -> DVec3 {
        // Find the pixel that the azimuth cuts, and the border of blocks that is nearest to it.
        let columns = self.columns;
        let column = columns.of_azimuth(phi);
        let nearest = (column + HALF) / BLOCK;
        // Count the part of that pixel.
        let part = DVec3::new(sin_phi, -cos_phi, phi) - columns.edges[column];
        let cut = self.pixel(column, pull.x * part.x + pull.y * part.y, pull.z * part.z);
        // Count the whole pixels between it and the border.
        let whole = match self.middles[column / BLOCK] {
            Some(middle) => self.even_columns(column, middle, pull.as_vec3()),
            None => self.uneven_columns(column, (BLOCK * nearest).min(columns.integrals.len()), pull),
        };
        // Add all blocks up to the border.
        weigh(&self.prefix[nearest], pull) + whole + cut
    }

    /// `pull . flux` of the columns from the start of the block to `column`, or, in its second half, less
    /// those from `column` to its end.
    #[inline]
    fn even_columns(&self, column: usize, [chord_cos, chord_sin, width]: [f32; 3], pull: Vec3) -> DVec3 {
        // Turn the pull to the middle of the block.
        let pull = Pull {
            cos: pull.x * chord_cos + pull.y * chord_sin,
            sin: pull.y * chord_cos - pull.x * chord_sin,
            one: pull.z * width,
        };
        // Choose the half of the block, and the pixels of it that count.
        let (half, within) = (column / HALF, column % BLOCK);
        let offsets = &self.columns.offsets[half % 2 * (HALF / 4)..][..HALF / 4];
        let counted = &self.columns.counted[within];
        // Add up all rows.
        let mut sum = Vec4::ZERO;
        let first = half * HALF;
        self.pairs.iter().for_each(|rows| sum += rows.pulled::<HALF>(first, &pull, offsets, counted));
        self.last.iter().for_each(|row| sum += row.pulled::<HALF>(first, &pull, offsets, counted));
        sum.truncate().as_dvec3()
    }

    /// The same from `start`, where columns differ in width.
    fn uneven_columns(&self, column: usize, start: usize, pull: DVec3) -> DVec3 {
        let columns = start.min(column)..start.max(column);
        let sign = if start <= column { 1.0 } else { -1.0 };
        let sum = columns.fold(DVec3::ZERO, |sum, column| {
            let integral = self.columns.integrals[column];
            sum + self.pixel(column, pull.x * integral.x + pull.y * integral.y, pull.z * integral.z)
        });
        sum * sign
    }
}

/// `pull . flux`, for each channel.
#[inline]
pub fn weigh([cos, sin, one]: &Flux, pull: DVec3) -> DVec3 {
    *cos * pull.x + *sin * pull.y + *one * pull.z
}
