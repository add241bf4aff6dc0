//! Lights with a size: discs of uniform radiance, fitted so that the rig is right where things stand in the way.
//!
//! The error is `<D, D>` of the difference D of two distributions of radiance, under the map and under the rig, with a
//! kernel that sees shadows (`zonal.rs`). [`Sizes::fitted`] starts from lights without a size:
//!
//! | step                                                  | file            |
//! |-------------------------------------------------------|-----------------|
//! | kernels, and discs, in Legendre polynomials           | `zonal.rs`      |
//! | numbers with derivatives                              | `jet.rs`        |
//! | the cone of the kernel, between two discs             | `chord.rs`      |
//! | - for discs that are far apart                        | `far.rs`        |
//! | a light; bright cells of the map and their cones      | `disc.rs`, `patches.rs` |
//! | inner products of discs, the map and the ambient term | `target.rs`     |
//! | radii to start from                                   | `start.rs`      |
//! | the objective of a descent                            | `shadows.rs`    |
//! | escape from a local minimum                           | `exchange.rs`   |
//! | the error at normals                                  | `judge.rs`      |

mod chord;
mod disc;
mod exchange;
mod far;
mod jet;
mod judge;
mod patches;
mod shadows;
mod start;
pub mod target;
mod zonal;

pub use judge::judged;
pub use zonal::Comparison;

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

pub use self::disc::Disc;
use self::exchange::exchanged;
use self::shadows::LEAST_RADIUS;
pub use self::shadows::Shadows;
use self::target::{Picture, Target};
use super::damped_newton::Descent;
use super::objective::Given;
use super::options::FitOptions;
use super::relative_rms::relative_error;
use super::rig::Rig;
use super::state::{State, StopReason};
use super::uncertainty;
use crate::kernels::expansion::Expansion;
use crate::kernels::image::WorkingMap;

/// Relative fall of the cost in one step at which a start has shown what it is worth, and at which an answer is final:
/// what steps would still gain there is less than 1e-7 of the error, on real maps.
const ROUGH: f64 = 1e-2;
const FINE: f64 = 1e-6;

/// A rig whose lights have angular radii, and how it was found.
#[derive(Clone, Debug)]
pub struct Sized {
    pub rig: Rig,
    pub radii: Vec<f64>,
    /// How far each light may stand elsewhere; none where that was not asked here.
    pub tolerances: Option<Vec<f64>>,
    pub steps: usize,
    /// Why the descent ended, where there was one.
    pub stop: Option<StopReason>,
}

impl Sized {
    /// Lights without a size.
    pub fn points(rig: Rig) -> Self {
        Self { radii: vec![0.0; rig.directions.len()], rig, tolerances: None, steps: 0, stop: None }
    }
}

/// A map, ready to be compared with lights that have sizes.
#[derive(Clone, Debug)]
pub struct Sizes<'a> {
    map: &'a WorkingMap,
    shadows: Target,
    /// Another kernel to fit by.
    other: Option<Target>,
}

impl<'a> Sizes<'a> {
    /// For a map and its harmonics.
    pub fn new(map: &'a WorkingMap, expansion: &Expansion, options: &FitOptions) -> Self {
        let picture = Picture::new(map, expansion);
        let target = |comparison| Target::new(&picture, comparison, options.ambient, options.has_floor);
        let other = options.sizes.filter(|&comparison| comparison != Comparison::Shadows).map(target);
        Self { map, shadows: target(Comparison::Shadows), other }
    }

    /// Relative RMS error of the irradiance behind every plane, under a rig whose lights have these radii. A pixel of
    /// the map is the square that it is.
    pub fn shadow_error(&self, given: &Given, rig: &Rig, radii: &[f64]) -> f64 {
        let lights = rig.directions.iter().zip(radii);
        let discs: Vec<Disc> =
            lights.map(|(&direction, radius)| Disc::new(direction, radius.max(LEAST_RADIUS))).collect();
        let (gram, rhs) = self.shadows.products(&discs);
        let flux =
            rig.irradiance.iter().zip(&discs).map(|(&irradiance, disc)| irradiance / (1.0 - disc.share));
        let x: Vec<DVec3> = rig.ambient.iter().copied().chain(flux).collect();
        let x = DMatrix::from_fn(x.len(), 3, |i, c| x[i][c]);
        let used = &gram * &x;
        let left = |c: usize| {
            self.shadows.energy[c] + used.column(c).dot(&x.column(c)) - 2.0 * rhs.column(c).dot(&x.column(c))
        };
        let counted = |c: &usize| given.like[*c].is_some();
        let left: f64 = (0..3).filter(counted).map(left).sum();
        let energy: f64 = (0..3).filter(counted).map(|c| self.shadows.energy[c]).sum();
        relative_error(left.max(0.0), energy)
    }

    /// The best rig near those without sizes in `rigs`, whose first `fixed` lights keep their directions.
    pub fn fitted(&self, given: &Given, rigs: &[Rig], fixed: usize, max_steps: usize) -> Sized {
        let shadows = Shadows::new(self.other.as_ref().unwrap_or(&self.shadows), given);
        let descent = Descent { objective: &shadows, fixed, max_steps };
        let starts = rigs.par_iter().flat_map(|rig| start::starts(&shadows, self.map, rig, fixed));
        let rough: Vec<State> = starts.map(|state| descent.run(state, ROUGH).resumed()).collect();
        let steps: usize = rough.iter().map(|state| state.steps).sum();
        let Some(best) = rough.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost)) else {
            return Sized::points(Rig::default());
        };
        let steps = steps - best.steps;
        let state = descent.run(best, FINE);
        // Other ambient terms leave few local minima that an exchange escapes.
        let has_harmonics = given.free() > 0;
        let state = if has_harmonics { exchanged(&shadows, &descent, state, [ROUGH, FINE]) } else { state };
        let steps = steps + state.steps;
        let state = state.without_black(&shadows, fixed).unwrap_or(state);
        let tolerances = Some(uncertainty::tolerances(&descent, &state, state.cost));
        let stop = state.stop;
        let (rig, radii) = rig_of(given, &state, self.map);
        Sized { rig, radii, tolerances, steps, stop }
    }
}

/// The rig of a state.
///
/// A pixel is a mean over its square, and shows it as a square: what stands in the map is blurred, by twice the spread of
/// a pixel. The disc that is nearest to a blurred one is less spread than that. Under the cone of the kernel, which counts
/// the spatial frequency k with `k^-3`, it is spread by what was seen and 1.25 pixels more where that is wide, 1.34 where it
/// is a disc of two pixels in radius, 1.46 where it is one of one pixel.
fn rig_of(given: &Given, state: &State, map: &WorkingMap) -> (Rig, Vec<f64>) {
    /// In spreads of a pixel: that of small discs, of which pixels are a large part.
    const BLUR: f64 = 1.4;
    let ambient = given.ambient.coefficients();
    let rgb = |row: usize| {
        DVec3::from_array(given.like.map(|like| like.map_or(0.0, |channel| state.x[(row, channel)])))
    };
    let shares: Vec<f64> = state
        .moments
        .discs
        .iter()
        .map(|disc| (disc.share - BLUR * map.pixel_spread(disc.direction)).max(0.0))
        .collect();
    // A disc seen from the front gives less than its flux: what it gives does not depend on its size.
    let irradiance = |(light, disc): (usize, &Disc)| rgb(ambient + light) * (1.0 - disc.share);
    let rig = Rig {
        ambient: (0..ambient).map(rgb).collect(),
        directions: state.moments.discs.iter().map(|disc| disc.direction).collect(),
        irradiance: state.moments.discs.iter().enumerate().map(irradiance).collect(),
        has_floor: given.has_floor,
    };
    (rig, shares.iter().map(|share| 2.0 * share.sqrt().asin()).collect())
}
