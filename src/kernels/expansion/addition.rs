//! Batches of discs, one for each lane of a vector, and the sum of their harmonics.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::f64::consts::PI;

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use super::{AssociatedLegendre, DEGREES, DiscFactors, Harmonics, Rgb2, disc_factors};
use crate::kernels::lanes::{LANES, Lanes, Number};
use crate::kernels::sphere::{angle_derivatives, angles};

/// A disc on the sphere.
#[derive(Clone, Copy, Debug)]
pub struct Cap {
    pub direction: DVec3,
    /// Tangents at its centre, towards larger theta and larger phi.
    pub frame: [DVec3; 2],
    /// Cosine and sine of its azimuth.
    turn: [f64; 2],
    cosine: f64,
    sine: f64,
    /// A = sin^2(radius / 2), so that its vector irradiance is 1 - A times its flux.
    pub share: f64,
}

impl Cap {
    /// Disc of A = `share` in a direction, whose angles are moved off the poles.
    pub fn new(direction: DVec3, share: f64) -> Self {
        /// Least sine of theta, because the derivatives divide by it.
        const LEAST_SINE: f64 = 1e-5;
        let (theta, azimuth) = angles(direction);
        let (sine, cosine) = theta.clamp(LEAST_SINE, PI - LEAST_SINE).sin_cos();
        let frame = [angle_derivatives(theta, azimuth)[0], angle_derivatives(0.5 * PI, azimuth)[1]];
        Self { direction, frame, turn: [azimuth.cos(), azimuth.sin()], cosine, sine, share }
    }
}

/// One disc for each lane of a vector, advanced from one order of harmonics to the next.
pub struct CapBatch<S: Simd> {
    pub cosine: Lanes<S>,
    pub sine: Lanes<S>,
    /// `cos m phi` and `sin m phi` of the current order m.
    pub turn: [Lanes<S>; 2],
    first_turn: [Lanes<S>; 2],
    pub factors: DiscFactors<Lanes<S>>,
    pub legendre: AssociatedLegendre<Lanes<S>>,
}

impl<S: Simd> CapBatch<S> {
    /// Gather the discs of one vector.
    #[inline(always)]
    pub fn new(simd: S, caps: &[Cap]) -> Self {
        let of = |number: fn(&Cap) -> f64| Lanes::gather(simd, caps, number);
        let (cosine, sine) = (of(|cap| cap.cosine), of(|cap| cap.sine));
        Self {
            cosine,
            sine,
            turn: [Lanes::splat(simd, 1.0), Lanes::splat(simd, 0.0)],
            first_turn: [of(|cap| cap.turn[0]), of(|cap| cap.turn[1])],
            factors: disc_factors(of(|cap| cap.share)),
            legendre: AssociatedLegendre::new(cosine, sine),
        }
    }

    /// Advance to the next order.
    #[inline(always)]
    pub fn advance(&mut self) {
        let ([cos, sin], [first_cos, first_sin]) = (self.turn, self.first_turn);
        self.turn = [cos * first_cos - sin * first_sin, cos * first_sin + sin * first_cos];
    }
}

impl Harmonics {
    /// Add discs, each given by direction, `A = sin^2(radius / 2)` and flux.
    pub fn add_discs(&mut self, discs: impl Iterator<Item = (DVec3, f64, [f64; 3])>) {
        let (caps, fluxes): (Vec<Cap>, Vec<[f64; 3]>) =
            discs.map(|(direction, share, flux)| (Cap::new(direction, share), flux)).unzip();
        Arch::new().dispatch(Addition { values: &mut self.values, caps: &caps, fluxes: &fluxes });
    }
}

/// See [`Harmonics::add_discs`].
struct Addition<'a> {
    values: &'a mut [Rgb2],
    caps: &'a [Cap],
    fluxes: &'a [[f64; 3]],
}

impl WithSimd for Addition<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (caps, fluxes) in self.caps.chunks(S::F64_LANES).zip(self.fluxes.chunks(S::F64_LANES)) {
            let mut batch = CapBatch::new(simd, caps);
            let mut later = &mut *self.values;
            for m in 0..DEGREES {
                let (order, rest) = later.split_at_mut(DEGREES - m);
                let mut waves = [[0.0; 8]; LANES];
                for (lane, [red, green, blue]) in fluxes.iter().enumerate() {
                    let [cos, sin] = [batch.turn[0].lane(lane), batch.turn[1].lane(lane)];
                    waves[lane] =
                        [red * cos, green * cos, blue * cos, 0.0, red * sin, green * sin, blue * sin, 0.0];
                }
                let column = batch.legendre.column(m);
                for (l, value) in (m..DEGREES).zip(order) {
                    let weights = column[l] * batch.factors[l][0];
                    for (lane, wave) in waves.iter().enumerate().take(S::F64_LANES) {
                        let weight = weights.lane(lane);
                        for i in 0..8 {
                            value[i] += weight * wave[i];
                        }
                    }
                }
                batch.advance();
                later = rest;
            }
        }
    }
}
