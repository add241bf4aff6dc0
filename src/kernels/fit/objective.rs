//! The cost of a fit: the squared difference of two probes, by inner products.
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
//! An [`Objective`] provides these two, as sums over known normals (`samples/`) or in closed form over the
//! whole sphere of normals (`sphere/`).

use std::fmt::Debug;

use glam::{DMat3, DVec3};
use nalgebra::DMatrix;

use super::ambient::Ambient;
use super::light_disc::Disc;
use super::rig::Rig;
use crate::kernels::sphere::{exponential_map, tangents};

/// A cost of lights, by inner products of their columns.
pub trait Objective: Debug + Sync {
    /// The part of the cost that no light changes.
    fn reference(&self) -> &Reference;

    /// Number of coordinates of a light: two along the tangents of its direction, and the logarithm of its radius if it
    /// has one.
    fn coordinates(&self) -> usize {
        2
    }

    /// The moments after a `step` in the coordinates of all lights.
    fn after_step(&self, before: &Moments, step: &[f64]) -> Moments;

    /// The moments of the lights `kept` alone.
    fn subset(&self, before: &Moments, kept: &[usize]) -> Moments;

    /// The inner products of the derivatives of lights whose radiances are `x`.
    fn derivatives(&self, moments: &Moments, x: &DMatrix<f64>, is_exact: bool) -> Derivatives;

    /// Constraints of lights that press against a bound, by half the `gradient` of the cost; the first `fixed` lights keep
    /// their directions.
    fn bounds(&self, _moments: &Moments, _gradient: &[f64], _fixed: usize) -> Vec<Constraint> {
        Vec::new()
    }

    /// Kinks of the cost on the way from one set of lights to another.
    fn kinks(&self, _from: &Moments, _to: &Moments) -> Vec<Constraint> {
        Vec::new()
    }

    /// The cost of `rig` without cancellation, if the objective can sum it from residuals.
    fn exact_cost(&self, _rig: &Rig) -> Option<f64> {
        None
    }
}

/// An objective of lights without a size, which a search can add and exchange.
pub trait PointObjective: Objective {
    /// The moments of the lights `kept` of `before`, and of others in the directions `new` after them.
    fn exchange(&self, before: &Moments, kept: &[usize], new: &[DVec3]) -> Moments;

    /// The moments of the lights of `before`, turned to other `directions`.
    fn turn_to(&self, before: &Moments, directions: Vec<DVec3>) -> Moments;

    /// The moments of lights in `directions`.
    fn moments(&self, directions: &[DVec3]) -> Moments {
        self.exchange(&Moments::with_sides(self.reference(), Vec::new(), Vec::new()), &[], directions)
    }

    /// `<a_d, a_l>`: a row for each direction d of `at`, a column for each of `lights`.
    fn light_products(&self, at: &Directions, lights: &[DVec3]) -> DMatrix<f64>;

    /// `<a_d, y>`: a row for each direction d, a column for each side y.
    fn side_products(&self, at: &Directions) -> DMatrix<f64>;

    /// `<a_d, a_d>` of each direction.
    fn squares(&self, at: &Directions) -> Vec<f64>;

    /// Directions that are used many times.
    fn directions(&self, directions: Vec<DVec3>) -> Directions {
        Directions { directions, weighted: DMatrix::zeros(0, 0) }
    }

    /// Directions of bright sources, brightest first.
    fn likely(&self) -> &[DVec3] {
        &[]
    }

    /// Error of the cost itself, as a fraction of the energy.
    fn noise(&self) -> f64 {
        0.0
    }

    /// True if kinks cut each minimum of the cost into many small ones.
    fn has_kinks(&self) -> bool {
        false
    }

    /// A direction of a fixed pattern in a frame that turns with the map, so that the result does too.
    ///
    /// If no light is allowed there, it is the mirror image.
    fn place(&self, direction: DVec3) -> DVec3 {
        direction
    }
}

/// A linear constraint on the step of one light: `across.step = ahead`.
#[derive(Clone, Copy, Debug)]
pub struct Constraint {
    pub light: usize,
    /// A factor for each coordinate; the third is 0 for points.
    pub across: DVec3,
    pub ahead: f64,
}

impl Constraint {
    /// One coordinate that does not change.
    pub fn hold(light: usize, coordinate: usize) -> Self {
        Self { light, across: DVec3::AXES[coordinate], ahead: 0.0 }
    }

    /// A step of a light in direction `l` onto the horizon of a normal: `n.l = 0` to first order.
    pub fn horizon(light: usize, l: DVec3, normal: DVec3) -> Self {
        let [s, t] = tangents(l).map(|tangent| normal.dot(tangent));
        Self { light, across: DVec3::new(s, t, 0.0), ahead: -normal.dot(l) }
    }
}

/// Directions of points after a `step` along their tangents.
pub fn turn_by(directions: &[DVec3], step: &[f64]) -> Vec<DVec3> {
    let turn = |(&l, step): (&DVec3, &[f64; 2])| {
        let [s, t] = tangents(l);
        exponential_map(l, s * step[0] + t * step[1])
    };
    directions.iter().zip(step.as_chunks::<2>().0).map(turn).collect()
}

/// The part of a cost that lights do not change.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Ambient term beside the lights.
    pub ambient: Ambient,
    /// True if a floor hides the sphere below the horizon.
    pub has_floor: bool,
    /// Fitted channels: neither black nor equal to one before.
    pub channels: Vec<usize>,
    /// Index in `channels` of each of red, green and blue; absent if it is black.
    pub like: [Option<usize>; 3],
    /// Inner products of the ambient columns with each side: the ambient columns, then the channels.
    pub ambient_products: DMatrix<f64>,
    /// `<E, E>` over all three channels: the cost of no light at all.
    pub energy: f64,
}

impl Reference {
    /// Neither channels nor energy.
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

    /// Number of the channels red, green and blue that equal a fitted one.
    pub fn copies(&self, channel: usize) -> f64 {
        self.like.iter().filter(|like| **like == Some(channel)).count() as f64
    }
}

/// The channels to fit, and for each of the three the index of the one that equals it.
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

/// Directions that are used many times, and products of an objective with them.
#[derive(Clone, Debug)]
pub struct Directions {
    pub directions: Vec<DVec3>,
    /// `w max(0, n.d)` at known normals: a row for each direction, a column for each normal.
    pub weighted: DMatrix<f64>,
}

/// Inner products of the columns of the model, `[A.., a_1, a_2, ..]`, and the moments that they and their
/// derivatives come from.
#[derive(Clone, Debug)]
pub struct Moments {
    /// Towards each light.
    pub directions: Vec<DVec3>,
    /// Products of the columns with each other.
    pub gram: DMatrix<f64>,
    /// Products of the columns with the irradiance in each fitted channel.
    pub rhs: DMatrix<f64>,
    /// `<v_j, y>`: for each light as many as there are sides.
    pub sides: Vec<DVec3>,
    /// `<v_j, v_k^T>` for k <= j: only for known normals.
    pub pairs: Vec<DMat3>,
    /// Normals at which each light is visible, as bits: only for known normals.
    pub visible: Vec<u64>,
    /// The lights themselves: only for lights with a size.
    pub discs: Vec<Disc>,
}

/// Inner products of two lights when these turn along their tangents.
#[derive(Clone, Copy, Debug)]
pub struct PointPair {
    pub own: [f64; 2],
    pub other: [f64; 2],
    pub both: [[f64; 2]; 2],
}

/// Inner products of the derivatives of the columns by all coordinates of the lights, light after light.
#[derive(Clone, Debug)]
pub struct Derivatives {
    /// Products with the columns of the model.
    pub model: DMatrix<f64>,
    /// Products of the derivatives with each other.
    pub gram: DMatrix<f64>,
    /// Products with the irradiance in each fitted channel.
    pub rhs: DMatrix<f64>,
    /// `-sum_c x_ic <d^2 a_ik, r_c>` of each light, if the objective has second derivatives.
    pub second: Option<Vec<DMat3>>,
}

impl Moments {
    /// Products of lights in `directions` with the `sides`; those of the lights with each other are still 0.
    pub fn with_sides(reference: &Reference, directions: Vec<DVec3>, sides: Vec<DVec3>) -> Self {
        let ambient = reference.ambient.coefficients();
        let size = ambient + directions.len();
        let mut gram = DMatrix::zeros(size, size);
        let mut rhs = DMatrix::zeros(size, reference.channels.len());
        gram.view_mut((0, 0), (ambient, ambient)).copy_from(&reference.ambient_products.columns(0, ambient));
        rhs.rows_mut(0, ambient).copy_from(&reference.ambient_products.columns_range(ambient..));
        for (j, &l) in directions.iter().enumerate() {
            let row = ambient + j;
            for (side, sum) in sides[j * reference.sides()..(j + 1) * reference.sides()].iter().enumerate() {
                if let Some(channel) = side.checked_sub(ambient) {
                    rhs[(row, channel)] = sum.dot(l);
                } else {
                    gram[(row, side)] = sum.dot(l);
                    gram[(side, row)] = gram[(row, side)];
                }
            }
        }
        Self { directions, gram, rhs, sides, pairs: Vec::new(), visible: Vec::new(), discs: Vec::new() }
    }
}

impl Derivatives {
    /// Zeros for lights of `each` coordinates.
    pub fn zeros(reference: &Reference, lights: usize, each: usize) -> Self {
        let (size, columns) = (each * lights, reference.ambient.coefficients() + lights);
        Self {
            model: DMatrix::zeros(size, columns),
            gram: DMatrix::zeros(size, size),
            rhs: DMatrix::zeros(size, reference.channels.len()),
            second: None,
        }
    }

    /// Products of the derivatives of points with the sides; those with lights are still 0.
    pub fn with_sides(reference: &Reference, moments: &Moments) -> Self {
        let ambient = reference.ambient.coefficients();
        let mut out = Self::zeros(reference, moments.directions.len(), 2);
        for (light, sides) in moments.sides.chunks_exact(reference.sides().max(1)).enumerate() {
            let [s, t] = tangents(moments.directions[light]);
            for (side, &sum) in sides.iter().enumerate() {
                let mut products = match side.checked_sub(ambient) {
                    Some(channel) => out.rhs.column_mut(channel),
                    None => out.model.column_mut(side),
                };
                products[2 * light] = sum.dot(s);
                products[2 * light + 1] = sum.dot(t);
            }
        }
        out
    }

    /// Set the products of the derivatives of the points j and k along their tangents, beside that many `ambient` columns.
    #[inline]
    pub fn set(&mut self, ambient: usize, [j, k]: [usize; 2], pair: &PointPair) {
        let (size, row, column) = (self.gram.nrows(), 2 * j, 2 * k);
        self.model.as_mut_slice()[(ambient + k) * size + row..][..2].copy_from_slice(&pair.own);
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

/// `sum_c x_jc x_kc`: the weight of the product of two columns in the cost.
pub fn column_weights(reference: &Reference, x: &DMatrix<f64>) -> DMatrix<f64> {
    let weighted = DMatrix::from_fn(x.nrows(), x.ncols(), |i, c| reference.copies(c) * x[(i, c)]);
    weighted * x.transpose()
}
