//! Ambient and a few directional lights under which a white probe looks as it does under a map.
//!
//! [`under_map`] and [`to_samples`] are lists of these steps:
//!
//! | step                                              | file                       |
//! |---------------------------------------------------|----------------------------|
//! | options, and the tuned numbers                    | `options.rs`, `settings.rs` |
//! | ambient and lights                                | `rig.rs`, `ambient.rs`     |
//! | a light with a size, and the kernel that compares it with the map | `light_disc.rs`, `comparison.rs` |
//! | the map as bright parts and harmonics             | `picture.rs`               |
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
mod picture;
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
pub use discs::{BAND_DEGREE, Bands, bands, kernel_spectra};
pub use objective::{Objective, PointObjective};
pub use options::FitOptions;
pub use picture::Picture;
pub use problem::Problem;
pub use relative_rms::relative_rms;
pub use result::{Clock, FitResult};
pub use rig::Rig;
pub use samples::{Probe, ProbeError, Samples};
pub use sphere::Sphere;
pub use state::StopReason;
pub use uncertainty::Uncertainty;

use rayon::prelude::*;

use self::discs::{ContinuedLights, Sizes, continued_descent};
use self::light_count::search_paths;
use self::result::Evaluator;
use self::sphere::evaluation_probe;
use super::image::WorkingMap;
use crate::error::{Error, Result};

/// Least number of normals at which a rig is evaluated under a map.
const EVALUATION_NORMALS: usize = 5120;

/// The best rig for the probe under a map, with at most each of these numbers of lights.
///
/// Each is that of a fit with its number alone; `options.lights` is the largest of them. If the options have a goal, its
/// errors count sizes and shadows, and end the search.
///
/// # Errors
///
/// [`Error::TooFewNormals`], [`Error::TooBright`].
pub fn under_map(
    map: &WorkingMap,
    picture: &Picture,
    options: &FitOptions,
    counts: &[usize],
    mut clock: Clock,
) -> Result<Vec<FitResult>> {
    check_unknowns(options, EVALUATION_NORMALS)?;
    let sphere = || Sphere::of(map, picture, options.ambient, options.has_floor);
    let (sphere, sizes) = rayon::join(sphere, || Sizes::new(map, picture, options));
    if !sphere.reference().energy.is_finite() {
        return Err(Error::TooBright);
    }
    clock.lap("expand");
    let (problem, evaluator) = (Problem { objective: &sphere, options }, Evaluator::Map(Box::new(sizes)));
    let paths = search_paths(&problem, counts, &|state| evaluator.trial(&problem, state))?;
    clock.lap("search");
    Ok(paths.par_iter().map(|path| evaluator.best(&problem, path, clock.clone())).collect())
}

/// The irradiance under a map at many normals, and the errors of a rig there: they include the largest one.
///
/// # Errors
///
/// [`Error::TooBright`].
pub fn at_normals(
    map: &WorkingMap,
    picture: &Picture,
    rig: &Rig,
    radii: &[f64],
) -> Result<(Samples, ProbeError)> {
    let samples = evaluation_probe(map, picture, EVALUATION_NORMALS)?;
    let error = samples.evaluate(rig, radii);
    Ok((samples, error))
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
    let evaluator = Evaluator::Samples(&probe.samples);
    let (mut clock, counts) = (Clock::start(), [options.lights]);
    let path = search_paths(&problem, &counts, &|state| evaluator.trial(&problem, state))?.remove(0);
    clock.lap("search");
    let result = evaluator.best(&problem, &path, clock);
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
    pub probe_error: ProbeError,
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
    let picture = Picture::new(map);
    let descend = || continued_descent(map, &picture, options, radii);
    let (lights, samples) = rayon::join(descend, || evaluation_probe(map, &picture, CONTINUED_NORMALS));
    let samples = samples?;
    let probe_error = samples.evaluate(&lights.rig, &lights.radii);
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
