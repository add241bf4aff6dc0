//! Evenly distributed points: Hammersley, Halton, icospheres. Nodes and weights of Gauss-Legendre quadrature.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use ndarray::{Array1, Array2, ArrayView2};

use super::sphere::{check_memory, check_rows, direction, from_vectors, spherical_area};
use crate::error::{Error, Result};
use crate::interrupt;

/// Subdivisions of the finest supported icosphere.
const SUBDIVISIONS: usize = 8;

/// Radical inverse of `index` in `base`: its digits mirrored at the radix point (van der Corput's sequence).
///
/// ```text
/// index = sum_k a_k base^k   ->   sum_k a_k base^(-k - 1)   in 0 .. 1
/// ```
///
/// # Errors
///
/// [`Error::BadBase`] for a base below 2.
pub fn radical_inverse(index: u64, base: u64) -> Result<f64> {
    if base < 2 {
        return Err(Error::BadBase { base });
    }
    Ok(mirrored_digits(index, base))
}

fn mirrored_digits(mut index: u64, base: u64) -> f64 {
    if base == 2 {
        // Reverse the bits; 53 of them fill a double.
        return (index.reverse_bits() >> 11) as f64 * 2.0_f64.powi(-53);
    }
    let (mut value, mut weight) = (0.0, 1.0);
    while index > 0 {
        weight /= base as f64;
        value += weight * (index % base) as f64;
        index /= base;
    }
    value
}

/// The `count` Hammersley points of the unit square, (count, 2): `(i / count, radical inverse of i)`.
///
/// # Errors
///
/// [`Error::NoMemory`].
pub fn hammersley(count: usize) -> Result<Array2<f64>> {
    check_memory(&[count, 2])?;
    Ok(Array2::from_shape_fn((count, 2), |(i, axis)| {
        interrupt::check();
        if axis == 0 { i as f64 / count as f64 } else { mirrored_digits(i as u64, 2) }
    }))
}

/// The first `count` Halton points, (count, number of bases): one radical inverse for each base.
///
/// # Errors
///
/// [`Error::BadBase`] for a base below 2, [`Error::NoMemory`].
pub fn halton(count: usize, bases: &[u64]) -> Result<Array2<f64>> {
    if let Some(&base) = bases.iter().find(|&&base| base < 2) {
        return Err(Error::BadBase { base });
    }
    check_memory(&[count, bases.len()])?;
    Ok(Array2::from_shape_fn((count, bases.len()), |(i, axis)| {
        interrupt::check();
        mirrored_digits(i as u64, bases[axis])
    }))
}

/// Equal-area mapping of points of the unit square, (n, 2), to the sphere, (n, 3).
///
/// Archimedes: height on the axis is uniform. `u` runs from the top pole to the bottom one
/// (`y = 1 - 2 u`), `v` around (`phi = 2 pi v`).
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::NotFinite`].
pub fn uniform_sphere(uv: ArrayView2<'_, f64>) -> Result<Array2<f64>> {
    check_rows("uv", uv, 2)?;
    Ok(from_vectors(uv.rows().into_iter().map(|row| {
        // acos(1 - 2u) = 2 asin(sqrt u), which keeps its digits at the poles.
        direction(2.0 * row[0].clamp(0.0, 1.0).sqrt().asin(), TAU * row[1])
    })))
}

/// `count` evenly distributed directions, (count, 3): Hammersley points shifted by half a step away from the poles.
pub fn even_sphere(count: usize) -> Array2<f64> {
    from_vectors((0..count).map(|i| {
        let height = (i as f64 + 0.5) / count as f64;
        direction(2.0 * height.sqrt().asin(), TAU * mirrored_digits(i as u64, 2))
    }))
}

/// Centroids, (faces, 3), and solid angles, (faces,), of the faces of a subdivided icosahedron.
///
/// Each subdivision cuts every triangle into four at the midpoints of its edges, pushed out to
/// the sphere. The solid angles differ by -7 % / +20 % from their mean: weight by them.
///
/// # Errors
///
/// [`Error::NoSuchIcosphere`] when `faces` is not 20 * 4^k.
pub fn icosphere(faces: usize) -> Result<(Array2<f64>, Array1<f64>)> {
    let triangles = (0..subdivisions(faces)?).fold(icosahedron(), |triangles, _| {
        interrupt::check();
        triangles.into_iter().flat_map(quarters).collect()
    });
    let centroids = from_vectors(triangles.iter().map(|[a, b, c]| (*a + *b + *c).normalize()));
    Ok((centroids, triangles.iter().map(|&corners| spherical_area(corners)).collect()))
}

/// Number of subdivisions of an icosahedron that give this number of faces.
fn subdivisions(faces: usize) -> Result<usize> {
    let levels = (0..=SUBDIVISIONS).find(|&level| 20 << (2 * level) == faces);
    levels.ok_or(Error::NoSuchIcosphere { faces, limit: 20 << (2 * SUBDIVISIONS) })
}

/// Search for the face of an icosphere that contains a direction.
#[derive(Clone, Debug)]
pub struct FaceSearch {
    roots: Vec<[DVec3; 3]>,
    levels: usize,
}

impl FaceSearch {
    /// Search over the faces of [`icosphere`], in its order.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchIcosphere`] when `faces` is not 20 * 4^k.
    pub fn new(faces: usize) -> Result<Self> {
        Ok(Self { roots: icosahedron(), levels: subdivisions(faces)? })
    }

    /// Index of the face that contains `direction`.
    pub fn face_of(&self, direction: DVec3) -> usize {
        // Find the face of the icosahedron: its faces are congruent, so the nearest centroid decides.
        let nearness = self.roots.iter().map(|[a, b, c]| direction.dot(*a + *b + *c)).enumerate();
        let root = nearness.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index);
        // Descend into the quarter that contains the direction, level by level.
        let mut triangle = self.roots[root];
        (0..self.levels).fold(root, |face, _| {
            let parts = quarters(triangle);
            let part = quarter_of(&parts, direction);
            triangle = parts[part];
            4 * face + part
        })
    }
}

/// Index of the quarter of a triangle that contains `direction`.
///
/// A corner contains the direction if it lies beyond the side between the corner and the middle; else the middle does.
fn quarter_of(quarters: &[[DVec3; 3]; 4], direction: DVec3) -> usize {
    let [ab, bc, ca] = quarters[3];
    let is_beyond = |from: DVec3, to: DVec3, corner: DVec3| {
        let side = from.cross(to);
        direction.dot(side) * corner.dot(side) > 0.0
    };
    let corners = [(ca, ab, quarters[0][0]), (ab, bc, quarters[1][1]), (bc, ca, quarters[2][2])];
    corners.into_iter().position(|(from, to, corner)| is_beyond(from, to, corner)).unwrap_or(3)
}

/// The 20 faces of the icosahedron with vertices on both poles.
fn icosahedron() -> Vec<[DVec3; 3]> {
    let latitude_circle = |theta: f64, turn: f64| -> Vec<DVec3> {
        (0..5).map(|k| direction(theta, (f64::from(k) + turn) * TAU / 5.0)).collect()
    };
    let theta = 2.0_f64.atan();
    let (upper, lower) = (latitude_circle(theta, 0.0), latitude_circle(PI - theta, 0.5));
    (0..5)
        .flat_map(|k| {
            let next = (k + 1) % 5;
            [
                [DVec3::Y, upper[k], upper[next]],
                [upper[k], lower[k], upper[next]],
                [upper[next], lower[k], lower[next]],
                [DVec3::NEG_Y, lower[next], lower[k]],
            ]
        })
        .collect()
}

fn quarters([a, b, c]: [DVec3; 3]) -> [[DVec3; 3]; 4] {
    let (ab, bc, ca) = ((a + b).normalize(), (b + c).normalize(), (c + a).normalize());
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// Nodes, from 1 down, and weights of the Gauss-Legendre rule of `count` nodes on -1 .. 1.
///
/// Newton's method on the Legendre polynomial P, with `P' = n (x P_n - P_(n-1)) / (x^2 - 1)`; the weight is
/// `2 / ((1 - x^2) P'^2)`.
pub(crate) fn gauss_legendre(count: usize) -> (Vec<f64>, Vec<f64>) {
    let node = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
        let mut derivative = 1.0;
        // Take 6 Newton steps. Each doubles the number of correct digits, so 4 reach double precision.
        for _ in 0..6 {
            let (mut before, mut value) = (1.0, x);
            for k in 2..=count {
                let k = k as f64;
                (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
            }
            derivative = count as f64 * (x * value - before) / (x * x - 1.0);
            x -= value / derivative;
        }
        (x, 2.0 / ((1.0 - x * x) * derivative * derivative))
    };
    (0..count).map(node).unzip()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn gauss_legendre_integrates_polynomials() {
        for count in [2, 10, 40, 108] {
            let (nodes, weights) = gauss_legendre(count);
            let integral = |power: i32| -> f64 {
                nodes.iter().zip(&weights).map(|(x, weight)| weight * x.powi(power)).sum()
            };
            for power in [0, 1, 2, 3] {
                let expected = if power % 2 == 0 { 2.0 / f64::from(power + 1) } else { 0.0 };
                assert!((integral(power) - expected).abs() < 1e-13, "{count} nodes, power {power}");
            }
            let last = 2 * count as i32 - 2;
            assert!((integral(last) - 2.0 / f64::from(last + 1)).abs() < 1e-13, "{count} nodes");
        }
    }

    /// Near the corners of a face, the nearest centroid may belong to another face.
    #[test]
    fn a_face_is_found_from_anywhere_inside() {
        for faces in [20, 320, 5120] {
            let search = FaceSearch::new(faces).unwrap();
            let mut triangles = icosahedron();
            while triangles.len() < faces {
                triangles = triangles.into_iter().flat_map(quarters).collect();
            }
            for (face, &[a, b, c]) in triangles.iter().enumerate() {
                for inside in [a + b + c, a * 0.98 + b * 0.01 + c * 0.01, a * 0.01 + b * 0.5 + c * 0.49] {
                    assert_eq!(search.face_of(inside.normalize()), face, "of {faces}");
                }
            }
        }
        assert!(FaceSearch::new(100).is_err());
    }
}
