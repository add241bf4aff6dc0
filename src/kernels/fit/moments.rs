//! Every sum over the normals that a fit needs.
//!
//! Equations 4 to 6 of Madsen et al. 2003 in physical scale (the paper's `k_a` is pi, `k_d` and C are 1):
//!
//! ```text
//!   E(n) = sum_i c_i A_i(n) + sum_j E_j max(0, n.l_j)        A: pi, or harmonics (`ambient.rs`)
//! ```
//!
//! For fixed directions this is linear in `c_i` and `E_j`. The columns of the lights, and their
//! derivatives when `l_j` moves along its tangents `s_j`, `t_j`, are
//!
//! ```text
//!   a_j = v_j.l_j      da_j = v_j.s_j, v_j.t_j      v_j(n) = n where n.l_j > 0, else 0
//! ```
//!
//! so all their weighted inner products come from the hemisphere moments
//!
//! ```text
//!   sum w v_j y   for each ambient column and channel y        sum w v_j v_k^T
//! ```
//!
//! turned into the frames (l, s, t). A light that turns by a small step gains and loses few normals:
//! only these are added and subtracted.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use glam::{DMat3, DVec3};
use nalgebra::DMatrix;
use pulp::{Simd, WithSimd};

use super::probe::Probe;
use crate::kernels::sphere::tangents;

/// Inner products of the columns `[A.., a_1, a_2, .., s_1, t_1, s_2, t_2, ..]`: the model, then what
/// it changes by when a light turns.
#[derive(Clone, Debug)]
pub struct Moments {
    /// Towards each light.
    pub directions: Vec<DVec3>,
    /// The tangents of each light.
    pub tangents: Vec<[DVec3; 2]>,
    /// Of the columns with each other.
    pub gram: DMatrix<f64>,
    /// Of the columns with the irradiance in each fitted channel.
    pub right: DMatrix<f64>,
    sums: Sums,
}

/// The sums over the normals themselves, in the frame of the world.
#[derive(Clone, Debug, Default)]
struct Sums {
    /// Of the lights that have a sum.
    directions: Vec<DVec3>,
    /// The normals that see each light, as bits: so many words for each.
    visible: Vec<u64>,
    /// `sum w v_j y`: for each light, as [`Probe::lit`].
    lit: Vec<f64>,
    /// `sum w v_j v_k^T` for k <= j, as [`Probe::outer`].
    pairs: Vec<[f64; 6]>,
}

impl Moments {
    /// All sums over the normals of `probe` for lights in `directions`.
    pub fn new(probe: &Probe, directions: &[DVec3]) -> Self {
        Self::of(probe, Sums::default().resized(probe, directions.len()), directions.to_vec())
    }

    /// The lights `kept`, and others in the directions `new` after them.
    pub fn with(&self, probe: &Probe, kept: &[usize], new: &[DVec3]) -> Self {
        let directions = kept.iter().map(|&j| self.directions[j]).chain(new.iter().copied()).collect();
        Self::of(probe, self.sums.only(probe, kept).resized(probe, kept.len() + new.len()), directions)
    }

    /// The same lights in other `directions`.
    pub fn turned(&self, probe: &Probe, directions: Vec<DVec3>) -> Self {
        Self::of(probe, self.sums.clone(), directions)
    }

    /// Lights, each with a normal whose horizon it crosses on the way to `other` directions.
    pub fn crossed(&self, probe: &Probe, other: &Self) -> Vec<(usize, DVec3)> {
        let words = words(probe);
        let both = self.sums.visible.iter().zip(&other.sums.visible).enumerate();
        both.flat_map(|(i, (&here, &there))| {
            changes(here, there, i % words).map(move |(normal, _)| (i / words, probe.samples.normals[normal]))
        })
        .collect()
    }

    /// From `sums` of as many lights elsewhere.
    fn of(probe: &Probe, mut sums: Sums, directions: Vec<DVec3>) -> Self {
        sums.turn(probe, &directions);
        let tangents = directions.iter().map(|&l| tangents(l)).collect();
        let size = probe.ambient.coefficients() + 3 * directions.len();
        let gram = DMatrix::zeros(size, size);
        let right = DMatrix::zeros(size, probe.channels.len());
        let mut moments = Self { directions, tangents, gram, right, sums };
        moments.set_products(probe);
        moments
    }

    /// Number of columns of the model, which come before their derivatives.
    pub fn columns(&self) -> usize {
        self.gram.nrows() - 2 * self.directions.len()
    }

    /// The three columns of a light.
    fn places(&self, light: usize) -> [usize; 3] {
        let (columns, lights) = (self.columns(), self.directions.len());
        [columns - lights + light, columns + 2 * light, columns + 2 * light + 1]
    }

    /// The sums, turned into the frames of the lights.
    fn set_products(&mut self, probe: &Probe) {
        let ambient = probe.ambient.coefficients();
        self.gram.view_mut((0, 0), (ambient, ambient)).copy_from(&probe.ambient_gram.columns(0, ambient));
        self.right.rows_mut(0, ambient).copy_from(&probe.ambient_gram.columns_range(ambient..));
        let frame = |(&l, &[s, t]): (&DVec3, &[DVec3; 2])| DMat3::from_cols(l, s, t);
        let frames: Vec<DMat3> = self.directions.iter().zip(&self.tangents).map(frame).collect();
        for (j, frame) in frames.iter().enumerate() {
            self.set_sides(probe, j, frame);
            for (k, other) in frames[..=j].iter().enumerate() {
                let sum = symmetric(self.sums.pairs[pair(j, k)]);
                self.set_pair(j, k, frame.transpose() * sum * *other);
            }
        }
    }

    fn set_sides(&mut self, probe: &Probe, light: usize, frame: &DMat3) {
        let places = self.places(light);
        let sides = self.sums.lit.as_chunks::<3>().0;
        let sides = &sides[light * probe.sides()..(light + 1) * probe.sides()];
        for (side, &sum) in sides.iter().enumerate() {
            let products = (frame.transpose() * DVec3::from_array(sum)).to_array();
            for (row, product) in places.into_iter().zip(products) {
                if let Some(channel) = side.checked_sub(probe.ambient.coefficients()) {
                    self.right[(row, channel)] = product;
                } else {
                    self.gram[(row, side)] = product;
                    self.gram[(side, row)] = product;
                }
            }
        }
    }

    fn set_pair(&mut self, j: usize, k: usize, products: DMat3) {
        let (rows, columns) = (self.places(j), self.places(k));
        for (column, products) in columns.into_iter().zip(products.to_cols_array_2d()) {
            for (row, product) in rows.into_iter().zip(products) {
                self.gram[(row, column)] = product;
                self.gram[(column, row)] = product;
            }
        }
    }
}

impl Sums {
    /// Those of the lights `kept` alone.
    fn only(&self, probe: &Probe, kept: &[usize]) -> Self {
        let (words, sides) = (words(probe), 3 * probe.sides());
        let mut sums = Self::default();
        for (row, &j) in kept.iter().enumerate() {
            sums.directions.push(self.directions[j]);
            sums.visible.extend_from_slice(&self.visible[j * words..(j + 1) * words]);
            sums.lit.extend_from_slice(&self.lit[j * sides..(j + 1) * sides]);
            sums.pairs.extend(kept[..=row].iter().map(|&k| self.pairs[pair(j, k)]));
        }
        sums
    }

    /// With further lights, so far seen by no normal.
    fn resized(mut self, probe: &Probe, lights: usize) -> Self {
        self.visible.resize(lights * words(probe), 0);
        self.lit.resize(3 * lights * probe.sides(), 0.0);
        self.pairs.resize(pair(lights, 0), [0.0; 6]);
        self
    }

    /// Add and subtract the normals that see a light from `directions` and did not, or no longer do.
    fn turn(&mut self, probe: &Probe, directions: &[DVec3]) {
        let (words, sides) = (words(probe), 3 * probe.sides());
        let mut seen = self.visible.clone();
        for (j, (&direction, seen)) in directions.iter().zip(seen.chunks_mut(words)).enumerate() {
            if self.directions.get(j) != Some(&direction) {
                probe.widest.dispatch(Visible { probe, direction, seen });
            }
        }
        for j in 0..directions.len() {
            let lit = &mut self.lit[j * sides..(j + 1) * sides];
            for word in 0..words {
                let (old, new) = (self.visible[j * words + word], seen[j * words + word]);
                change_lit(probe, changes(old, new, word), lit);
                for k in 0..=j {
                    let old = old & self.visible[k * words + word];
                    let new = new & seen[k * words + word];
                    change_pair(probe, changes(old, new, word), &mut self.pairs[pair(j, k)]);
                }
            }
        }
        self.visible = seen;
        self.directions = directions.to_vec();
    }
}

/// Place of the pair k <= j.
fn pair(j: usize, k: usize) -> usize {
    j * (j + 1) / 2 + k
}

/// How many words hold a bit for each normal.
fn words(probe: &Probe) -> usize {
    probe.samples.normals.len().div_ceil(64)
}

/// One bit each: to take them from a table is faster than to shift by another number in each lane.
const BITS: [u64; 64] = {
    let mut bits = [1; 64];
    let mut i = 1;
    while i < 64 {
        bits[i] = bits[i - 1] << 1;
        i += 1;
    }
    bits
};

/// A normal this close to a right angle with a light does not see it: where normals stand on a terminator,
/// as those of an icosphere do, rounding must not decide to which side of it they belong.
const TERMINATOR: f64 = 1e-12;

/// Sets the bits of `seen` to the normals that see a light in `direction`.
struct Visible<'a> {
    probe: &'a Probe,
    direction: DVec3,
    seen: &'a mut [u64],
}

impl WithSimd for Visible<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { probe, direction, seen } = self;
        let [x, y, z] = [0, 1, 2].map(|axis| probe.axes[axis].chunks(64));
        for (word, ((x, y), z)) in seen.iter_mut().zip(x.zip(y).zip(z)) {
            *word = 0;
            for (((x, y), z), bit) in x.iter().zip(y).zip(z).zip(BITS) {
                let along = x * direction.x + y * direction.y + z * direction.z;
                *word |= if along > TERMINATOR { bit } else { 0 };
            }
        }
    }
}

/// The normals in which two sets differ: +1 for those that came, -1 for those that went.
fn changes(old: u64, new: u64, word: usize) -> impl Iterator<Item = (usize, f64)> {
    let mut rest = old ^ new;
    std::iter::from_fn(move || {
        (rest != 0).then(|| {
            let bit = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            (64 * word + bit, if new >> bit & 1 == 1 { 1.0 } else { -1.0 })
        })
    })
}

fn change_lit(probe: &Probe, changes: impl Iterator<Item = (usize, f64)>, lit: &mut [f64]) {
    for (normal, sign) in changes {
        for (sum, term) in lit.iter_mut().zip(&probe.lit[normal * 3 * probe.sides()..]) {
            *sum += term * sign;
        }
    }
}

fn change_pair(probe: &Probe, changes: impl Iterator<Item = (usize, f64)>, pair: &mut [f64; 6]) {
    for (normal, sign) in changes {
        for (sum, term) in pair.iter_mut().zip(probe.outer[normal]) {
            *sum += term * sign;
        }
    }
}

/// The matrix with this diagonal and these entries xy, yz, zx.
fn symmetric([xx, yy, zz, xy, yz, zx]: [f64; 6]) -> DMat3 {
    DMat3::from_cols(DVec3::new(xx, xy, zx), DVec3::new(xy, yy, yz), DVec3::new(zx, yz, zz))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::{Ambient, Samples};
    use crate::kernels::sampling;
    use crate::kernels::sphere::exponential_map;
    use approx::assert_abs_diff_eq;
    use ndarray::Array2;

    fn probe(ambient: Ambient) -> Probe {
        let (normals, weights) = sampling::icosphere(320).unwrap();
        let colour = |i: usize, c: usize| ((7 * i + 3 * c) % 11) as f64;
        let irradiance = Array2::from_shape_fn((320, 3), |(i, c)| colour(i, c));
        Probe::new(Samples::new(normals.view(), weights.view(), irradiance.view()).unwrap(), ambient)
    }

    fn directions() -> Vec<DVec3> {
        [DVec3::Y, DVec3::new(1.0, 2.0, -2.0) / 3.0, DVec3::new(2.0, -6.0, 3.0) / 7.0].to_vec()
    }

    /// Each column at each normal, as the head of this file defines it.
    fn columns(probe: &Probe, moments: &Moments) -> Vec<Vec<f64>> {
        let ambient = |i: usize| {
            let columns = probe.samples.normals.iter().map(move |&n| probe.ambient.irradiance(n)[i]);
            columns.collect::<Vec<f64>>()
        };
        let along = |light: DVec3, axis: DVec3| {
            let seen = probe
                .samples
                .normals
                .iter()
                .map(|n| if n.dot(light) > TERMINATOR { n.dot(axis) } else { 0.0 });
            seen.collect::<Vec<f64>>()
        };
        let lights = moments.directions.iter().map(|&l| along(l, l));
        let frames = moments.directions.iter().zip(&moments.tangents);
        let derivatives = frames.flat_map(|(&l, &[s, t])| [along(l, s), along(l, t)]);
        (0..probe.ambient.coefficients()).map(ambient).chain(lights).chain(derivatives).collect()
    }

    fn assert_sums(probe: &Probe, moments: &Moments) {
        let columns = columns(probe, moments);
        let sum = |a: &[f64], b: &[f64]| -> f64 {
            a.iter().zip(b).zip(&probe.samples.weights).map(|((a, b), w)| w * a * b).sum()
        };
        for (i, a) in columns.iter().enumerate() {
            for (j, b) in columns.iter().enumerate() {
                assert_abs_diff_eq!(moments.gram[(i, j)], sum(a, b), epsilon = 1e-12);
            }
            for channel in 0..3 {
                let irradiance: Vec<f64> = probe.samples.irradiance.iter().map(|e| e[channel]).collect();
                assert_abs_diff_eq!(moments.right[(i, channel)], sum(a, &irradiance), epsilon = 1e-11);
            }
        }
    }

    #[test]
    fn the_moments_are_the_plain_sums() {
        for ambient in [Ambient::None, Ambient::Constant, Ambient::Sh2] {
            let probe = probe(ambient);
            assert_sums(&probe, &Moments::new(&probe, &directions()));
        }
    }

    #[test]
    fn turned_taken_out_and_put_in_they_still_are() {
        let probe = probe(Ambient::Constant);
        let moments = Moments::new(&probe, &directions());
        let turn = |&l: &DVec3| exponential_map(l, tangents(l)[1] * 0.7);
        let turned = moments.turned(&probe, directions().iter().map(turn).collect());
        assert_sums(&probe, &turned);
        let changed = turned.with(&probe, &[0, 2], &[DVec3::NEG_X, DVec3::NEG_Y]);
        assert_eq!(changed.directions[2..], [DVec3::NEG_X, DVec3::NEG_Y]);
        assert_sums(&probe, &changed);
    }
}
