//! Lights that continue known ones: one descent from their directions and radii, without a search for others.

use super::shadows::LEAST_RADIUS;
use super::target::{Picture, Target};
use super::{BLUR, Comparison, Descent, FINE, FitOptions, Shadows, WorkingMap, error_under, rig_of};
use crate::kernels::expansion::Expansion;
use crate::kernels::fit::rig::Rig;

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
    expansion: &Expansion,
    options: &FitOptions,
    radii: &[f64],
) -> ContinuedLights {
    let picture = Picture::new(map, expansion);
    let comparison = options.sizes.unwrap_or(Comparison::Shadows);
    let target = Target::new(&picture, comparison, options.ambient, options.has_floor);
    let reference = picture.reference(options.ambient, options.has_floor);
    let shadows =
        Shadows::new(&target, &reference).up_to(options.max_radius.unwrap_or(super::GREATEST_RADIUS));
    let descent = Descent { objective: &shadows, fixed: options.fixed, max_steps: options.max_steps };
    // A map shows discs wider than they are; `rig_of` takes that off.
    let drawn = |(&direction, radius): (&glam::DVec3, &f64)| {
        let share = (0.5 * radius).sin().powi(2) + BLUR * map.pixel_spread(direction);
        shadows.disc(direction, (2.0 * share.min(1.0).sqrt().asin()).max(LEAST_RADIUS))
    };
    let state = shadows.state(options.start.iter().zip(radii).map(drawn).collect());
    let state = descent.run(state, FINE);
    let state = state.without_black(&shadows, options.fixed).unwrap_or(state);
    let (rig, radii) = rig_of(&reference, &state, map);
    let radii: Vec<f64> =
        radii.iter().map(|radius| radius.min(options.max_radius.unwrap_or(*radius))).collect();
    let objective_error = error_under(&target, &reference, &rig, &radii);
    ContinuedLights { rig, radii, objective_error }
}
