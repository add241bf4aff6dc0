//! Sums over the normals that see a light, or two of them: hemisphere moments.
//!
//! With `v_j(n) = n` where a normal n sees the light j, else 0, for each side y of the probe
//!
//! ```text
//!   sum w v_j y        sum w v_j v_k^T
//! ```
//!
//! A light that turns by a small step gains and loses few normals: only these are added and subtracted.

use glam::{DMat3, DVec3};

use super::blocks::SAMPLES;
use super::probe::Probe;

/// The sums of some lights, in the frame of the world.
#[derive(Clone, Debug, Default)]
pub struct Sums {
    /// The normals that see each light, as bits: so many words for each.
    visible: Vec<u64>,
    /// `sum w v_j y`: for each light, as [`Probe::lit`].
    lit: Vec<[f64; 4]>,
    /// `sum w v_j v_k^T` for k <= j, as [`Probe::outer`].
    pairs: Vec<[f64; 6]>,
}

impl Sums {
    /// Of lights in `directions`.
    pub fn new(probe: &Probe, directions: &[DVec3]) -> Self {
        Self::default().with(probe, &[], directions)
    }

    /// Of the lights `kept` alone, and others in the directions `new` after them.
    pub fn with(&self, probe: &Probe, kept: &[usize], new: &[DVec3]) -> Self {
        let (words, length) = (probe.samples.blocks.words(), probe.lit_length());
        let lights = kept.len() + new.len();
        let mut sums = Self {
            visible: Vec::with_capacity(lights * words),
            lit: Vec::with_capacity(lights * length),
            pairs: Vec::with_capacity(pair(lights, 0)),
        };
        for (row, &j) in kept.iter().enumerate() {
            sums.visible.extend_from_slice(&self.visible[j * words..(j + 1) * words]);
            sums.lit.extend_from_slice(&self.lit[j * length..(j + 1) * length]);
            sums.pairs.extend(kept[..=row].iter().map(|&k| self.pairs[pair(j, k)]));
        }
        let mut visible = sums.visible.clone();
        visible.extend(probe.samples.blocks.seen(new));
        // So far seen by no normal.
        sums.visible.resize(lights * words, 0);
        sums.lit.resize(lights * length, [0.0; 4]);
        sums.pairs.resize(pair(lights, 0), [0.0; 6]);
        sums.see(probe, visible);
        sums
    }

    /// Of the same lights in other `directions`.
    pub fn turned(&self, probe: &Probe, directions: &[DVec3]) -> Self {
        let mut sums = self.clone();
        sums.see(probe, probe.samples.blocks.seen(directions));
        sums
    }

    /// Lights, each with a normal that sees it either here or in `other`.
    pub fn crossed(&self, probe: &Probe, other: &Self) -> Vec<(usize, DVec3)> {
        let words = probe.samples.blocks.words();
        let both = self.visible.iter().zip(&other.visible).enumerate();
        both.flat_map(|(i, (&here, &there))| {
            members(here ^ there, i % words).map(move |normal| (i / words, probe.samples.normals[normal]))
        })
        .collect()
    }

    /// `sum w v_j y` of the light j for each side y of the probe.
    pub fn lit(&self, probe: &Probe, light: usize) -> impl Iterator<Item = DVec3> {
        let length = probe.lit_length();
        let sums = self.lit[light * length..(light + 1) * length].as_flattened().as_chunks().0;
        sums[..probe.sides()].iter().map(|&sum| DVec3::from_array(sum))
    }

    /// `sum w v_j v_k^T`.
    pub fn pair(&self, j: usize, k: usize) -> DMat3 {
        let [xx, yy, zz, xy, yz, zx] = self.pairs[pair(j.max(k), j.min(k))];
        DMat3::from_cols(DVec3::new(xx, xy, zx), DVec3::new(xy, yy, yz), DVec3::new(zx, yz, zz))
    }

    /// From now on the lights are seen by the normals whose bits are set in `visible`.
    fn see(&mut self, probe: &Probe, visible: Vec<u64>) {
        let (words, length) = (probe.samples.blocks.words(), probe.lit_length());
        let changes = |j: usize| {
            let words = j * words..(j + 1) * words;
            self.visible[words.clone()].iter().zip(&visible[words])
        };
        for (j, lit) in self.lit.chunks_exact_mut(length).enumerate() {
            for (part, sum) in lit.iter_mut().enumerate() {
                let own = changes(j).map(|(&before, &now)| [before, now]);
                *sum = changed(*sum, own, |normal| &probe.lit[normal * length + part]);
            }
            for k in 0..=j {
                let both = changes(j).zip(changes(k)).map(|((b, n), (before, now))| [b & before, n & now]);
                let sum = &mut self.pairs[pair(j, k)];
                *sum = changed(*sum, both, |normal| &probe.outer[normal]);
            }
        }
        self.visible = visible;
    }
}

/// Place of the pair k <= j.
fn pair(j: usize, k: usize) -> usize {
    j * (j + 1) / 2 + k
}

/// `sum` with the terms of the normals that see a light now and did not before, by the bits of each word,
/// and without those of the normals that did.
fn changed<'a, const N: usize>(
    mut sum: [f64; N],
    changes: impl Iterator<Item = [u64; 2]>,
    term: impl Fn(usize) -> &'a [f64; N],
) -> [f64; N] {
    for (word, [before, now]) in changes.enumerate() {
        for normal in members(before ^ now, word) {
            let sign = if now >> (normal % SAMPLES) & 1 == 1 { 1.0 } else { -1.0 };
            let term = term(normal);
            (0..N).for_each(|i| sum[i] += sign * term[i]);
        }
    }
    sum
}

/// The normals whose bits of a word are set.
fn members(mut bits: u64, word: usize) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (bits != 0).then(|| {
            let bit = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            SAMPLES * word + bit
        })
    })
}
