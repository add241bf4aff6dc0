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
//! or takes off the few columns to the nearest. Rows of a band are weighted one by one, so that its vector flux is exact; only its horizon is not.

use glam::{DVec3, Vec3, Vec4};

use crate::kernels::image::Grid;

/// Columns of a block: with more the pass over the pixels is faster, the look-up is slower. Of 4, 8,
/// 16 and 32, 16 is fastest for 320 normals and 4096 columns.
const BLOCK: usize = 16;
/// Four pixels are twelve samples, three vectors of four, whatever the channels within them.
type FourPixels = [Vec4; 3];

/// Integrals of L cos phi, L sin phi and L over some azimuths, each for three channels.
pub type Flux = [DVec3; 3];

/// What every look-up in a row needs to know of its columns.
pub struct Columns<'a> {
    grid: &'a Grid,
    /// cos and sin of the azimuth of each edge.
    edges: Vec<[f64; 2]>,
    /// Integrals of cos phi, sin phi and 1 over each column.
    integrals: Vec<DVec3>,
    /// cos o and sin o of the pixels of a block of even width.
    offsets: [[FourPixels; 2]; BLOCK / 4],
    /// For each block the integrals over the column in its middle, if all its columns are as wide.
    middles: Vec<Option<[f32; 3]>>,
}

impl<'a> Columns<'a> {
    pub fn new(grid: &'a Grid) -> Self {
        let phi = &grid.phi_edges;
        let edges: Vec<[f64; 2]> = phi.iter().map(|phi| [phi.cos(), phi.sin()]).collect();
        let integrals = phi.windows(2).zip(edges.windows(2)).map(|(phi, edge)| {
            let ([cos_left, sin_left], [cos_right, sin_right]) = (edge[0], edge[1]);
            DVec3::new(sin_right - sin_left, cos_left - cos_right, phi[1] - phi[0])
        });
        // Any column but the outer ones, which the seam may cut.
        let width = phi[phi.len() / 2] - phi[phi.len() / 2 - 1];
        let offset = |i: usize| (i as f64 - 0.5 * (BLOCK - 1) as f64) * width;
        let four = |first: usize, f: fn(f64) -> f64| -> FourPixels {
            let sample = |i: usize| f(offset(first + i / 3)) as f32;
            [0, 4, 8].map(|i| Vec4::new(sample(i), sample(i + 1), sample(i + 2), sample(i + 3)))
        };
        Self {
            integrals: integrals.collect(),
            edges,
            offsets: std::array::from_fn(|i| [four(4 * i, f64::cos), four(4 * i, f64::sin)]),
            middles: phi[..phi.len() - 1]
                .chunks(BLOCK)
                .enumerate()
                .map(|(block, _)| middle(phi, block, width))
                .collect(),
            grid,
        }
    }

    fn of_azimuth(&self, phi: f64) -> usize {
        ((phi * self.grid.columns_per_radian + self.grid.first_column) as usize).min(self.integrals.len() - 1)
    }
}

/// Integrals of cos phi, sin phi and 1 over a column of `width` in the middle of `block`; none where
/// the seam cuts a column or the row ends.
fn middle(phi_edges: &[f64], block: usize, width: f64) -> Option<[f32; 3]> {
    let edges = phi_edges.get(BLOCK * block..=BLOCK * (block + 1))?;
    let is_even = edges.windows(2).all(|edge| (edge[1] - edge[0] - width).abs() < 1e-9 * width);
    let (sin, cos) = (0.5 * (edges[0] + edges[BLOCK])).sin_cos();
    let chord = 2.0 * (0.5 * width).sin();
    is_even.then_some([chord * cos, chord * sin, width].map(|x| x as f32))
}

/// Rows that share one horizon, and the prefix sums over their columns.
pub struct Band<'a> {
    columns: &'a Columns<'a>,
    rows: Vec<&'a [[f32; 3]]>,
    /// For each row, how much its cos, its sin and its 1 count.
    weights: Vec<DVec3>,
    /// Flux between the seam and the start of each block, and of the whole.
    prefix: Vec<Flux>,
}

impl<'a> Band<'a> {
    /// A band of no rows; [`Self::set`] fills it, over and over.
    pub fn new(columns: &'a Columns<'a>) -> Self {
        Self { columns, rows: Vec::new(), weights: Vec::new(), prefix: Vec::new() }
    }

    pub fn set(&mut self, rows: Vec<&'a [[f32; 3]]>, weights: Vec<DVec3>) {
        (self.rows, self.weights) = (rows, weights);
        self.prefix.clear();
        let mut sum = [DVec3::ZERO; 3];
        for block in 0..self.columns.middles.len() {
            self.prefix.push(sum);
            let flux = match self.columns.middles[block] {
                Some(middle) => self.even_block(block, middle),
                None => self.uneven_block(block),
            };
            sum = [sum[0] + flux[0], sum[1] + flux[1], sum[2] + flux[2]];
        }
        self.prefix.push(sum);
    }

    /// Two rows at a time.
    #[inline]
    fn even_block(&self, block: usize, [chord_cos, chord_sin, width]: [f32; 3]) -> Flux {
        let first = BLOCK * block;
        let mut sums = [[Vec4::ZERO; 3]; 3];
        let (pairs, last) = self.rows.as_chunks::<2>();
        let (weights_of_pairs, weights_of_last) = self.weights.as_chunks::<2>();
        for (rows, &weights) in pairs.iter().zip(weights_of_pairs) {
            add_sums(&mut sums, rows.map(|row| &row[first..]), weights, &self.columns.offsets);
        }
        for (row, &weights) in last.iter().zip(weights_of_last) {
            add_sums(&mut sums, [&row[first..]], [weights], &self.columns.offsets);
        }
        let [cos, sin, one] = sums.map(by_channel);
        let turned = [cos * chord_cos - sin * chord_sin, cos * chord_sin + sin * chord_cos, one * width];
        turned.map(|flux| flux.truncate().as_dvec3())
    }

    fn uneven_block(&self, block: usize) -> Flux {
        let last = (BLOCK * (block + 1)).min(self.columns.integrals.len());
        let mut flux = [DVec3::ZERO; 3];
        for (row, &weights) in self.rows.iter().zip(&self.weights) {
            for column in BLOCK * block..last {
                let pixel = Vec3::from_array(row[column]).as_dvec3();
                let [cos, sin, one] = (weights * self.columns.integrals[column]).to_array();
                flux = [flux[0] + pixel * cos, flux[1] + pixel * sin, flux[2] + pixel * one];
            }
        }
        flux
    }

    pub fn total(&self) -> &Flux {
        &self.prefix[self.prefix.len() - 1]
    }

    /// `pull . flux` between the seam and the azimuth `phi`; the pixel that it cuts counts in part.
    #[inline]
    pub fn up_to(&self, pull: DVec3, phi: f64, cos_phi: f64, sin_phi: f64) -> DVec3 {
        let columns = self.columns;
        let column = columns.of_azimuth(phi);
        let [cos_edge, sin_edge] = columns.edges[column];
        let part = DVec3::new(sin_phi - sin_edge, cos_edge - cos_phi, phi - columns.grid.phi_edges[column]);
        let nearest = (column + BLOCK / 2) / BLOCK;
        let start = (BLOCK * nearest).min(columns.integrals.len());
        let between = start.min(column)..start.max(column);
        let sign = if start <= column { 1.0 } else { -1.0 };
        let mut sum = weigh(&self.prefix[nearest], pull);
        for (row, &weights) in self.rows.iter().zip(&self.weights) {
            let pull = pull * weights;
            let cut = Vec3::from_array(row[column]).as_dvec3() * pull.dot(part);
            let mut whole = DVec3::ZERO;
            for (&pixel, &integral) in row[between.clone()].iter().zip(&columns.integrals[between.clone()]) {
                whole += Vec3::from_array(pixel).as_dvec3() * pull.dot(integral);
            }
            sum += cut + whole * sign;
        }
        sum
    }
}

/// Add the sums of L cos o, L sin o and L over a block of some rows, still in the lanes where the samples
/// lie. The cos and the sin of a row have one weight: the rows are added up before they meet the offsets.
#[inline]
fn add_sums<const ROWS: usize>(
    sums: &mut [FourPixels; 3],
    rows: [&[[f32; 3]]; ROWS],
    weights: [DVec3; ROWS],
    offsets: &[[FourPixels; 2]],
) {
    let equatorials = weights.map(|weight| Vec4::splat(weight.x as f32));
    let polars = weights.map(|weight| Vec4::splat(weight.z as f32));
    let rows = rows.map(|row| row[..BLOCK].as_flattened().as_chunks::<12>().0);
    for (i, [cos, sin]) in offsets.iter().enumerate() {
        for part in 0..3 {
            let fours = rows.map(|row| Vec4::from_slice(&row[i][4 * part..]));
            let mut equatorial = fours[0] * equatorials[0];
            for row in 1..ROWS {
                equatorial += fours[row] * equatorials[row];
            }
            sums[0][part] += equatorial * cos[part];
            sums[1][part] += equatorial * sin[part];
            for row in 0..ROWS {
                sums[2][part] += fours[row] * polars[row];
            }
        }
    }
}

/// Sum of four pixels: `rgbr gbrg brgb` by channel.
#[inline]
fn by_channel([a, b, c]: FourPixels) -> Vec4 {
    let second = Vec4::new(a.w, b.x, b.y, 0.0);
    let third = Vec4::new(b.z, b.w, c.x, 0.0);
    let fourth = Vec4::new(c.y, c.z, c.w, 0.0);
    (a + second) + (third + fourth)
}

/// `pull . flux`, for each channel.
#[inline]
pub fn weigh([cos, sin, one]: &Flux, pull: DVec3) -> DVec3 {
    *cos * pull.x + *sin * pull.y + *one * pull.z
}
