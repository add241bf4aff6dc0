//! Lights with a size: discs of uniform radiance, fitted so that the rig is right where things stand in the way.
//!
//! The error is `<D, D>` of the difference D of two distributions of radiance, under the map and under the rig, with a
//! kernel that sees shadows (`zonal.rs`). [`Sizes::fit`] starts from lights without a size:
//!
//! | step                                                  | file            |
//! |-------------------------------------------------------|-----------------|
//! | kernels, and discs, in Legendre polynomials           | `zonal.rs`      |
//! | the cone of the kernel, between two discs             | `chord.rs`      |
//! | - for discs that are far apart                        | `far.rs`        |
//! | bright cells of the map and their cones               | `patches.rs`    |
//! | degrees above the harmonics, for errors               | `high_degrees.rs` |
//! | inner products of discs, the map and the ambient term | `target.rs`     |
//! | radii to start from                                   | `start.rs`      |
//! | cost of discs under a map, under any of the kernels   | `disc_cost.rs`  |
//! | other lights, one at a time                           | `forward_selection.rs` |
//! | escape from a local minimum                           | `exchange.rs`   |
//! | energy of the difference in each degree               | `bands.rs`      |

mod bands;
mod chord;
mod disc_cost;
mod exchange;
mod far;
mod forward_selection;
mod high_degrees;
mod patches;
mod start;
pub mod target;
mod zonal;

pub use bands::{BAND_DEGREE, Bands};
pub use zonal::kernel_spectra;

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use self::bands::MapBands;
pub use self::disc_cost::Shadows;
use self::exchange::exchange;
use self::forward_selection::forward_selection;
use self::high_degrees::HighDegrees;
use self::target::Target;
use super::comparison::Comparison;
use super::damped_newton::Descent;
use super::light_disc::{Disc, of_flux};
use super::objective::{Objective, Reference};
use super::options::FitOptions;
use super::picture::Picture;
use super::rig::Rig;
use super::samples::ProbeError;
use super::settings::DISCS;
use super::state::{State, StopReason};
use super::uncertainty;
use crate::kernels::image::WorkingMap;

/// A rig whose lights have angular radii.
#[derive(Clone, Debug)]
pub struct Sized {
    pub rig: Rig,
    pub radii: Vec<f64>,
    /// Lights whose radius is at the bound of all radii.
    pub at_bound: Vec<usize>,
    /// Direction tolerances in radians; absent for points.
    pub tolerances: Option<Vec<f64>>,
    pub steps: usize,
    /// Reason for the end of the descent, if there was one.
    pub stop: Option<StopReason>,
}

impl Sized {
    /// Lights without a size.
    pub fn points(rig: Rig) -> Self {
        let radii = vec![0.0; rig.directions.len()];
        Self { radii, rig, at_bound: Vec::new(), tolerances: None, steps: 0, stop: None }
    }
}

/// A map, ready to be compared with lights that have sizes.
#[derive(Clone, Debug)]
pub struct Sizes<'a> {
    map: &'a WorkingMap,
    /// The map under each kernel.
    targets: [Target; 3],
    /// Energies of the map, if a fit to an error of shiny objects needs them.
    bands: Option<MapBands>,
    /// The greatest radius of a light, in radians.
    greatest_radius: f64,
}

impl<'a> Sizes<'a> {
    /// For a map and its picture.
    pub fn new(map: &'a WorkingMap, picture: &Picture, options: &FitOptions) -> Self {
        let target = |comparison| Target::new(picture, comparison, options.ambient, options.has_floor);
        Self {
            map,
            targets: [Comparison::Probe, Comparison::Shadows, Comparison::Mixed].map(target),
            bands: options.gloss_error.map(|_| MapBands::new(picture)),
            greatest_radius: options.max_radius.unwrap_or(DISCS.greatest),
        }
    }

    /// Errors under a kernel, of a rig whose lights have these radii. A pixel of the map is the square that it is.
    pub fn errors(
        &self,
        comparison: Comparison,
        reference: &Reference,
        rig: &Rig,
        radii: &[f64],
    ) -> ProbeError {
        errors_under(&self.targets[comparison as usize], reference, rig, radii)
    }

    /// Error of a shiny object whose kernel has these factors, if the options ask for it.
    pub fn gloss_error(&self, rig: &Rig, radii: &[f64], factors: &[f64]) -> f64 {
        let compare = |bands: &MapBands| bands.compare(rig, &discs_of(rig, radii)).error(factors);
        self.bands.as_ref().map_or(0.0, compare)
    }

    /// The best rig under a kernel near those without sizes in `rigs`, whose first `fixed` lights keep their directions.
    ///
    /// If `can_select`, the lights may also come from a forward selection of discs.
    pub fn fit(
        &self,
        comparison: Comparison,
        reference: &Reference,
        rigs: &[Rig],
        fixed: usize,
        max_steps: usize,
        can_select: bool,
    ) -> Sized {
        let target = &self.targets[comparison as usize];
        let shadows = Shadows::new(target, reference).up_to(self.greatest_radius);
        let descent = Descent { objective: &shadows, fixed, max_steps };
        let selected = || {
            let first = rigs.first().filter(|rig| can_select && rig.directions.len() >= DISCS.fewest)?;
            let (fixed, count) = (&first.directions[..fixed], first.directions.len());
            forward_selection(&shadows, &descent, fixed, count)
        };
        let (near, selected) = rayon::join(|| near(&shadows, &descent, self.map, rigs), selected);
        let Some(near) = near else { return Sized::points(Rig::default()) };
        let steps = near.steps + selected.as_ref().map_or(0, |state| state.steps);
        let state = selected.filter(|state| state.cost < near.cost).unwrap_or(near);
        let state = State { steps, ..state };
        self.polish(reference, &shadows, &descent, state)
    }

    /// The rig of the last digits of a minimum.
    fn polish(
        &self,
        reference: &Reference,
        shadows: &Shadows<'_>,
        descent: &Descent<'_>,
        state: State,
    ) -> Sized {
        let state = descent.polish(state.without_black(shadows, descent.fixed).unwrap_or(state));
        let tolerances = Some(uncertainty::tolerances(descent, &state, state.cost));
        let (steps, stop) = (state.steps, state.stop);
        let discs = &state.moments.discs;
        let at_bound = (0..discs.len()).filter(|&light| shadows.is_at_bound(&discs[light])).collect();
        let (rig, radii) = rig_of(reference, &state, self.map);
        // The least radius of a descent may be above the greatest one of the options.
        let radii = radii.iter().map(|radius| radius.min(self.greatest_radius)).collect();
        Sized { rig, radii, at_bound, tolerances, steps, stop }
    }
}

/// The lowest minimum of discs near `rigs` without sizes, with the steps that led to it.
fn near(shadows: &Shadows<'_>, descent: &Descent<'_>, map: &WorkingMap, rigs: &[Rig]) -> Option<State> {
    let starts = rigs.par_iter().flat_map(|rig| start::starts(shadows, map, rig, descent.fixed));
    let rough: Vec<State> = starts.map(|state| descent.run(state, DISCS.rough).resume()).collect();
    let steps: usize = rough.iter().map(|state| state.steps).sum();
    let best = rough.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost))?;
    let steps = steps - best.steps;
    let state = descent.run(best, DISCS.fine);
    // Other ambient terms leave few local minima that an exchange escapes.
    let has_harmonics = shadows.reference().free() > 0;
    let state = if has_harmonics { exchange(shadows, descent, state) } else { state };
    Some(State { steps: steps + state.steps, ..state })
}

/// Energies of a map and of its difference from a rig whose lights have these radii.
pub fn bands(picture: &Picture, rig: &Rig, radii: &[f64]) -> Bands {
    MapBands::new(picture).compare(rig, &discs_of(rig, radii))
}

/// Lights with angular radii, and the relative RMS error that they minimise.
#[derive(Clone, Debug)]
pub struct ContinuedLights {
    /// Ambient and lights.
    pub rig: Rig,
    /// Angular radius of each light, in radians.
    pub radii: Vec<f64>,
    /// Relative RMS error that the lights minimise.
    pub objective_error: f64,
}

/// The minimum near the lights in `options.start`, which have these angular `radii`.
///
/// Lights that are black there are left out.
pub fn continued_descent(
    map: &WorkingMap,
    picture: &Picture,
    options: &FitOptions,
    radii: &[f64],
) -> ContinuedLights {
    let comparison = options.sizes.unwrap_or(Comparison::Shadows);
    let target = Target::new(picture, comparison, options.ambient, options.has_floor);
    let reference = picture.reference(options.ambient, options.has_floor);
    let shadows = Shadows::new(&target, &reference).up_to(options.max_radius.unwrap_or(DISCS.greatest));
    let descent = Descent { objective: &shadows, fixed: options.fixed, max_steps: options.max_steps };
    // A map shows discs wider than they are; `rig_of` takes that off.
    let drawn = |(&direction, radius): (&DVec3, &f64)| {
        let share = (0.5 * radius).sin().powi(2) + DISCS.blur * map.pixel_spread(direction);
        shadows.disc(direction, (2.0 * share.min(1.0).sqrt().asin()).max(DISCS.least))
    };
    let state = shadows.state(options.start.iter().zip(radii).map(drawn).collect());
    let state = descent.run(state, DISCS.fine);
    let state = state.without_black(&shadows, options.fixed).unwrap_or(state);
    let (rig, radii) = rig_of(&reference, &state, map);
    let radii: Vec<f64> =
        radii.iter().map(|radius| radius.min(options.max_radius.unwrap_or(*radius))).collect();
    let objective_error = errors_under(&target, &reference, &rig, &radii).error;
    ContinuedLights { rig, radii, objective_error }
}

/// Errors of a rig, whose lights have these radii, under the kernel of a `target`.
fn errors_under(target: &Target, reference: &Reference, rig: &Rig, radii: &[f64]) -> ProbeError {
    let discs = discs_of(rig, radii);
    let lights = of_flux(&discs, &rig.irradiance);
    let (gram, rhs) = target.products(&discs);
    let flux = lights.iter().map(|&(_, _, flux)| DVec3::from_array(flux));
    let x: Vec<DVec3> = rig.ambient.iter().copied().chain(flux).collect();
    let x = DMatrix::from_fn(x.len(), 3, |i, c| x[i][c]);
    let used = &gram * &x;
    let explained = |c: usize| 2.0 * rhs.column(c).dot(&x.column(c)) - used.column(c).dot(&x.column(c));
    let (mut left, mut whole) = (DVec3::ZERO, DVec3::ZERO);
    for c in (0..3).filter(|&c| reference.like[c].is_some()) {
        (left[c], whole[c]) = (target.energy[c] - explained(c), target.energy[c]);
    }
    if let Some(bright) = &target.high_degrees {
        left += bright.difference(&HighDegrees::new(lights.into_iter()));
        whole += bright.energy;
    }
    ProbeError::of(left.max(DVec3::ZERO), whole)
}

/// The lights of a rig as discs.
fn discs_of(rig: &Rig, radii: &[f64]) -> Vec<Disc> {
    let lights = rig.directions.iter().zip(radii);
    lights.map(|(&direction, radius)| Disc::new(direction, radius.max(DISCS.least))).collect()
}

/// The rig of a state.
///
/// A pixel is the mean over its square and is drawn as a square, so a map blurs its lights by twice the spread of a pixel.
/// Under the cone of the kernel, which weights the spatial frequency k by `k^-3`, the disc nearest to a blurred one is wider
/// than the original by 1.25 spreads of a pixel if that is wide, 1.34 for a radius of two pixels and 1.46 for one pixel.
fn rig_of(reference: &Reference, state: &State, map: &WorkingMap) -> (Rig, Vec<f64>) {
    let mut rig = state.rig(reference);
    let mut radii = Vec::with_capacity(rig.irradiance.len());
    for (irradiance, disc) in rig.irradiance.iter_mut().zip(&state.moments.discs) {
        // The irradiance at normal incidence is less than the flux by the factor 1 - A.
        *irradiance *= 1.0 - disc.share;
        let share = (disc.share - DISCS.blur * map.pixel_spread(disc.direction)).max(0.0);
        radii.push(2.0 * share.sqrt().asin());
    }
    (rig, radii)
}
