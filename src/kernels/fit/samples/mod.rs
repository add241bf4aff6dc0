//! Known normals: the objective as sums over them.
//!
//! | step                                       | file               |
//! |--------------------------------------------|--------------------|
//! | irradiance at normals, errors of a rig     | `probe_samples.rs` |
//! | loops over all normals                     | `blocks.rs`        |
//! | inner products that lights do not change   | `probe.rs`         |
//! | sums over the normals that a light reaches | `visible.rs`       |
//! | inner products of lights                   | `pairs.rs`         |

mod blocks;
mod pairs;
mod probe;
mod probe_samples;
mod visible;

use glam::DVec3;
use nalgebra::DMatrix;

pub use self::probe::Probe;
pub use self::probe_samples::{ProbeError, Samples};
use super::objective::{
    Constraint, Derivatives, Directions, Moments, Objective, PointObjective, Reference, turn_by,
};
use super::rig::Rig;

impl Objective for Probe {
    fn reference(&self) -> &Reference {
        &self.reference
    }

    fn after_step(&self, before: &Moments, step: &[f64]) -> Moments {
        self.turn_to(before, turn_by(&before.directions, step))
    }

    fn subset(&self, before: &Moments, kept: &[usize]) -> Moments {
        self.exchange(before, kept, &[])
    }

    fn derivatives(&self, moments: &Moments, _: &DMatrix<f64>, _: bool) -> Derivatives {
        pairs::derivatives(&self.reference, moments)
    }

    fn kinks(&self, from: &Moments, to: &Moments) -> Vec<Constraint> {
        let crossings = visible::crossings(self, from, to).into_iter();
        crossings.map(|(light, normal)| Constraint::horizon(light, from.directions[light], normal)).collect()
    }

    fn exact_cost(&self, rig: &Rig) -> Option<f64> {
        Some(self.samples.cost(rig))
    }
}

impl PointObjective for Probe {
    fn exchange(&self, before: &Moments, kept: &[usize], new: &[DVec3]) -> Moments {
        visible::exchange(self, before, kept, new)
    }

    fn turn_to(&self, before: &Moments, directions: Vec<DVec3>) -> Moments {
        visible::turn(self, before, directions)
    }

    fn light_products(&self, at: &Directions, lights: &[DVec3]) -> DMatrix<f64> {
        let mut products = DMatrix::zeros(at.directions.len(), lights.len());
        for (light, mut products) in lights.iter().zip(products.column_iter_mut()) {
            // Skip the half of the normals that the light does not reach.
            for (weighted, normal) in at.weighted.column_iter().zip(&self.samples.normals) {
                let along = normal.dot(*light);
                if along > 0.0 {
                    products.axpy(along, &weighted, 1.0);
                }
            }
        }
        products
    }

    fn side_products(&self, at: &Directions) -> DMatrix<f64> {
        &at.weighted * self.side_columns()
    }

    fn squares(&self, at: &Directions) -> Vec<f64> {
        let square = |d: &DVec3| {
            let normals = self.samples.normals.iter().zip(&self.samples.weights);
            normals.map(|(n, w)| w * n.dot(*d).max(0.0).powi(2)).sum()
        };
        at.directions.iter().map(square).collect()
    }

    fn directions(&self, directions: Vec<DVec3>) -> Directions {
        let Samples { normals, weights, .. } = &self.samples;
        let weighted = DMatrix::from_fn(directions.len(), normals.len(), |i, n| {
            weights[n] * normals[n].dot(directions[i]).max(0.0)
        });
        Directions { directions, weighted }
    }

    fn has_kinks(&self) -> bool {
        /// Number of normals from which kinks are too close together for local minima between them.
        const SMOOTH: usize = 1280;
        self.samples.normals.len() < SMOOTH
    }
}
