//! What a fit minimises: the squared difference of two probes, known by inner products.
//!
//! Equations 4 to 6 of Madsen et al. 2003 in physical scale (the paper's `k_a` is pi, `k_d` and C are 1):
//!
//! ```text
//!   E(n) = sum_i c_i A_i(n) + sum_j E_j max(0, n.l_j)        A: pi, or harmonics (`ambient.rs`)
//! ```
//!
//! For fixed directions this is linear in `c_i` and `E_j`. With `<f, g>` the sum, or the integral, of f g
//! over normals, the columns of the lights and their derivatives along the tangents `s_j`, `t_j` are
//!
//! ```text
//!   a_j = v_j.l_j      da_j = v_j.s_j, v_j.t_j      v_j(n) = n where n.l_j > 0, else 0
//! ```
//!
//! so all their inner products come from two moments, turned into the frames (l, s, t):
//!
//! ```text
//!   <v_j, y>   for each ambient column and channel y        <v_j, v_k^T>
//! ```
//!
//! An [`Objective`] provides these two, as sums over given normals (`samples/`) or in closed form over the
//! whole sphere of normals (`sphere/`).

use std::fmt::Debug;

use glam::{DMat3, DVec3};
use nalgebra::DMatrix;

use super::ambient::Ambient;
use super::rig::Rig;
use crate::kernels::sphere::tangents;

/// The error of a rig, and all that a fit needs to know of it.
pub trait Objective: Debug + Sync {
    /// What lights cannot change.
    fn given(&self) -> &Given;

    /// The moments of lights in `directions`.
    fn moments(&self, directions: Vec<DVec3>) -> Moments;

    /// The moments of the lights `kept` of `before`, and of others in the directions `new` after them.
    fn exchanged(&self, before: &Moments, kept: &[usize], new: &[DVec3]) -> Moments;

    /// The moments of the lights of `before`, turned to other `directions`.
    fn turned(&self, before: &Moments, directions: Vec<DVec3>) -> Moments;

    /// The inner products of the derivatives of the lights of `moments` but the first `fixed`.
    fn derivatives(&self, moments: &Moments, fixed: usize) -> Derivatives;

    /// Each light and normal where the cost has a kink, or ends, on the way from one place to the other.
    fn kinks(&self, from: &Moments, to: &Moments) -> Vec<(usize, DVec3)>;

    /// The second derivative by the direction `l` of `sum_k w_k <a_l, a_k> + sum_y w_y <a_l, y>` with the `weights` of
    /// lights and those of `sides`, on its tangent plane and for functions of degree 1 in l; none where the objective
    /// has no second derivatives.
    fn second_derivative(&self, l: DVec3, lights: &[DVec3], weights: &[f64], sides: &[f64]) -> Option<DMat3>;

    /// `<a_d, a_l>`: a row for each direction d of `at`, a column for each of `lights`.
    fn light_products(&self, at: &Directions, lights: &[DVec3]) -> DMatrix<f64>;

    /// `<a_d, y>`: a row for each direction d, a column for each side y.
    fn side_products(&self, at: &Directions) -> DMatrix<f64>;

    /// `<a_d, a_d>` of each direction.
    fn squares(&self, at: &Directions) -> Vec<f64>;

    /// Directions that will be asked for again and again.
    fn directions(&self, directions: Vec<DVec3>) -> Directions {
        Directions { directions, weighted: DMatrix::zeros(0, 0) }
    }

    /// Places where lights are likely, the likeliest first.
    fn likely(&self) -> &[DVec3] {
        &[]
    }

    /// A fall of the cost that says nothing, as a share of the energy: what the objective itself is off by.
    fn noise(&self) -> f64 {
        0.0
    }

    /// Whether the cost has many small valleys between kinks.
    fn has_kinks(&self) -> bool;

    /// The cost of `rig` without cancellation, where that is known.
    fn exact_cost(&self, rig: &Rig) -> Option<f64>;

    /// Whether a light may stand there.
    fn allows(&self, _direction: DVec3) -> bool {
        true
    }

    /// A direction of a fixed pattern, such as an even start, in a frame that turns with what is fitted, so that the
    /// answer does too; where no light may stand, its mirror image.
    fn placed(&self, direction: DVec3) -> DVec3 {
        direction
    }
}

/// What lights cannot change.
#[derive(Clone, Debug)]
pub struct Given {
    /// What the rig may have beside the lights.
    pub ambient: Ambient,
    /// Whether a floor hides what is below the horizon.
    pub has_floor: bool,
    /// The channels that are fitted: neither black nor the same as one before.
    pub channels: Vec<usize>,
    /// For each of red, green, blue its place in `channels`; none where it is black.
    pub like: [Option<usize>; 3],
    /// Inner products of the ambient columns with each side: the ambient columns, then the channels.
    pub ambient_products: DMatrix<f64>,
    /// `<E, E>` over all three channels: the cost of no light at all.
    pub energy: f64,
}

impl Given {
    /// Before anything is known of the probe.
    pub fn nothing(ambient: Ambient, has_floor: bool) -> Self {
        let ambient_products = DMatrix::zeros(ambient.coefficients(), ambient.coefficients());
        Self { ambient, has_floor, channels: Vec::new(), like: [None; 3], ambient_products, energy: 0.0 }
    }

    /// Columns that every light is multiplied with: those of the ambient term, then the irradiance in
    /// each channel.
    pub fn sides(&self) -> usize {
        self.ambient.coefficients() + self.channels.len()
    }

    /// Ambient coefficients that may have any sign: harmonics do, a radiance does not.
    pub fn free(&self) -> usize {
        if self.ambient == Ambient::Sh2 { self.ambient.coefficients() } else { 0 }
    }

    /// How many of red, green, blue a fitted channel stands for.
    pub fn copies(&self, channel: usize) -> f64 {
        self.like.iter().filter(|like| **like == Some(channel)).count() as f64
    }
}

/// The channels that have to be fitted, and for each of the three the one that it is like.
pub fn distinct_channels(
    is_black: impl Fn(usize) -> bool,
    are_same: impl Fn(usize, usize) -> bool,
) -> (Vec<usize>, [Option<usize>; 3]) {
    let mut channels: Vec<usize> = Vec::new();
    let mut like = [None; 3];
    for (channel, like) in like.iter_mut().enumerate().filter(|(channel, _)| !is_black(*channel)) {
        let place = channels.iter().position(|&other| are_same(other, channel));
        *like = place.or_else(|| {
            channels.push(channel);
            Some(channels.len() - 1)
        });
    }
    (channels, like)
}

/// Directions that are tried again and again, and what an objective keeps of them.
#[derive(Clone, Debug)]
pub struct Directions {
    pub directions: Vec<DVec3>,
    /// `w max(0, n.d)` of given normals: a row for each direction, a column for each normal.
    pub weighted: DMatrix<f64>,
}

/// Inner products of the columns of the model, `[A.., a_1, a_2, ..]`, and the moments that they and their
/// derivatives come from.
#[derive(Clone, Debug)]
pub struct Moments {
    /// Towards each light.
    pub directions: Vec<DVec3>,
    /// Of the columns with each other.
    pub gram: DMatrix<f64>,
    /// Of the columns with the irradiance in each fitted channel.
    pub rhs: DMatrix<f64>,
    /// `<v_j, y>`: for each light as many as there are sides.
    pub sides: Vec<DVec3>,
    /// `<v_j, v_k^T>` for k <= j: only for given normals.
    pub pairs: Vec<DMat3>,
    /// The normals that see each light, as bits: only for given normals.
    pub visible: Vec<u64>,
}

/// Inner products of two lights when these turn along their tangents.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    pub own: [f64; 2],
    pub other: [f64; 2],
    pub both: [[f64; 2]; 2],
}

/// Inner products of the derivatives `[s_1, t_1, s_2, t_2, ..]` of the columns, by which the model changes
/// when a light turns.
#[derive(Clone, Debug)]
pub struct Derivatives {
    /// The tangents of each light that may turn.
    pub frames: Vec<[DVec3; 2]>,
    /// With the columns of the model.
    pub model: DMatrix<f64>,
    /// With each other.
    pub gram: DMatrix<f64>,
    /// With the irradiance in each fitted channel.
    pub rhs: DMatrix<f64>,
}

impl Moments {
    /// Of lights in `directions` with the `sides`; not yet of the lights with each other.
    pub fn with_sides(given: &Given, directions: Vec<DVec3>, sides: Vec<DVec3>) -> Self {
        let ambient = given.ambient.coefficients();
        let size = ambient + directions.len();
        let mut gram = DMatrix::zeros(size, size);
        let mut rhs = DMatrix::zeros(size, given.channels.len());
        gram.view_mut((0, 0), (ambient, ambient)).copy_from(&given.ambient_products.columns(0, ambient));
        rhs.rows_mut(0, ambient).copy_from(&given.ambient_products.columns_range(ambient..));
        for (j, &l) in directions.iter().enumerate() {
            let row = ambient + j;
            for (side, sum) in sides[j * given.sides()..(j + 1) * given.sides()].iter().enumerate() {
                if let Some(channel) = side.checked_sub(ambient) {
                    rhs[(row, channel)] = sum.dot(l);
                } else {
                    gram[(row, side)] = sum.dot(l);
                    gram[(side, row)] = gram[(row, side)];
                }
            }
        }
        Self { directions, gram, rhs, sides, pairs: Vec::new(), visible: Vec::new() }
    }
}

impl Derivatives {
    /// Those of the lights but the first `fixed`, with the sides; not yet with lights.
    pub fn with_sides(given: &Given, moments: &Moments, fixed: usize) -> Self {
        let ambient = given.ambient.coefficients();
        let frames: Vec<[DVec3; 2]> = moments.directions[fixed..].iter().map(|&l| tangents(l)).collect();
        let size = 2 * frames.len();
        let mut model = DMatrix::zeros(size, moments.gram.nrows());
        let mut rhs = DMatrix::zeros(size, given.channels.len());
        let sides = moments.sides.chunks_exact(given.sides().max(1)).skip(fixed);
        for (light, (sides, [s, t])) in sides.zip(&frames).enumerate() {
            for (side, &sum) in sides.iter().enumerate() {
                let products = match side.checked_sub(ambient) {
                    Some(channel) => &mut rhs.column_mut(channel),
                    None => &mut model.column_mut(side),
                };
                products[2 * light] = sum.dot(*s);
                products[2 * light + 1] = sum.dot(*t);
            }
        }
        Self { frames, model, gram: DMatrix::zeros(size, size), rhs }
    }

    /// The products of the derivatives of the light j with the light k, along `own` tangents of j, `other` ones of k, and
    /// `both`: among lights of which the first `fixed` do not turn, and beside that many `ambient` columns.
    #[inline]
    pub fn set(&mut self, ambient: usize, fixed: usize, [j, k]: [usize; 2], pair: &Pair) {
        let (size, row) = (self.gram.nrows(), 2 * (j - fixed));
        self.model.as_mut_slice()[(ambient + k) * size + row..][..2].copy_from_slice(&pair.own);
        let Some(column) = k.checked_sub(fixed).map(|k| 2 * k) else { return };
        self.model.as_mut_slice()[(ambient + j) * size + column..][..2].copy_from_slice(&pair.other);
        let gram = self.gram.as_mut_slice();
        for (a, both) in pair.both.iter().enumerate() {
            for (b, &both) in both.iter().enumerate() {
                gram[(column + b) * size + row + a] = both;
                gram[(row + a) * size + column + b] = both;
            }
        }
    }
}
