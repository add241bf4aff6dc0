//! Discs side by side in vectors, from one order of harmonics to the next.

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use pulp::Simd;

use super::place::Place;
use super::zonal::{Factors, factors};
use crate::kernels::fit::lanes::Lanes;

/// As many discs as one vector holds numbers.
pub struct Abreast<S: Simd> {
    pub cosine: Lanes<S>,
    pub sine: Lanes<S>,
    /// `cos m phi` and `sin m phi` of the orders m that come one after the other.
    pub turn: [Lanes<S>; 2],
    first_turn: [Lanes<S>; 2],
    pub factors: Factors<Lanes<S>>,
}

impl<S: Simd> Abreast<S> {
    /// Of discs of which `at` tells the place and A.
    #[inline(always)]
    pub fn new<A>(simd: S, discs: &[A], at: impl Fn(&A) -> (&Place, f64)) -> Self {
        let of = |number: fn(&Place) -> f64| Lanes::gathered(simd, discs, |disc| number(at(disc).0));
        Self {
            cosine: of(|place| place.cosine),
            sine: of(|place| place.sine),
            turn: [Lanes::splat(simd, 1.0), Lanes::splat(simd, 0.0)],
            first_turn: [of(|place| place.azimuth.cos()), of(|place| place.azimuth.sin())],
            factors: factors(Lanes::gathered(simd, discs, |disc| at(disc).1)),
        }
    }

    /// On to the next order.
    #[inline(always)]
    pub fn advance(&mut self) {
        let ([cos, sin], [first_cos, first_sin]) = (self.turn, self.first_turn);
        self.turn = [cos * first_cos - sin * first_sin, cos * first_sin + sin * first_cos];
    }
}
