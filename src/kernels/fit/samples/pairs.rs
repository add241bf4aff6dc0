//! Inner products of lights and of their derivatives, from the moments of pairs of lights.
//!
//! For the frames (l, s, t) of two lights j and k, they are the entries of
//!
//! ```text
//!   (l, s, t)_j^T <v_j, v_k^T> (l, s, t)_k
//! ```

use glam::{DMat3, DVec3};

use crate::kernels::fit::objective::{Derivatives, Moments, PointPair, Reference};
use crate::kernels::sphere::tangents;

/// Index of the pair k <= j.
pub fn pair(j: usize, k: usize) -> usize {
    j * (j + 1) / 2 + k
}

/// The moments of lights in `directions`, from `sides` and `pairs`.
pub fn moments(
    reference: &Reference,
    directions: Vec<DVec3>,
    sides: Vec<DVec3>,
    pairs: Vec<DMat3>,
) -> Moments {
    let mut moments = Moments::with_sides(reference, directions, sides);
    let ambient = reference.ambient.coefficients();
    for (j, &l) in moments.directions.iter().enumerate() {
        for (k, &other) in moments.directions[..=j].iter().enumerate() {
            let product = (pairs[pair(j, k)] * other).dot(l);
            moments.gram[(ambient + j, ambient + k)] = product;
            moments.gram[(ambient + k, ambient + j)] = product;
        }
    }
    Moments { pairs, ..moments }
}

/// Inner products of the derivatives of all lights.
pub fn derivatives(reference: &Reference, moments: &Moments) -> Derivatives {
    let ambient = reference.ambient.coefficients();
    let mut derivatives = Derivatives::with_sides(reference, moments);
    let frame = |&l: &DVec3| {
        let [s, t] = tangents(l);
        DMat3::from_cols(l, s, t)
    };
    let frames: Vec<DMat3> = moments.directions.iter().map(frame).collect();
    for (j, frame) in frames.iter().enumerate() {
        let transpose = frame.transpose();
        for (k, other) in frames[..=j].iter().enumerate() {
            // Each row is an axis of j, each column one of k.
            let [[_, own @ ..], s, t] = (transpose * moments.pairs[pair(j, k)] * *other).to_cols_array_2d();
            let both = [[s[1], t[1]], [s[2], t[2]]];
            derivatives.set(ambient, [j, k], &PointPair { own, other: [s[0], t[0]], both });
        }
    }
    derivatives
}
