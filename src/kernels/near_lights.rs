//! Irradiance at points in space, under lights with a position.
//!
//! | light  | what a point receives                                                            |
//! |--------|----------------------------------------------------------------------------------|
//! | sphere | a disc, whose irradiance falls with the squared distance of its centre           |
//! | card   | Lambert's formula for its outline; nothing behind its plane                      |
//! | patch  | a point source of flux `L A cos / (r^2 + A / pi)`, as of a disc, finite at r = 0 |
//!
//! Spheres and cards are given by their irradiance at normal incidence from the origin, so that the origin receives
//! exactly that. Nothing hides a light from a point.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DMat3, DVec3};
use ndarray::{Array3, ArrayView1, ArrayView2};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::disc::irradiance_share;
use super::polygon;
use super::sphere::{check_rows, unit_vectors, vectors};
use crate::error::Result;
use crate::interrupt;

/// Vertices of the polygon that has the area of a round card: its irradiance at 2 radii differs by 1e-4.
const VERTICES: usize = 24;

/// Lights with positions, as rows of numbers.
#[derive(Clone, Copy)]
pub struct NearLights<'a> {
    /// Centre, radius, and irradiance at the origin, (n, 7).
    pub spheres: ArrayView2<'a, f64>,
    /// Columns U, V, O, 1 for an ellipse, and irradiance at the origin, (n, 13).
    pub cards: ArrayView2<'a, f64>,
    /// Centre, unit normal, area and radiance, (n, 10).
    pub patches: ArrayView2<'a, f64>,
}

/// Irradiance, (p, n, 3), of `normals`, (n, 3), at each of the `points`, (p, 3).
///
/// # Errors
///
/// [`Error::WrongColumns`](crate::error::Error::WrongColumns), [`Error::NotFinite`](crate::error::Error::NotFinite),
/// [`Error::NotUnit`](crate::error::Error::NotUnit).
pub fn irradiance(
    lights: NearLights<'_>,
    points: ArrayView2<'_, f64>,
    normals: ArrayView2<'_, f64>,
) -> Result<Array3<f64>> {
    check_rows("spheres", lights.spheres, 7)?;
    check_rows("cards", lights.cards, 13)?;
    check_rows("patches", lights.patches, 10)?;
    let (points, normals) = (vectors("points", points)?, unit_vectors("normal", normals)?);
    let columns = [0, 1, 2].map(|axis| normals.iter().map(|normal| normal[axis]).collect::<Vec<_>>());
    let outlines: Vec<_> = lights.cards.rows().into_iter().map(outline).collect();
    let at = |&point: &DVec3| {
        interrupt::check();
        let mut sums = [(); 3].map(|()| vec![0.0; normals.len()]);
        let sources: Vec<_> = lights.patches.rows().into_iter().map(|patch| source(patch, point)).collect();
        Arch::new().dispatch(PointSources { sources: &sources, normals: &columns, sums: &mut sums });
        for sphere in lights.spheres.rows() {
            let (direction, irradiance, radius) = disc(sphere, point);
            add(&mut sums, irradiance, &normals, |normal| irradiance_share(normal.dot(direction), radius));
        }
        for (vertices, radiance) in &outlines {
            let around: Vec<DVec3> = vertices.iter().map(|vertex| vertex - point).collect();
            let vector = polygon::vector_irradiance(&around);
            // Skip the back of the card.
            if vector.dot(around.iter().sum()) > 0.0 {
                add(&mut sums, *radiance, &normals, |normal| polygon::irradiance(&around, vector, normal));
            }
        }
        sums
    };
    let min_len = interrupt::min_task_len(points.len());
    let sums: Vec<[Vec<f64>; 3]> = points.par_iter().with_min_len(min_len).map(at).collect();
    Ok(Array3::from_shape_fn((points.len(), normals.len(), 3), |(i, j, channel)| sums[i][channel][j]))
}

/// Vector in three numbers of a row.
fn vector(row: ArrayView1<'_, f64>, first: usize) -> DVec3 {
    DVec3::new(row[first], row[first + 1], row[first + 2])
}

/// Direction, irradiance and angular radius of a sphere; a point inside sees a hemisphere.
fn disc(sphere: ArrayView1<'_, f64>, point: DVec3) -> (DVec3, DVec3, f64) {
    let (centre, radius) = (vector(sphere, 0), sphere[3].max(0.0));
    let to = centre - point;
    let distance = to.length().max(radius).max(f64::MIN_POSITIVE);
    let irradiance = vector(sphere, 4) * (centre.length() / distance).powi(2);
    (to.normalize_or(DVec3::Y), irradiance, (radius / distance).asin().min(FRAC_PI_2))
}

/// Vertices of a card, and its radiance; an ellipse becomes a polygon of the same area.
fn outline(card: ArrayView1<'_, f64>) -> (Vec<DVec3>, DVec3) {
    let matrix = DMat3::from_cols(vector(card, 0), vector(card, 3), vector(card, 6));
    let step = TAU / VERTICES as f64;
    let radius = (PI / (2.0 * VERTICES as f64 * step.sin())).sqrt();
    let places: Vec<(f64, f64)> = if card[9] == 0.0 {
        vec![(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    } else {
        let angles = (0..VERTICES).map(|i| (step * i as f64).sin_cos());
        angles.map(|(sin, cos)| (0.5 + radius * cos, 0.5 + radius * sin)).collect()
    };
    let vertices: Vec<DVec3> = places.iter().map(|&(a, b)| matrix * DVec3::new(a, b, 1.0)).collect();
    let centre = (matrix * DVec3::new(0.5, 0.5, 1.0)).normalize_or_zero();
    let unit = polygon::vector_irradiance(&vertices).dot(centre);
    (vertices, if unit > 0.0 { vector(card, 10) / unit } else { DVec3::ZERO })
}

/// Direction and irradiance of a patch.
fn source(patch: ArrayView1<'_, f64>, point: DVec3) -> (DVec3, DVec3) {
    let (to, area) = (vector(patch, 0) - point, patch[6]);
    let direction = to.normalize_or_zero();
    let cosine = (-direction.dot(vector(patch, 3))).max(0.0);
    (direction, vector(patch, 7) * (area * cosine / (to.length_squared() + area / PI)))
}

/// Add one light to the sums of red, green and blue at all normals.
fn add(sums: &mut [Vec<f64>; 3], colour: DVec3, normals: &[DVec3], share: impl Fn(DVec3) -> f64) {
    for (row, &normal) in normals.iter().enumerate() {
        let part = share(normal);
        for (channel, sum) in sums.iter_mut().enumerate() {
            sum[row] += colour[channel] * part;
        }
    }
}

/// Addition of point sources to the sums of red, green and blue at all normals.
struct PointSources<'a> {
    sources: &'a [(DVec3, DVec3)],
    normals: &'a [Vec<f64>; 3],
    sums: &'a mut [Vec<f64>; 3],
}

impl WithSimd for PointSources<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let [x, y, z] = self.normals.each_ref().map(Vec::as_slice);
        let [red, green, blue] = self.sums.each_mut().map(Vec::as_mut_slice);
        let count = x.len();
        // Slices of one length need no checks in the loop.
        let (y, z, red) = (&y[..count], &z[..count], &mut red[..count]);
        let (green, blue) = (&mut green[..count], &mut blue[..count]);
        for &(direction, irradiance) in self.sources {
            for i in 0..count {
                let cosine = (x[i] * direction.x + y[i] * direction.y + z[i] * direction.z).max(0.0);
                red[i] += irradiance.x * cosine;
                green[i] += irradiance.y * cosine;
                blue[i] += irradiance.z * cosine;
            }
        }
    }
}
