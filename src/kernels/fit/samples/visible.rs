//! Moments as sums over the normals that one light, or both of two lights, reach.
//!
//! Let `v_j(n) = n` if the light j reaches the normal n, else 0. A side y is a vector that the lights are multiplied
//! with: an ambient column, or the irradiance in a channel. The moments are
//!
//! ```text
//!   <v_j, y> = sum w v_j y        <v_j, v_k^T> = sum w v_j v_k^T
//! ```
//!
//! A light that turns by a small step gains and loses few normals, so only these are added and subtracted.

use glam::{DMat3, DVec3};

use super::blocks::SAMPLES;
use super::pairs::{self, pair};
use super::probe::Probe;
use crate::kernels::fit::objective::Moments;

/// The moments of the lights `kept` of `before`, and of others in the directions `new` after them.
pub fn exchange(probe: &Probe, before: &Moments, kept: &[usize], new: &[DVec3]) -> Moments {
    let (words, sides) = (probe.samples.blocks.words(), probe.reference.sides());
    let lights = kept.len() + new.len();
    let directions = kept.iter().map(|&j| before.directions[j]).chain(new.iter().copied()).collect();
    let mut sums = VisibleSums {
        visible: kept.iter().flat_map(|&j| before.visible[j * words..][..words].to_vec()).collect(),
        sides: kept.iter().flat_map(|&j| before.sides[j * sides..][..sides].to_vec()).collect(),
        pairs: Vec::with_capacity(pair(lights, 0)),
    };
    for (row, &j) in kept.iter().enumerate() {
        sums.pairs.extend(kept[..=row].iter().map(|&k| before.pairs[pair(j, k)]));
    }
    let mut visible = sums.visible.clone();
    visible.extend(probe.samples.blocks.visible(new));
    // The new lights reach no normal yet.
    sums.visible.resize(lights * words, 0);
    sums.sides.resize(lights * sides, DVec3::ZERO);
    sums.pairs.resize(pair(lights, 0), DMat3::ZERO);
    sums.update(probe, visible);
    sums.moments(probe, directions)
}

/// The moments of the lights of `before`, turned to other `directions`.
pub fn turn(probe: &Probe, before: &Moments, directions: Vec<DVec3>) -> Moments {
    let (visible, sides, pairs) = (before.visible.clone(), before.sides.clone(), before.pairs.clone());
    let mut sums = VisibleSums { visible, sides, pairs };
    sums.update(probe, probe.samples.blocks.visible(&directions));
    sums.moments(probe, directions)
}

/// Each light with each normal that it reaches in `from` or in `to`, but not in both.
pub fn crossings(probe: &Probe, from: &Moments, to: &Moments) -> Vec<(usize, DVec3)> {
    let words = probe.samples.blocks.words();
    let both = from.visible.iter().zip(&to.visible).enumerate();
    both.flat_map(|(i, (&here, &there))| {
        members(here ^ there, i % words).map(move |normal| (i / words, probe.samples.normals[normal]))
    })
    .collect()
}

/// Sums over the normals that lights reach.
struct VisibleSums {
    /// A bit for each normal that a light reaches, the words of one light after those of another.
    visible: Vec<u64>,
    sides: Vec<DVec3>,
    pairs: Vec<DMat3>,
}

impl VisibleSums {
    /// Add and subtract the normals whose bits in `visible` differ from the old ones.
    fn update(&mut self, probe: &Probe, visible: Vec<u64>) {
        let (words, sides) = (probe.samples.blocks.words(), probe.reference.sides());
        let lights = visible.len() / words.max(1);
        let bits = |from: &[u64], j: usize, word: usize| from[j * words + word];
        for j in 0..lights {
            for word in 0..words {
                let (before, now) = (bits(&self.visible, j, word), bits(&visible, j, word));
                for (normal, sign) in changes(before, now, word) {
                    let row = &probe.by_side[normal * sides..(normal + 1) * sides];
                    let sums = &mut self.sides[j * sides..(j + 1) * sides];
                    sums.iter_mut().zip(row).for_each(|(sum, term)| *sum += sign * *term);
                }
                for k in 0..=j {
                    let before = before & bits(&self.visible, k, word);
                    let now = now & bits(&visible, k, word);
                    let sum = &mut self.pairs[pair(j, k)];
                    changes(before, now, word).for_each(|(normal, sign)| *sum += probe.outer[normal] * sign);
                }
            }
        }
        self.visible = visible;
    }

    fn moments(self, probe: &Probe, directions: Vec<DVec3>) -> Moments {
        let moments = pairs::moments(&probe.reference, directions, self.sides, self.pairs);
        Moments { visible: self.visible, ..moments }
    }
}

/// The normals whose bits differ, with the sign of the change.
fn changes(before: u64, now: u64, word: usize) -> impl Iterator<Item = (usize, f64)> {
    members(before ^ now, word)
        .map(move |normal| (normal, if now >> (normal % SAMPLES) & 1 == 1 { 1.0 } else { -1.0 }))
}

/// The normals whose bits are set in one word.
fn members(mut bits: u64, word: usize) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (bits != 0).then(|| {
            let bit = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            SAMPLES * word + bit
        })
    })
}
