//! What one more light would explain, from each of many directions at once.

use glam::DVec3;
use nalgebra::{DMatrix, DVector};

use super::nnls::Support;
use super::probe::Probe;
use super::radiances::{self, Radiances};
use super::solver::{State, cost};
use crate::kernels::sampling;
use crate::kernels::sphere::to_vectors;

/// Directions that are tried: faces of an icosphere, about 20 degrees apart.
const TRIED: usize = 80;
/// A column this close to the span of the others, in squared length, brings nothing new.
const DEPENDENT: f64 = 1e-6;

/// The columns that lights from every direction would add to the model, made once for a fit.
#[derive(Debug)]
pub struct Candidates {
    directions: Vec<DVec3>,
    /// `w max(0, n.l)`: a row for each direction, a column for each normal.
    weighted: DMatrix<f64>,
    /// `sum w max(0, n.l) y`: a row for each direction, a column for each side y of the probe.
    sides: DMatrix<f64>,
    /// `sum w max(0, n.l)^2` of each direction.
    square: DVector<f64>,
}

impl Candidates {
    /// The columns over the normals of `probe`.
    pub fn new(probe: &Probe) -> Self {
        let (centroids, _) = sampling::icosphere(TRIED).expect("a number of faces that exists");
        let directions = to_vectors(centroids.view());
        let mut weighted = DMatrix::zeros(TRIED, probe.samples.normals.len());
        let mut square = DVector::zeros(TRIED);
        let normals = probe.samples.normals.iter().zip(&probe.samples.weights);
        for (column, (normal, weight)) in weighted.as_mut_slice().chunks_exact_mut(TRIED).zip(normals) {
            for ((value, square), direction) in column.iter_mut().zip(square.as_mut_slice()).zip(&directions)
            {
                let lit = normal.dot(*direction).max(0.0);
                *value = weight * lit;
                *square += weight * lit * lit;
            }
        }
        let sides = &weighted * probe.side_columns();
        Self { directions, weighted, sides, square }
    }

    /// Inner products of every direction's column with the columns of the model of `state`.
    pub fn products(&self, probe: &Probe, state: &State) -> DMatrix<f64> {
        let ambient = probe.ambient.coefficients();
        let mut products = self.sides.columns(0, ambient).resize_horizontally(state.x.nrows(), 0.0);
        let lit = columns(probe, &state.moments.directions);
        for (mut products, lit) in
            products.columns_range_mut(ambient..).column_iter_mut().zip(lit.column_iter())
        {
            // Half of the normals do not see the light.
            for (weighted, &lit) in self.weighted.column_iter().zip(&lit).filter(|(_, lit)| **lit > 0.0) {
                products.axpy(lit, &weighted, 1.0);
            }
        }
        products
    }

    /// The cost that one more light from each direction would leave, where it would lower it.
    ///
    /// With the residuals `r_c` of the lights of `state`, but for `without`, a light with the column
    /// a leaves at least
    ///
    /// ```text
    ///   sum over channels of |r_c|^2 - max(0, a.r_c)^2 / |a - P a|^2
    /// ```
    ///
    /// where P projects on the columns that are in already.
    pub fn left(
        &self,
        probe: &Probe,
        state: &State,
        products: &DMatrix<f64>,
        without: Option<usize>,
    ) -> Vec<(f64, DVec3)> {
        let ambient = probe.ambient.coefficients();
        let gone = without.map(|light| ambient + light);
        let kept: Vec<usize> = (0..state.x.nrows()).filter(|&column| Some(column) != gone).collect();
        let (gram, right) = (&state.moments.gram, state.moments.right.select_rows(&kept));
        let gram = DMatrix::from_fn(kept.len(), kept.len(), |i, j| gram[(kept[i], kept[j])]);
        let products = products.select_columns(&kept);
        let Radiances { x, .. } = radiances::solve(probe, &gram, &right, &[]);
        let before = cost(probe, &gram, &right, &x);
        let residual = self.sides.columns_range(ambient..) - &products * x;
        let outside = self.outside(&gram, products);
        let after = |i: usize| {
            let along = |c: usize| probe.copies(c) * residual[(i, c)].max(0.0).powi(2);
            before - (0..residual.ncols()).map(along).sum::<f64>() / outside[i]
        };
        (0..TRIED)
            .filter(|&i| outside[i] > DEPENDENT * self.square[i])
            .map(|i| (after(i), self.directions[i]))
            .filter(|&(after, _)| after < before)
            .collect()
    }

    /// `|a - P a|^2` of every direction: what its column adds to those with this Gram matrix.
    fn outside(&self, gram: &DMatrix<f64>, products: DMatrix<f64>) -> DVector<f64> {
        let mut outside = self.square.clone();
        if let Some(support) = Support::new(gram, (0..gram.nrows()).collect()) {
            for inside in support.orthonormal(products).column_iter() {
                outside.zip_apply(&inside, |outside, inside| *outside -= inside * inside);
            }
        }
        outside
    }
}

/// `max(0, n.l)`: a row for each normal, a column for each of `directions`.
fn columns(probe: &Probe, directions: &[DVec3]) -> DMatrix<f64> {
    DMatrix::from_fn(probe.samples.normals.len(), directions.len(), |i, j| {
        probe.samples.normals[i].dot(directions[j]).max(0.0)
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::{Ambient, Rig, Samples, irradiance};

    /// What is promised is what a light there leaves, and at best that: no radiance may be negative.
    #[test]
    fn the_promise_is_the_cost_with_that_light() {
        let (normals, weights) = sampling::icosphere(320).unwrap();
        let rig = Rig {
            ambient: vec![DVec3::splat(0.1)],
            directions: vec![DVec3::Y, DVec3::X, DVec3::NEG_Z],
            irradiance: vec![DVec3::new(3.0, 2.0, 1.0), DVec3::ONE, DVec3::new(0.5, 1.0, 2.0)],
        };
        let seen = irradiance(&rig, normals.view()).unwrap();
        let probe =
            Probe::new(Samples::new(normals.view(), weights.view(), seen.view()).unwrap(), Ambient::Constant);
        let state = State::new(&probe, &rig.directions[..2]);
        let candidates = Candidates::new(&probe);
        let left = candidates.left(&probe, &state, &candidates.products(&probe, &state), None);
        let mut exact = 0;
        for &(promised, direction) in &left {
            let with = State::new(&probe, &[DVec3::Y, DVec3::X, direction]);
            assert!(
                with.cost >= promised - 1e-9 * probe.samples.energy,
                "{direction}: {} {promised}",
                with.cost
            );
            exact += usize::from(with.cost <= promised + 1e-9 * probe.samples.energy);
        }
        assert!(exact > 10, "{exact} of {}", left.len());
    }
}
