//! A disc of uniform radiance, and what depends on where it stands.

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use glam::DVec3;

use super::jet::Jet;
use super::place::Place;
use super::zonal::{Factors, factors};

/// A light of uniform radiance within an angular radius.
#[derive(Clone, Copy, Debug)]
pub struct Disc {
    pub direction: DVec3,
    pub radius: f64,
    /// A = sin^2(radius / 2): its vector irradiance is 1 - A times its flux.
    pub share: f64,
    pub place: Place,
    pub factors: Factors,
}

impl Disc {
    pub fn new(direction: DVec3, radius: f64) -> Self {
        let share = (0.5 * radius).sin().powi(2);
        Self { direction, radius, share, place: Place::new(direction), factors: factors(share) }
    }

    /// Two tangents: the first two coordinates of derivatives; the third is A.
    pub fn frame(&self) -> [DVec3; 2] {
        self.place.frame
    }
}

/// A function of the cosine with a fixed direction and of A, by the coordinates of a disc: along a tangent t, the
/// cosine changes by `t.other`, and by `-cosine / 2` to second order.
#[inline(always)]
pub fn on_tangents(product: &Jet<2>, disc: &Disc, other: DVec3, cosine: f64) -> Jet<3> {
    let [s, t] = disc.frame();
    let (s, t) = (s.dot(other), t.dot(other));
    let [by_cosine, by_a] = product.first;
    let [[cc, ca], [_, aa]] = product.second;
    let round = -by_cosine * cosine;
    Jet {
        value: product.value,
        first: [by_cosine * s, by_cosine * t, by_a],
        second: [
            [cc * s * s + round, cc * s * t, ca * s],
            [cc * s * t, cc * t * t + round, ca * t],
            [ca * s, ca * t, aa],
        ],
    }
}
