//! Ambient and a few directional lights under which a white probe looks as it does under a map.
//!
//! [`under_map_by_count`] and [`to_samples`] are lists of these steps:
//!
//! | step                                              | file                       |
//! |---------------------------------------------------|----------------------------|
//! | options, and the tuned numbers                    | `options.rs`, `settings.rs` |
//! | ambient and lights                                | `rig.rs`, `ambient.rs`     |
//! | a light with a size, and the kernel that compares it with the map | `light_disc.rs`, `comparison.rs` |
//! | numbers with derivatives                          | `jet.rs`                   |
//! | the cost: products of lights and their derivatives | `objective.rs`            |
//! | - of points at every normal, in closed form       | `sphere/`                  |
//! | - of points at known normals                      | `samples/`                 |
//! | - of discs, with shadows                          | `discs/`                   |
//! | best radiances, none negative                     | `radiances.rs`, `nnls.rs`, `factors.rs` |
//! | a set of lights with its best radiances           | `state.rs`                 |
//! | the cost around it, to second order               | `variable_projection.rs`   |
//! | descent to a local minimum                        | `damped_newton.rs`         |
//! | predicted cost of a light at many directions      | `candidates.rs`, `moves.rs` |
//! | the best set of a number of lights                | `search.rs`, `multistart.rs` |
//! | the number of lights                              | `light_count.rs`           |
//! | errors and sizes of a set of lights               | `result.rs`, `relative_rms.rs` |
//! | direction tolerances and standard errors          | `uncertainty.rs`           |

mod ambient;
mod candidates;
mod comparison;
mod damped_newton;
mod discs;
mod factors;
mod jet;
mod light_count;
mod light_disc;
mod moves;
mod multistart;
mod nnls;
mod objective;
mod options;
mod problem;
mod radiances;
mod relative_rms;
mod result;
mod rig;
mod samples;
mod search;
mod settings;
mod sphere;
mod state;
mod uncertainty;
mod variable_projection;

pub use ambient::Ambient;
pub use comparison::Comparison;
pub use discs::{BAND_DEGREE, Bands, evaluate, kernel_spectra};
pub use objective::{Objective, PointObjective};
pub use options::FitOptions;
pub use problem::Problem;
pub use relative_rms::relative_rms;
pub use result::FitResult;
pub use rig::Rig;
pub use samples::{Judged, Probe, Samples};
pub use sphere::Sphere;
pub use state::StopReason;
pub use uncertainty::Uncertainty;

use rayon::prelude::*;

use self::discs::{ContinuedLights, Sizes, continued_descent};
use self::light_count::{Trial, search_path, search_paths};
use self::relative_rms::relative_error;
use self::result::Evaluator;
use self::sphere::evaluation_probe;
use self::state::State;
use super::expansion::Expansion;
use super::image::WorkingMap;
use crate::error::{Error, Result};

/// Least number of normals at which a rig is evaluated under a map.
const EVALUATION_NORMALS: usize = 5120;

/// The best rig for the probe under a map.
///
/// # Errors
///
/// [`Error::TooFewNormals`], [`Error::TooBright`].
pub fn under_map(map: &WorkingMap, options: &FitOptions) -> Result<FitResult> {
    if options.has_goal() {
        return to_error_goal(map, options);
    }
    Ok(under_map_by_count(map, options, &[options.lights])?.remove(0))
}

/// The best rig that reaches the errors of the options: they count sizes and shadows, and end the search.
fn to_error_goal(map: &WorkingMap, options: &FitOptions) -> Result<FitResult> {
    check_unknowns(options, EVALUATION_NORMALS)?;
    let expansion = Expansion::new(map);
    let sphere = || Sphere::of(map, &expansion, options.ambient, options.has_floor);
    let (sphere, (sizes, samples)) = rayon::join(sphere, || references(map, &expansion, options));
    let (samples, problem) = (samples?, Problem { objective: &sphere, options });
    let evaluator = Evaluator { samples: &samples, sizes: Some(sizes) };
    let path = search_path(&problem, &|state| evaluator.trial(&problem, state))?;
    let result = evaluator.best(&problem, path);
    Ok(FitResult { map_samples: Some(samples), ..result })
}

/// The best rig with at most each of these numbers of lights, without a goal.
///
/// Each is that of [`under_map`] for its number; `options.lights` is the largest of them.
///
/// # Errors
///
/// [`Error::TooFewNormals`], [`Error::TooBright`].
pub fn under_map_by_count(
    map: &WorkingMap,
    options: &FitOptions,
    counts: &[usize],
) -> Result<Vec<FitResult>> {
    check_unknowns(options, EVALUATION_NORMALS)?;
    let expansion = Expansion::new(map);
    // The closed form knows the errors of points: the search need not wait for the references.
    let search = || {
        let sphere = Sphere::of(map, &expansion, options.ambient, options.has_floor);
        point_paths(&sphere, options, counts).map(|paths| (sphere, paths))
    };
    let (found, (sizes, samples)) = rayon::join(search, || references(map, &expansion, options));
    let (samples, (sphere, paths)) = (samples?, found?);
    let problem = Problem { objective: &sphere, options };
    let evaluator = Evaluator { samples: &samples, sizes: Some(sizes) };
    let evaluate = |trial: Trial| Trial { others: trial.others, ..evaluator.trial(&problem, trial.state) };
    let result = |path: Vec<Trial>| {
        let result = evaluator.best(&problem, path.into_iter().map(evaluate).collect());
        FitResult { map_samples: Some(samples.clone()), ..result }
    };
    Ok(paths.into_par_iter().map(result).collect())
}

/// The map with shadows, and its irradiance at the normals of the error.
fn references<'a>(
    map: &'a WorkingMap,
    expansion: &Expansion,
    options: &FitOptions,
) -> (Sizes<'a>, Result<Samples>) {
    rayon::join(
        || Sizes::new(map, expansion, options),
        || evaluation_probe(map, expansion, EVALUATION_NORMALS),
    )
}

/// The best points on the way to each of these numbers of lights, by the errors that the objective knows.
fn point_paths(sphere: &Sphere, options: &FitOptions, counts: &[usize]) -> Result<Vec<Vec<Trial>>> {
    let energy = sphere.reference().energy;
    if !energy.is_finite() {
        return Err(Error::TooBright);
    }
    let trial = |state: State| {
        let error = relative_error(state.cost, energy);
        Trial { state, others: Vec::new(), error, shadow_error: 0.0, gloss_error: 0.0 }
    };
    search_paths(&Problem { objective: sphere, options }, counts, &trial)
}

/// `<E, E>` of the probe under a map, over all normals and channels, in closed form.
pub fn energy(map: &WorkingMap) -> f64 {
    Sphere::new(map, Ambient::Constant, false).reference().energy
}

/// The best rig for irradiance at known normals, which evaluate it as well.
///
/// # Errors
///
/// [`Error::TooFewNormals`] when there are fewer equations than unknowns.
pub fn to_samples(samples: Samples, options: &FitOptions) -> Result<FitResult> {
    check_unknowns(options, samples.normals.len())?;
    let probe = Probe::new(samples, options.ambient);
    let problem = Problem { objective: &probe, options };
    let evaluator = Evaluator { samples: &probe.samples, sizes: None };
    let path = search_path(&problem, &|state| evaluator.trial(&problem, state))?;
    let result = evaluator.best(&problem, path);
    let uncertainty = uncertainty::uncertainty(&probe, &result.rig, options.fixed);
    Ok(FitResult { uncertainty, ..result })
}

/// Least number of normals of the error of a continued rig: that of three real maps changes by 0.4 % of it against 5120 normals.
const CONTINUED_NORMALS: usize = 720;

/// A rig and its errors.
#[derive(Clone, Debug)]
pub struct ContinuedRig {
    /// Ambient and lights.
    pub lights: ContinuedLights,
    /// Error of the rig.
    pub probe_error: Judged,
    /// The irradiance under the map at the normals of the error.
    pub samples: Samples,
}

/// The rig of the minimum near the lights in `options.start`, which have these angular `radii`.
///
/// # Errors
///
/// [`Error::TooFewNormals`], [`Error::TooBright`].
pub fn continue_under_map(map: &WorkingMap, options: &FitOptions, radii: &[f64]) -> Result<ContinuedRig> {
    check_unknowns(options, CONTINUED_NORMALS)?;
    let expansion = Expansion::new(map);
    let descend = || continued_descent(map, &expansion, options, radii);
    let (lights, samples) = rayon::join(descend, || evaluation_probe(map, &expansion, CONTINUED_NORMALS));
    let samples = samples?;
    let probe_error = evaluate(&samples, &lights.rig, &lights.radii);
    Ok(ContinuedRig { lights, probe_error, samples })
}

/// Require three equations at each normal for the unknowns.
///
/// These are the coefficients of the ambient term and a radiance for each light in each channel, and its two angles.
fn check_unknowns(options: &FitOptions, seen: usize) -> Result<()> {
    let lights = options.lights;
    let wanted = (3 * options.ambient.coefficients() + 5 * lights).div_ceil(3).max(1);
    if seen < wanted {
        return Err(Error::TooFewNormals { seen, wanted, lights });
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::rig::irradiance;
    use super::*;
    use crate::kernels::sampling;
    use crate::kernels::sphere::direction;
    use glam::DVec3;
    use ndarray::s;

    fn options(lights: usize, ambient: Ambient) -> FitOptions {
        FitOptions { ambient, lights, ..FitOptions::default() }
    }

    fn fit(rig: &Rig, lights: usize) -> FitResult {
        let (normals, weights) = sampling::icosphere(320).unwrap();
        let seen = irradiance(rig, normals.view()).unwrap();
        let samples = Samples::new(normals.view(), weights.view(), seen.view()).unwrap();
        to_samples(samples, &options(lights, Ambient::Constant)).unwrap()
    }

    #[test]
    fn three_lights_and_ambient_come_back() {
        let rig = Rig {
            ambient: vec![DVec3::new(0.2, 0.1, 0.3)],
            directions: vec![direction(0.4, 1.0), direction(1.3, 3.5), direction(2.5, 5.0)],
            irradiance: vec![DVec3::new(3.0, 2.5, 2.0), DVec3::new(0.5, 1.0, 1.5), DVec3::splat(0.7)],
            has_floor: false,
        };
        let found = fit(&rig, 3).rig;
        for (wanted, irradiance) in rig.directions.iter().zip(&rig.irradiance) {
            let nearest = found.directions.iter().zip(&found.irradiance);
            let (l, e) =
                nearest.min_by(|a, b| (a.0 - wanted).length().total_cmp(&(b.0 - wanted).length())).unwrap();
            assert!((l - wanted).length() < 1e-9, "{l} {wanted}");
            assert!((e - irradiance).length() < 1e-8, "{e} {irradiance}");
        }
        assert!((found.ambient[0] - rig.ambient[0]).length() < 1e-9);
    }

    #[test]
    fn there_must_be_as_many_equations_as_unknowns() {
        let (normals, weights) = sampling::icosphere(320).unwrap();
        let enough = |ambient, count: usize, lights| {
            let normals = normals.slice(s![..count, ..]);
            let samples = Samples::new(normals, weights.slice(s![..count]), normals).unwrap();
            check_unknowns(&options(lights, ambient), samples.normals.len()).is_ok()
        };
        for (ambient, unknowns) in [(Ambient::None, 0), (Ambient::Constant, 3), (Ambient::Sh2, 27)] {
            for lights in 0..4 {
                let least = (1..20).find(|&count| enough(ambient, count, lights)).unwrap();
                assert!(3 * least >= unknowns + 5 * lights && least >= 1);
                assert!(least == 1 || 3 * (least - 1) < unknowns + 5 * lights);
            }
        }
    }

    #[test]
    fn black_needs_no_light() {
        let found = fit(&Rig::default(), 4);
        assert_eq!(found.errors.len(), 1);
        assert_eq!(found.rig.ambient, [DVec3::ZERO]);
        assert!(found.rig.directions.is_empty());
    }
}
