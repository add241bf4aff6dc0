//! Horizon of a normal across a band, and the irradiance from the part in front of it.

use std::f64::consts::TAU;

use glam::DVec3;

use super::band::{HorizonBand, weigh};
use super::opposite::VectorFlux;
use super::rows::Weight;
use crate::kernels::cell_integrals::RowIntegrals;
use crate::kernels::sphere::angles;

/// Rows of one parallel task. Another number changes the order of sums, and their last bits.
pub const ROWS_OF_A_RUN: usize = 8;

/// Gauss-Legendre nodes and weights on -1 .. 1.
pub type Nodes = &'static [(f64, f64)];
const ONE_NODE: Nodes = &[(0.0, 2.0)];

/// Steps of the horizon down the rows.
#[derive(Clone, Copy)]
pub struct Steps {
    /// Rows of a band; a band of more than one has one node.
    pub rows: usize,
    /// Strips into which a row is cut; a band of more rows is not cut.
    pub strips: usize,
    /// Latitudes in a strip at which the horizon is evaluated.
    pub nodes: Nodes,
}

impl Steps {
    /// One node at the middle latitude of each row.
    pub const ONE_NODE: Self = Self { rows: 1, strips: 1, nodes: ONE_NODE };

    /// Steps for a map of `height` rows: at least 64 strips from pole to pole, and at most 2047 bands.
    ///
    /// Maps of 2 to 64 rows are then within 2e-5 of the exact integral over their cells. See [`super::irradiance`] for
    /// maps of more rows.
    pub fn of(height: usize) -> Self {
        let two: Nodes = &[(-0.577_350_269_189_625_8, 1.0), (0.577_350_269_189_625_8, 1.0)];
        let four: Nodes = &[
            (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
            (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
            (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
            (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        ];
        match height {
            2048.. => Self { rows: height / 1024, strips: 1, nodes: ONE_NODE },
            256.. => Self { rows: 1, strips: 1, nodes: two },
            _ => Self { rows: 1, strips: 64_usize.div_ceil(height), nodes: four },
        }
    }
}

/// A normal and its horizon.
pub struct Normal {
    vector: DVec3,
    pub azimuth: f64,
    cos_azimuth: f64,
    sin_azimuth: f64,
    /// `-n_y / n_e`: the cosine of the half-width of the visible interval over cot theta.
    cosine_factor: f64,
}

impl Normal {
    pub fn new(vector: DVec3) -> Self {
        let equatorial = vector.x.hypot(vector.z).max(f64::MIN_POSITIVE);
        let (_, azimuth) = angles(vector);
        let (sin_azimuth, cos_azimuth) = azimuth.sin_cos();
        Self { vector, azimuth, cos_azimuth, sin_azimuth, cosine_factor: -vector.y / equatorial }
    }

    /// Cosine of the half-width of the visible interval of `slice`; below -1 all is visible, above 1 nothing.
    #[inline]
    pub fn cosine(&self, slice: &Slice) -> f64 {
        self.cosine_factor * slice.cot_theta
    }

    /// Half-width of the visible interval of `slice`.
    #[inline]
    pub fn half_width(&self, slice: &Slice) -> f64 {
        self.cosine(slice).clamp(-1.0, 1.0).acos()
    }

    /// Weights of the integrals of L cos phi, L sin phi and L over the slice.
    #[inline]
    pub fn weights(&self, slice: &Slice) -> DVec3 {
        let n = self.vector;
        DVec3::new(-slice.equatorial * n.z, slice.equatorial * n.x, slice.polar * n.y)
    }

    /// `weights . flux` of the interval of `half_width`, `acos(c)`, around the normal's azimuth.
    #[inline]
    fn between(&self, c: f64, half_width: f64, weights: DVec3, band: &HorizonBand<'_>) -> DVec3 {
        let s = (1.0 - c * c).sqrt();
        let (cos_n, sin_n) = (self.cos_azimuth, self.sin_azimuth);
        let (start, end) = (self.azimuth - half_width, self.azimuth + half_width);
        let [first, last] = [(start, s), (end, -s)]
            .map(|(phi, s)| band.up_to(weights, wrap(phi), cos_n * c + sin_n * s, sin_n * c - cos_n * s));
        let over_the_seam = start < 0.0 || end >= TAU;
        last - first + if over_the_seam { weigh(band.total(), weights) } else { DVec3::ZERO }
    }
}

/// `phi` in 0 .. 2 pi, from at most one turn outside.
fn wrap(phi: f64) -> f64 {
    if phi < 0.0 {
        phi + TAU
    } else if phi >= TAU {
        phi - TAU
    } else {
        phi
    }
}

/// A node of a row: the latitude at which the horizon is evaluated, and the weight of the node in the row.
pub struct Slice {
    cot_theta: f64,
    /// Part of the integral of sin^2 theta over the row.
    equatorial: f64,
    /// Part of the integral of sin theta cos theta over the row.
    polar: f64,
}

/// The row between two polar angles at the given nodes, scaled so that their sum is exact.
fn slices(top: f64, bottom: f64, nodes: Nodes) -> Vec<Slice> {
    // Integrate over the row in closed form.
    let (sum, difference) = (top + bottom, bottom - top);
    let RowIntegrals { squares: equatorial, products: polar, .. } = RowIntegrals::new(top, bottom);
    // Distribute that over the nodes.
    let angles: Vec<f64> = nodes.iter().map(|(node, _)| 0.5 * (sum + node * difference)).collect();
    let weigh = |f: fn(f64) -> f64| -> f64 { angles.iter().zip(nodes).map(|(&t, (_, w))| w * f(t)).sum() };
    let sin_squared = weigh(|theta| theta.sin().powi(2));
    angles
        .iter()
        .zip(nodes)
        .map(|(theta, (_, weight))| Slice {
            cot_theta: theta.cos() / theta.sin(),
            equatorial: equatorial * weight * theta.sin().powi(2) / sin_squared,
            // sin theta cos theta changes its sign at the equator, where a quotient of sums would
            // divide by 0; the ratio of the two exact integrals to their node values is the same to O(h^2).
            polar: if nodes.len() == 1 {
                polar
            } else {
                0.5 * difference * weight * theta.sin() * theta.cos()
            },
        })
        .collect()
}

/// Weights of the rows of a band, equatorial and polar, and the slices of the horizon through it.
///
/// The slices of a single row contain its weight; several rows have weights of their own, and one slice.
pub fn cut(theta_edges: &[f64], steps: Steps) -> (Vec<Weight>, Vec<Slice>) {
    let (top, bottom) = (theta_edges[0], theta_edges[theta_edges.len() - 1]);
    if theta_edges.len() == 2 {
        let edge = |i: usize| top + (bottom - top) * i as f64 / steps.strips as f64;
        let strips = (0..steps.strips).flat_map(|i| slices(edge(i), edge(i + 1), steps.nodes));
        return (vec![Weight { equatorial: 1.0, polar: 1.0 }], strips.collect());
    }
    let of_row = |edge: &[f64]| slices(edge[0], edge[1], ONE_NODE).remove(0);
    let rows = theta_edges
        .windows(2)
        .map(of_row)
        .map(|slice| Weight { equatorial: slice.equatorial, polar: slice.polar });
    let middle = 0.5 * (top + bottom);
    (rows.collect(), vec![Slice { cot_theta: middle.cos() / middle.sin(), equatorial: 1.0, polar: 1.0 }])
}

impl Slice {
    /// Irradiance at `normal` from the visible interval of this slice, `half_width` to both sides.
    #[inline]
    pub fn irradiance(&self, normal: &Normal, half_width: f64, band: &HorizonBand<'_>) -> DVec3 {
        let (c, weights) = (normal.cosine(self), normal.weights(self));
        if c >= 1.0 {
            DVec3::ZERO
        } else if c <= -1.0 {
            weigh(band.total(), weights)
        } else {
            normal.between(c, half_width, weights, band)
        }
    }

    /// Add the vector flux of the slice to `flux`.
    pub fn add_whole(&self, band: &HorizonBand<'_>, flux: &mut VectorFlux) {
        let [cos, sin, one] = *band.total();
        flux[0] += sin * self.equatorial;
        flux[1] += one * self.polar;
        flux[2] -= cos * self.equatorial;
    }
}
