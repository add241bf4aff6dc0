//! Discs in harmonics, added to others.

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use super::abreast::Abreast;
use super::harmonics::Harmonics;
use super::place::{Legendre, Place};
use super::zonal::DEGREES;
use crate::kernels::fit::azimuthal::Rgb2;
use crate::kernels::fit::lanes::{LANES, Lanes, Number};

impl Harmonics {
    /// Add discs: the direction, the A, and the flux of each.
    pub fn add_discs(&mut self, discs: impl Iterator<Item = (DVec3, f64, [f64; 3])>) {
        let discs: Vec<Added> =
            discs.map(|(towards, share, flux)| Added { place: Place::new(towards), share, flux }).collect();
        Arch::new().dispatch(Addition { values: &mut self.values, discs: &discs });
    }
}

/// A disc that is added.
struct Added {
    place: Place,
    share: f64,
    flux: [f64; 3],
}

impl Added {
    /// Its flux times `cos m phi` and `sin m phi`.
    #[inline(always)]
    fn turned(&self, [cos, sin]: [f64; 2]) -> Rgb2 {
        let [red, green, blue] = self.flux;
        [red * cos, green * cos, blue * cos, 0.0, red * sin, green * sin, blue * sin, 0.0]
    }
}

/// See [`Harmonics::add_discs`].
struct Addition<'a> {
    values: &'a mut [Rgb2],
    discs: &'a [Added],
}

impl WithSimd for Addition<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for discs in self.discs.chunks(S::F64_LANES) {
            let mut abreast = Abreast::new(simd, discs, |disc| (&disc.place, disc.share));
            let mut legendre = Legendre::new(abreast.cosine, abreast.sine);
            let mut later = &mut *self.values;
            for m in 0..DEGREES {
                let (order, rest) = later.split_at_mut(DEGREES - m);
                let column = legendre.column(m);
                let mut turned = [[0.0; 8]; LANES];
                for (lane, (turned, disc)) in turned.iter_mut().zip(discs).enumerate() {
                    *turned = disc.turned(abreast.turn.map(|turn| turn.lane(lane)));
                }
                for (l, value) in (m..DEGREES).zip(order) {
                    add(value, column[l] * abreast.factors[l][0], &turned);
                }
                abreast.advance();
                later = rest;
            }
        }
    }
}

/// Add the share that each disc has of a harmonic; of discs that are not there, nothing.
#[inline(always)]
fn add<S: Simd>(value: &mut Rgb2, weights: Lanes<S>, turned: &[Rgb2; LANES]) {
    let mut sum = *value;
    for (lane, turned) in turned.iter().enumerate().take(S::F64_LANES) {
        let weight = weights.lane(lane);
        (0..8).for_each(|i| sum[i] += weight * turned[i]);
    }
    *value = sum;
}
