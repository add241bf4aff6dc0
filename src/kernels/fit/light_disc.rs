//! A disc of uniform radiance, and derivatives by its coordinates.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use glam::DVec3;

use super::jet::Jet;
use crate::kernels::expansion::{Cap, DiscFactors, DiscOfFlux, disc_factors};
use crate::kernels::lanes::Number;

/// A light of uniform radiance within an angular radius.
#[derive(Clone, Copy, Debug)]
pub struct Disc {
    pub direction: DVec3,
    pub radius: f64,
    /// A = sin^2(radius / 2): its vector irradiance is 1 - A times its flux.
    pub share: f64,
    pub cap: Cap,
    pub factors: DiscFactors,
}

impl Disc {
    pub fn new(direction: DVec3, radius: f64) -> Self {
        let share = (0.5 * radius).sin().powi(2);
        Self { direction, radius, share, cap: Cap::new(direction, share), factors: disc_factors(share) }
    }

    /// Two tangents: the first two coordinates of derivatives; the third is A.
    pub fn frame(&self) -> [DVec3; 2] {
        self.cap.frame
    }
}

/// Discs with the fluxes of lights of this `irradiance`.
pub fn of_flux(discs: &[Disc], irradiance: &[DVec3]) -> Vec<DiscOfFlux> {
    let flux = |(disc, irradiance): (&Disc, &DVec3)| {
        (disc.direction, disc.share, (*irradiance / (1.0 - disc.share)).to_array())
    };
    discs.iter().zip(irradiance).map(flux).collect()
}

/// A function of the cosine with a fixed direction and of A (N = 2), by the coordinates of a disc. A tangent t changes the cosine
/// by its own cosine with that direction, which is in `along`, and by `-cosine / 2` to second order.
#[inline(always)]
pub fn on_tangents<const N: usize, T: Number>(product: &Jet<N, T>, cosine: T, [s, t]: [T; 2]) -> Jet<3, T> {
    let (by_cosine, by_a) = (product.first[0], product.first[1]);
    let (cc, ca, aa) = (product.second[0][0], product.second[0][1], product.second[1][1]);
    let round = by_cosine * cosine;
    let (cs, ct) = (cc * s, cc * t);
    Jet {
        value: product.value,
        first: [by_cosine * s, by_cosine * t, by_a],
        second: [[cs * s - round, cs * t, ca * s], [cs * t, ct * t - round, ca * t], [ca * s, ca * t, aa]],
    }
}
