//! Ambient + M directional lights that make a white probe look as it does under the map.
//!
//! [`fit`] is the whole story; each line of it is a room of its own:
//!
//! | step                                        | file         |
//! |---------------------------------------------|--------------|
//! | lights -> probe, and all sums over normals  | `model.rs`   |
//! | best radiances, none negative               | `nnls.rs`    |
//! | best directions near given ones             | `solver.rs`  |
//! | where the next light starts                 | `start.rs`   |

pub mod model;
mod nnls;
mod solver;
mod start;

use glam::DVec3;
use ndarray::{Array2, ArrayView1, ArrayView2, Axis, Zip};
use rayon::prelude::*;

use super::sphere::{check_rows, unit_vectors};
use crate::error::{Error, Result};

/// Probe values to be reproduced: normals with weights, and the irradiance at each.
#[derive(Clone, Debug)]
pub struct Probe {
    normals: Vec<DVec3>,
    weights: Vec<f64>,
    irradiance: Vec<DVec3>,
    /// `w n n^T` of each normal: its diagonal, and its entries xy, yz, zx.
    outer: Vec<[DVec3; 2]>,
    /// Weighted sum of squares of the irradiance: the cost of no light at all.
    energy: f64,
    /// Whether the model has an ambient term.
    has_ambient: bool,
}

impl Probe {
    /// Check and pair up what was measured.
    ///
    /// # Inputs
    ///
    /// - `normals`: (n, 3) unit vectors; `weights`: (n,), not negative.
    /// - `irradiance`: (n, 3) RGB, finite.
    /// - `has_ambient`: whether the model may explain it by a constant environment as well.
    ///
    /// # Errors
    ///
    /// [`Error::WrongColumns`], [`Error::LengthMismatch`], [`Error::NotFinite`], [`Error::NotUnit`],
    /// [`Error::Negative`].
    pub fn new(
        normals: ArrayView2<'_, f64>,
        weights: ArrayView1<'_, f64>,
        irradiance: ArrayView2<'_, f64>,
        has_ambient: bool,
    ) -> Result<Self> {
        let normals = unit_vectors("normal", normals)?;
        check_rows("irradiance", irradiance, 3)?;
        check_rows("weights", weights.insert_axis(Axis(1)), 1)?;
        for (what, seen) in [("irradiance", irradiance.nrows()), ("weights", weights.len())] {
            let wanted = normals.len();
            if seen != wanted {
                return Err(Error::LengthMismatch { what, other: "normals", wanted, seen });
            }
        }
        if let Some((index, &value)) = weights.iter().enumerate().find(|(_, value)| **value < 0.0) {
            return Err(Error::Negative { what: "weights", index, value });
        }
        let irradiance: Vec<DVec3> =
            irradiance.rows().into_iter().map(|row| DVec3::new(row[0], row[1], row[2])).collect();
        let energy = irradiance.iter().zip(weights).map(|(e, w)| w * e.length_squared()).sum();
        let outer =
            normals.iter().zip(weights).map(|(&n, &w)| [n * n * w, n * DVec3::new(n.y, n.z, n.x) * w]);
        let (outer, weights) = (outer.collect(), weights.to_vec());
        Ok(Self { normals, weights, irradiance, outer, energy, has_ambient })
    }

    /// The columns of the model with `lights` lights, without their derivatives.
    fn columns(&self, lights: usize) -> Vec<usize> {
        self.has_ambient.then_some(0).into_iter().chain((0..lights).map(model::column)).collect()
    }
}

/// Ambient and directional lights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rig {
    /// Radiance of the constant environment, RGB.
    pub ambient: DVec3,
    /// Towards each light.
    pub directions: Vec<DVec3>,
    /// Irradiance of each light at normal incidence, RGB.
    pub irradiance: Vec<DVec3>,
}

/// Why the solver stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The error stopped falling.
    Converged,
    /// Nothing is left to explain.
    Exact,
    /// The step limit came first.
    OutOfSteps,
}

/// The best rig found with one number of lights.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The lights.
    pub rig: Rig,
    /// Weighted relative RMS error on the probe values that were fitted.
    pub residual: f64,
    /// Steps of the solver, all starts together.
    pub steps: usize,
    /// Why it took no more.
    pub stop: StopReason,
}

/// An error that is good enough, on probe values that are not fitted.
#[derive(Clone, Debug)]
pub struct Goal {
    /// The values that judge.
    pub judge: Probe,
    /// Relative RMS error at which no more lights are added.
    pub error: f64,
}

impl Goal {
    fn is_reached(&self, solution: &Solution) -> bool {
        model::cost(&self.judge, &solution.rig) <= self.error * self.error * self.judge.energy
    }
}

/// The best rigs with 0, 1, ... `lights` lights; fewer where the probe is explained before, or `goal`
/// is reached.
///
/// The first lights start in the directions `start`, brightest first, and go downhill from there.
/// Those beyond start where each explains most of what is left.
///
/// # Errors
///
/// [`Error::TooFewNormals`] when there are fewer equations than the 3 + 5 M unknowns.
pub fn fit(
    probe: &Probe,
    start: &[DVec3],
    lights: usize,
    max_steps: usize,
    goal: Option<&Goal>,
) -> Result<Vec<Solution>> {
    check_unknowns(probe, lights)?;
    let is_enough =
        |last: &Solution| last.stop == StopReason::Exact || goal.is_some_and(|goal| goal.is_reached(last));
    let mut solutions = vec![solver::ambient_only(probe)];
    // Made once, and only for lights that have no start.
    let mut search = None;
    while solutions.len() <= lights && !is_enough(&solutions[solutions.len() - 1]) {
        let count = solutions.len();
        let next = if count <= start.len() {
            Some(solver::refine(probe, &start[..count], max_steps, FINE))
        } else {
            search.get_or_insert_with(|| Search::new(probe, max_steps)).with_one_more(&solutions[count - 1])
        };
        let Some(next) = next else { break };
        solutions.push(next);
    }
    Ok(solutions)
}

/// Relative fall of the cost in one step at which a try has shown what it is worth.
const ROUGH: f64 = 1e-2;
/// Relative fall of the cost in one step at which an answer is final.
const FINE: f64 = 1e-9;

/// The search for the best set of lights, among the many that no small step improves.
struct Search<'a> {
    probe: &'a Probe,
    starts: start::Starts,
    max_steps: usize,
}

impl<'a> Search<'a> {
    fn new(probe: &'a Probe, max_steps: usize) -> Self {
        Self { probe, starts: start::Starts::new(probe), max_steps }
    }

    /// `last` with one more light, where that light helps.
    fn with_one_more(&self, last: &Solution) -> Option<Solution> {
        let added = self.best_start(&last.rig)?;
        let split = self.best_of(start::splits(&last.rig.directions));
        let grown = split.filter(|split| split.residual < added.residual).unwrap_or(added);
        let best = self.exchange(grown);
        let polished = solver::refine(self.probe, &best.rig.directions, self.max_steps, FINE);
        (polished.residual < last.residual)
            .then(|| Solution { steps: best.steps + polished.steps, ..polished })
    }

    /// The best of the rigs that one more light beside `rig` leads to.
    fn best_start(&self, rig: &Rig) -> Option<Solution> {
        let candidates = self.starts.candidates(self.probe, rig);
        self.best_of(candidates.into_iter().map(|light| start::with(&rig.directions, light)).collect())
    }

    /// The best of the rigs that refining each of `starts` leads to.
    ///
    /// They run side by side; the first of equals wins, whichever comes home first.
    fn best_of(&self, starts: Vec<Vec<DVec3>>) -> Option<Solution> {
        let refine = |directions: Vec<DVec3>| solver::refine(self.probe, &directions, self.max_steps, ROUGH);
        let refined: Vec<Solution> = starts.into_par_iter().map(refine).collect();
        refined.into_iter().min_by(|a, b| a.residual.total_cmp(&b.residual))
    }

    /// Take out each light in turn and let it start anew where it helps most, while that pays.
    ///
    /// A greedy start keeps the light that explained most *alone*; with its neighbours in place a
    /// different set is often better. This finds most of what many random starts would.
    fn exchange(&self, mut best: Solution) -> Solution {
        const WORTHWHILE: f64 = 1e-3;
        let (mut light, mut unchanged) = (0, 0);
        while unchanged < best.rig.directions.len() && best.rig.directions.len() > 1 {
            light = (light + 1) % best.rig.directions.len();
            let others = start::without(&best.rig.directions, light);
            let Some(moved) = self.best_start(&solver::radiances(self.probe, &others)) else { break };
            let steps = best.steps + moved.steps;
            if moved.residual < best.residual * (1.0 - WORTHWHILE) {
                (best, unchanged) = (moved, 0);
            } else {
                unchanged += 1;
            }
            best.steps = steps;
        }
        best
    }
}

fn check_unknowns(probe: &Probe, lights: usize) -> Result<()> {
    let wanted = (3 + 5 * lights).div_ceil(3);
    let seen = probe.normals.len();
    if seen < wanted {
        return Err(Error::TooFewNormals { seen, wanted, lights });
    }
    Ok(())
}

/// Weighted relative RMS difference of two probes, (n, 3) each.
///
/// # Errors
///
/// [`Error::LengthMismatch`] when they differ in length.
pub fn relative_rms(
    seen: ArrayView2<'_, f64>,
    wanted: ArrayView2<'_, f64>,
    weights: ArrayView1<'_, f64>,
) -> Result<f64> {
    if seen.dim() != wanted.dim() || seen.nrows() != weights.len() {
        let (wanted, seen) = (wanted.nrows(), seen.nrows());
        return Err(Error::LengthMismatch { what: "probe", other: "reference", wanted, seen });
    }
    let (mut difference, mut reference) = (0.0, 0.0);
    Zip::from(seen.rows()).and(wanted.rows()).and(weights).for_each(|seen, wanted, &weight| {
        for (a, b) in seen.iter().zip(wanted) {
            difference += weight * (a - b) * (a - b);
            reference += weight * b * b;
        }
    });
    Ok(if reference > 0.0 { (difference / reference).sqrt() } else { difference.sqrt() })
}

/// Irradiance of `rig` at `normals`, (n, 3).
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NotUnit`].
pub fn irradiance(rig: &Rig, normals: ArrayView2<'_, f64>) -> Result<Array2<f64>> {
    let normals = unit_vectors("normal", normals)?;
    Ok(super::sphere::from_vectors(normals.iter().map(|&normal| model::irradiance(rig, normal))))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::sampling;
    use crate::kernels::sphere::direction;

    fn probe_of(rig: &Rig) -> Probe {
        let (normals, weights) = sampling::icosphere(320).unwrap();
        let seen = irradiance(rig, normals.view()).unwrap();
        Probe::new(normals.view(), weights.view(), seen.view(), true).unwrap()
    }

    #[test]
    fn three_lights_and_ambient_come_back() {
        let rig = Rig {
            ambient: DVec3::new(0.2, 0.1, 0.3),
            directions: vec![direction(0.4, 1.0), direction(1.3, 3.5), direction(2.5, 5.0)],
            irradiance: vec![DVec3::new(3.0, 2.5, 2.0), DVec3::new(0.5, 1.0, 1.5), DVec3::splat(0.7)],
        };
        let solutions = fit(&probe_of(&rig), &[], 3, 100, None).unwrap();
        let found = &solutions[3].rig;
        for (wanted, irradiance) in rig.directions.iter().zip(&rig.irradiance) {
            let nearest = found.directions.iter().zip(&found.irradiance);
            let (l, e) =
                nearest.min_by(|a, b| (a.0 - wanted).length().total_cmp(&(b.0 - wanted).length())).unwrap();
            assert!((l - wanted).length() < 1e-9, "{l} {wanted}");
            assert!((e - irradiance).length() < 1e-8, "{e} {irradiance}");
        }
        assert!((found.ambient - rig.ambient).length() < 1e-9);
    }

    #[test]
    fn black_needs_no_light() {
        let solutions = fit(&probe_of(&Rig::default()), &[], 4, 100, None).unwrap();
        assert_eq!(solutions.len(), 1);
        assert_eq!(solutions[0].rig, Rig::default());
    }
}
