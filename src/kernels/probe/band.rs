//! Flux of a band of rows up to any azimuth: prefix sums over blocks of columns.
//!
//! In a block of columns of one width d around the azimuth `phi_b`, with `o` the offset of a column,
//!
//! ```text
//!   integral of L cos phi = 2 sin(d/2) (cos phi_b sum L cos o - sin phi_b sum L sin o)
//!   integral of L sin phi = 2 sin(d/2) (sin phi_b sum L cos o + cos phi_b sum L sin o)
//! ```
//!
//! so one small table of cos o and sin o serves all blocks. A block is summed and rotated by `phi_b` in f32, like the
//! samples; the sums over blocks are f64. There are prefix sums for whole blocks. In the first half of a block, a look-up
//! adds the columns from its start; in the second half, it subtracts those up to its end. The weights of a normal are
//! rotated into the block as the sums are rotated out of it. Each row of a band has its own weight, so that the vector
//! flux of the band is exact; only its horizon is approximate.
//!
//! A sum in f32 loses 6e-8 of its brightest pixel. For a sun, this is more than the irradiance from the room behind it.
//! Blocks above the limits of `bright.rs` are therefore summed in f64, in the prefix sums and in each look-up.

use glam::{DVec3, Vec3, Vec4};

use super::bright::Limits;
use super::rows::{ColumnWeights, FourPixels, Rows, Weight, four};
use crate::kernels::image::Grid;

/// Columns of a block. More columns make the pass over the pixels faster and a look-up slower: 16 is the fastest of 4, 8,
/// 16 and 32 for 320 normals and 4096 columns.
const BLOCK: usize = 16;
const HALF: usize = BLOCK / 2;
/// Integrals of L cos phi, L sin phi and L over some azimuths, each for three channels.
pub type Flux = [DVec3; 3];

/// Columns of a map in blocks, and the integrals over them; all rows share them.
pub struct BlockColumns<'a> {
    grid: &'a Grid,
    /// For each edge the antiderivatives of cos phi, sin phi and 1.
    edges: Vec<DVec3>,
    /// Integrals of cos phi, sin phi and 1 over each column.
    integrals: Vec<DVec3>,
    /// cos o and sin o of the pixels of a block of even width.
    offsets: [[FourPixels; 2]; BLOCK / 4],
    /// For a look-up in each column of a block, the signs of the pixels of its half: 1, -1, or 0 for none.
    signs: [[FourPixels; HALF / 4]; BLOCK],
    /// For each block of even columns, the integrals over a column in its middle.
    middles: Vec<Option<[f32; 3]>>,
    /// Radiance up to which a block is summed in f32.
    limits: Limits,
}

impl<'a> BlockColumns<'a> {
    pub fn new(grid: &'a Grid, limits: Limits) -> Self {
        let phi = &grid.phi_edges;
        let edges: Vec<DVec3> = phi.iter().map(|&phi| DVec3::new(phi.sin(), -phi.cos(), phi)).collect();
        let integrals = edges.windows(2).map(|edge| edge[1] - edge[0]);
        // Take the width of an inner column: the seam may cut the outer ones.
        let width = phi[phi.len() / 2] - phi[phi.len() / 2 - 1];
        let offset = |i: usize| (i as f64 - 0.5 * (BLOCK - 1) as f64) * width;
        let offsets = |i: usize| [f64::cos, f64::sin].map(|f| four(|pixel| f(offset(4 * i + pixel)) as f32));
        Self {
            integrals: integrals.collect(),
            offsets: std::array::from_fn(offsets),
            signs: std::array::from_fn(|within| {
                std::array::from_fn(|i| four(|pixel| sign(within / HALF * HALF + 4 * i + pixel, within)))
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

    /// Column of an azimuth; the conversion to u32 has two instructions, and one to usize would have ten.
    fn of_azimuth(&self, phi: f64) -> usize {
        ((phi * self.grid.columns_per_radian + self.grid.first_column) as u32 as usize)
            .min(self.integrals.len() - 1)
    }
}

/// Sign of a `pixel` in a look-up `within` the same half of a block, or 0.
fn sign(pixel: usize, within: usize) -> f32 {
    match (within < HALF, pixel < within) {
        (true, true) => 1.0,
        (false, false) => -1.0,
        _ => 0.0,
    }
}

/// Integrals of cos phi, sin phi and 1 over a column of `width` in the middle of `block`; `None` for an uneven block.
///
/// A block is uneven if the seam cuts a column or the row ends, or if it is wider than 1 radian: then a sum of L cos o does
/// not limit its radiance.
fn middle(phi_edges: &[f64], block: usize, width: f64) -> Option<[f32; 3]> {
    let edges = phi_edges.get(BLOCK * block..=BLOCK * (block + 1))?;
    let is_even = edges.windows(2).all(|edge| (edge[1] - edge[0] - width).abs() < 1e-9 * width)
        && edges[BLOCK] - edges[0] < 1.0;
    let (sin, cos) = (0.5 * (edges[0] + edges[BLOCK])).sin_cos();
    let chord = 2.0 * (0.5 * width).sin();
    is_even.then_some([chord * cos, chord * sin, width].map(|x| x as f32))
}

/// Rows that share one horizon, and the prefix sums over their columns.
pub struct HorizonBand<'a> {
    columns: &'a BlockColumns<'a>,
    pairs: Vec<Rows<'a, 2>>,
    /// The last row of an odd number.
    last: Option<Rows<'a, 1>>,
    /// Flux between the seam and the start of each block, and of the whole.
    prefix: Vec<Flux>,
    /// Middles of the blocks that are summed in f32.
    middles: Vec<Option<[f32; 3]>>,
}

impl<'a> HorizonBand<'a> {
    /// A band without rows; [`Self::set`] fills it repeatedly.
    pub fn new(columns: &'a BlockColumns<'a>) -> Self {
        Self { columns, pairs: Vec::new(), last: None, prefix: Vec::new(), middles: Vec::new() }
    }

    pub fn set(&mut self, rows: &[&'a [[f32; 3]]], weights: &[Weight]) {
        // Group the rows in pairs, and a last one by itself.
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

    /// The flux of a block in f32; `None` above the limit.
    #[inline]
    fn even_block(&self, block: usize, [chord_cos, chord_sin, width]: [f32; 3], limit: Vec4) -> Option<Flux> {
        let (first, offsets) = (BLOCK * block, &self.columns.offsets);
        let mut sums = [Vec4::ZERO; 3];
        let mut add = |terms: [Vec4; 3]| sums = [sums[0] + terms[0], sums[1] + terms[1], sums[2] + terms[2]];
        self.pairs.iter().for_each(|rows| add(rows.sums::<BLOCK>(first, offsets)));
        self.last.iter().for_each(|row| add(row.sums::<BLOCK>(first, offsets)));
        // Rotate the sums from the middle of the block to the seam.
        let [cos, sin, one] = sums;
        if cos.cmpgt(limit).any() {
            return None;
        }
        let rotated = [cos * chord_cos - sin * chord_sin, cos * chord_sin + sin * chord_cos, one * width];
        Some(rotated.map(|flux| flux.truncate().as_dvec3()))
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

    /// `weights . flux` between the seam and the azimuth `phi`, with a part of the pixel at its end.
    #[inline]
    pub fn up_to(&self, weights: DVec3, phi: f64, cos_phi: f64, sin_phi: f64) -> DVec3 {
        // Find the pixel that the azimuth cuts, and the border of blocks that is nearest to it.
        let columns = self.columns;
        let column = columns.of_azimuth(phi);
        let nearest = (column + HALF) / BLOCK;
        // Count the part of that pixel.
        let part = DVec3::new(sin_phi, -cos_phi, phi) - columns.edges[column];
        let cut = self.pixel(column, weights.x * part.x + weights.y * part.y, weights.z * part.z);
        // Count the whole pixels between it and the border.
        let whole = match self.middles[column / BLOCK] {
            Some(middle) => self.even_columns(column, middle, weights.as_vec3()),
            None => self.uneven_columns(column, (BLOCK * nearest).min(columns.integrals.len()), weights),
        };
        // Add all blocks up to the border.
        weigh(&self.prefix[nearest], weights) + whole + cut
    }

    /// `weights . flux` of the columns from the start of the block to `column`; in the second half of the block, minus that
    /// of the columns from `column` to its end.
    #[inline]
    fn even_columns(&self, column: usize, [chord_cos, chord_sin, width]: [f32; 3], weights: Vec3) -> DVec3 {
        // Rotate the weights to the middle of the block.
        let weights = ColumnWeights {
            cos: weights.x * chord_cos + weights.y * chord_sin,
            sin: weights.y * chord_cos - weights.x * chord_sin,
            one: weights.z * width,
        };
        // Choose the half of the block, and the signs of its pixels.
        let (half, within) = (column / HALF, column % BLOCK);
        let offsets = &self.columns.offsets[half % 2 * (HALF / 4)..][..HALF / 4];
        let signs = &self.columns.signs[within];
        // Add up all rows.
        let mut sum = Vec4::ZERO;
        let first = half * HALF;
        self.pairs.iter().for_each(|rows| sum += rows.weighted_sum::<HALF>(first, &weights, offsets, signs));
        self.last.iter().for_each(|row| sum += row.weighted_sum::<HALF>(first, &weights, offsets, signs));
        sum.truncate().as_dvec3()
    }

    /// `weights . flux` of the columns from `start` to `column`, for columns of different widths.
    fn uneven_columns(&self, column: usize, start: usize, weights: DVec3) -> DVec3 {
        let columns = start.min(column)..start.max(column);
        let sign = if start <= column { 1.0 } else { -1.0 };
        let sum = columns.fold(DVec3::ZERO, |sum, column| {
            let integral = self.columns.integrals[column];
            sum + self.pixel(column, weights.x * integral.x + weights.y * integral.y, weights.z * integral.z)
        });
        sum * sign
    }
}

/// `weights . flux`, for each channel.
#[inline]
pub fn weigh([cos, sin, one]: &Flux, weights: DVec3) -> DVec3 {
    *cos * weights.x + *sin * weights.y + *one * weights.z
}
