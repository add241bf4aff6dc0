//! What each ring of normals sees of a run of rows.
//!
//! The flux of a row up to each edge of its columns is kept twice around, in an order in which the columns
//! of the successive normals of a ring lie side by side: wide vectors read it, whatever the horizon.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use glam::DVec3;
use ndarray::ArrayView2;
use pulp::{Simd, WithSimd};

use super::even::EvenColumns;
use super::opposite::VectorFlux;
use super::strips::{Strip, View};
use crate::kernels::image::Grid;

/// Normals of a ring are summed in whole vectors: a multiple of the widest.
const WIDEST: usize = 16;

/// Sums of one ring in one channel: of L cos phi, of L sin phi, and of what does not depend on the azimuth
/// of a normal beyond its columns.
const PARTS: usize = 3;

/// Rows of a map, and those who look at them.
pub struct Run<'a> {
    pub rows: Vec<ArrayView2<'a, f32>>,
    /// The index of the first.
    pub first_row: usize,
    pub grid: &'a Grid,
    pub columns: &'a EvenColumns,
    /// The normals of all rings, ring after ring.
    pub normals: &'a [DVec3],
    pub views: &'a [View],
}

/// Irradiance of the normals of all rings, ring after ring, and the vector flux.
pub struct Sums {
    pub irradiance: Vec<DVec3>,
    pub flux: VectorFlux,
}

/// A channel of a row: the flux from the start to each column, and the radiance of that.
#[derive(Default)]
struct Channel {
    cos: Vec<f32>,
    sin: Vec<f32>,
    one: Vec<f32>,
    radiance: Vec<f32>,
    /// The flux of the whole row.
    total: [f64; PARTS],
}

/// Where the columns of a row stand in a [`Channel`].
struct Order {
    /// Columns between two normals.
    step: usize,
    /// Columns before the first of the map.
    before: usize,
    /// Columns of one residue.
    length: usize,
}

impl Order {
    fn new(columns: &EvenColumns) -> Self {
        let step = columns.count / columns.azimuths;
        // The horizon is half a turn before the first normal, or half a turn behind the last.
        let before = (columns.count / 2 + 1).div_ceil(step) * step;
        Self { step, before, length: 2 * columns.azimuths + 3 + WIDEST }
    }

    #[inline(always)]
    fn place(&self, column: isize) -> usize {
        let column = (column + self.before as isize) as usize;
        column % self.step * self.length + column / self.step
    }
}

/// Sum the flux of a row up to each of its `columns`, in f64, for sums grow; they are kept in f32.
#[inline(always)]
fn fill(channels: &mut [Channel; 3], even: &[[f64; 3]], columns: &EvenColumns, order: &Order) {
    for channel in channels.iter_mut() {
        for kept in [&mut channel.cos, &mut channel.sin, &mut channel.one, &mut channel.radiance] {
            kept.resize(order.step * order.length, 0.0);
        }
    }
    // Go around once, from the first column that a horizon may cut.
    let mut column = (columns.count - order.before % columns.count) % columns.count;
    let mut sums = [[0.0; PARTS]; 3];
    for i in 0..columns.azimuths {
        for residue in 0..order.step {
            let place = residue * order.length + i;
            for ((channel, sums), &radiance) in channels.iter_mut().zip(&mut sums).zip(&even[column]) {
                channel.cos[place] = sums[0] as f32;
                channel.sin[place] = sums[1] as f32;
                channel.one[place] = sums[2] as f32;
                channel.radiance[place] = radiance as f32;
                for (sum, integral) in sums.iter_mut().zip(columns.integrals[column]) {
                    *sum += radiance * integral;
                }
            }
            column = if column + 1 == columns.count { 0 } else { column + 1 };
        }
    }
    // Go on as far as a horizon may be.
    for (channel, sums) in channels.iter_mut().zip(sums) {
        channel.total = sums;
        let [cos, sin, one] = sums.map(|sum| sum as f32);
        for (kept, turn) in [
            (&mut channel.cos, cos),
            (&mut channel.sin, sin),
            (&mut channel.one, one),
            (&mut channel.radiance, 0.0),
        ] {
            for kept in kept.chunks_exact_mut(order.length) {
                let (first_turn, rest) = kept.split_at_mut(columns.azimuths);
                for (turns, rest) in rest.chunks_mut(columns.azimuths).enumerate() {
                    let further = turn * (turns + 1) as f32;
                    for (next, first) in rest.iter_mut().zip(&*first_turn) {
                        *next = first + further;
                    }
                }
            }
        }
    }
}

impl WithSimd for Run<'_> {
    type Output = Sums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Sums {
        let order = Order::new(self.columns);
        let padded = self.columns.azimuths.next_multiple_of(WIDEST);
        let mut parts = vec![0.0_f32; self.views.len() * 3 * PARTS * padded];
        let mut whole = vec![[[0.0; PARTS]; 3]; self.views.len()];
        let mut channels: [Channel; 3] = Default::default();
        let mut flux = [DVec3::ZERO; 3];
        let mut even = Vec::new();
        for (i, row) in self.rows.iter().enumerate() {
            // Skip what is black.
            if row.iter().all(|&sample| sample == 0.0) {
                continue;
            }
            // Sum the flux of the row up to each column.
            self.columns.of_row(|column| [0, 1, 2].map(|channel| row[[column, channel]]), &mut even);
            fill(&mut channels, &even, self.columns, &order);
            self.add_whole(self.first_row + i, &channels, &mut flux);
            // Add what each ring sees of it.
            for ((view, parts), whole) in
                self.views.iter().zip(parts.chunks_exact_mut(3 * PARTS * padded)).zip(&mut whole)
            {
                let seen = &view.rows[self.first_row + i];
                for ((channel, parts), whole) in
                    channels.iter().zip(parts.chunks_exact_mut(PARTS * padded)).zip(whole)
                {
                    for (whole, (total, weight)) in whole.iter_mut().zip(channel.total.iter().zip([
                        seen.equatorial,
                        seen.equatorial,
                        seen.polar,
                    ])) {
                        *whole += total * weight;
                    }
                    for strip in &view.strips[seen.strips.clone()] {
                        add_strip(simd, strip, channel, &order, parts, padded);
                    }
                }
            }
        }
        Sums { irradiance: self.irradiance(&parts, &whole, padded), flux }
    }
}

impl Run<'_> {
    /// Add the vector flux of a row.
    fn add_whole(&self, row: usize, channels: &[Channel; 3], flux: &mut VectorFlux) {
        let theta = &self.grid.theta_edges;
        let [equatorial, polar] = super::horizon::row_integrals(theta[row], theta[row + 1]);
        let total = |part: usize| DVec3::from_array([0, 1, 2].map(|i: usize| channels[i].total[part]));
        flux[0] += total(1) * equatorial;
        flux[1] += total(2) * polar;
        flux[2] -= total(0) * equatorial;
    }

    /// Put the parts together: `n_x` and `-n_z` weight the first two.
    #[inline(always)]
    fn irradiance(&self, parts: &[f32], whole: &[[[f64; PARTS]; 3]], padded: usize) -> Vec<DVec3> {
        let mut irradiance = Vec::with_capacity(self.normals.len());
        let rings = self.normals.chunks(self.columns.azimuths).zip(parts.chunks_exact(3 * PARTS * padded));
        for ((normals, parts), whole) in rings.zip(whole) {
            for (i, normal) in normals.iter().enumerate() {
                let part = |channel: usize, part: usize| {
                    f64::from(parts[(PARTS * channel + part) * padded + i]) + whole[channel][part]
                };
                let sum =
                    |channel| normal.x * part(channel, 1) - normal.z * part(channel, 0) + part(channel, 2);
                irradiance.push(DVec3::new(sum(0), sum(1), sum(2)));
            }
        }
        irradiance
    }
}

/// Add what all normals of a ring see of a strip.
#[inline(always)]
fn add_strip<S: Simd>(
    simd: S,
    strip: &Strip,
    channel: &Channel,
    order: &Order,
    parts: &mut [f32],
    padded: usize,
) {
    let (first, last) = (order.place(strip.first), order.place(strip.last));
    let ends = |kept| [wide::<S>(kept, first, padded), wide::<S>(kept, last, padded)];
    let ([cos_first, cos_last], [sin_first, sin_last]) = (ends(&channel.cos), ends(&channel.sin));
    let ([one_first, one_last], [at_first, at_last]) = (ends(&channel.one), ends(&channel.radiance));
    let [equatorial, polar, first_share, last_share] =
        [strip.equatorial, strip.polar, strip.at_first, strip.at_last].map(|x| simd.splat_f32s(x as f32));
    let (cos_sums, rest) = parts.split_at_mut(padded);
    let (sin_sums, sums) = rest.split_at_mut(padded);
    let cos_sums = S::as_mut_simd_f32s(cos_sums).0;
    let sin_sums = S::as_mut_simd_f32s(sin_sums).0;
    let sums = S::as_mut_simd_f32s(sums).0;
    for i in 0..sums.len() {
        let cos = simd.sub_f32s(cos_last[i], cos_first[i]);
        let sin = simd.sub_f32s(sin_last[i], sin_first[i]);
        let one = simd.sub_f32s(one_last[i], one_first[i]);
        cos_sums[i] = simd.mul_add_e_f32s(equatorial, cos, cos_sums[i]);
        sin_sums[i] = simd.mul_add_e_f32s(equatorial, sin, sin_sums[i]);
        let ends = simd.mul_add_e_f32s(
            first_share,
            at_first[i],
            simd.mul_add_e_f32s(last_share, at_last[i], sums[i]),
        );
        sums[i] = simd.mul_add_e_f32s(polar, one, ends);
    }
}

#[inline(always)]
fn wide<S: Simd>(kept: &[f32], place: usize, length: usize) -> &[S::f32s] {
    S::as_simd_f32s(&kept[place..place + length]).0
}
