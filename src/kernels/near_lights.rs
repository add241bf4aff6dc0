//! Irradiance at points in space, under lights with a position.
//!
//! | light  | what a point receives                                                              |
//! |--------|------------------------------------------------------------------------------------|
//! | sphere | a disc, whose irradiance falls with the squared distance of its centre             |
//! | card   | Lambert's formula for its outline; nothing behind its plane                        |
//! | patch  | a point source of flux `L A cos / (r^2 + A / pi)`, as of a disc, finite at r = 0   |
//!
//! Spheres and cards are given by their irradiance at normal incidence from the origin, so that the origin receives
//! exactly that. Nothing stands between a light and a point.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use glam::{DMat3, DVec3};
use ndarray::{Array3, ArrayView1, ArrayView2, ArrayView3};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::disc::irradiance_share;
use super::polygon;
use super::sphere::{check_lengths, check_rows, unit_vectors, vectors};
use crate::error::{Error, Result};
use crate::interrupt;

/// Vertices of the polygon that has the area of a round card: its irradiance at 2 radii differs by 1e-4.
const VERTICES: usize = 24;

/// Ball of uniform radiance.
struct Ball {
    centre: DVec3,
    radius: f64,
    /// Irradiance at distance 1.
    intensity: DVec3,
}

/// Outline of a card, and its radiance.
struct Outline {
    vertices: Vec<DVec3>,
    radiance: DVec3,
}

/// Small part of a surface that reflects diffusely.
struct Patch {
    centre: DVec3,
    normal: DVec3,
    area: f64,
    radiance: DVec3,
}

/// Lights with positions.
pub struct NearLights {
    balls: Vec<Ball>,
    outlines: Vec<Outline>,
    patches: Vec<Patch>,
}

impl NearLights {
    /// No light.
    pub const fn new() -> Self {
        Self { balls: Vec::new(), outlines: Vec::new(), patches: Vec::new() }
    }

    /// Add balls: (n, 3) centres, (n,) radii, (n, 3) irradiance at the origin.
    ///
    /// # Errors
    ///
    /// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::LengthMismatch`].
    pub fn add_balls(
        &mut self,
        centres: ArrayView2<'_, f64>,
        radii: ArrayView1<'_, f64>,
        irradiance: ArrayView2<'_, f64>,
    ) -> Result<()> {
        let (centres, irradiance) = (vectors("position", centres)?, vectors("irradiance", irradiance)?);
        let lengths = [("radius", radii.len()), ("irradiance", irradiance.len())];
        check_lengths("position", centres.len(), lengths)?;
        let balls = centres.into_iter().zip(radii).zip(irradiance);
        self.balls.extend(balls.map(|((centre, &radius), irradiance)| Ball {
            centre,
            radius,
            intensity: irradiance * centre.length_squared(),
        }));
        Ok(())
    }

    /// Add cards: (n, 3, 3) matrices, true for each ellipse, (n, 3) irradiance at the origin.
    ///
    /// # Errors
    ///
    /// [`Error::WrongShape`], [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::LengthMismatch`].
    pub fn add_cards(
        &mut self,
        matrices: ArrayView3<'_, f64>,
        is_disc: &[bool],
        irradiance: ArrayView2<'_, f64>,
    ) -> Result<()> {
        if matrices.shape()[1..] != [3, 3] {
            let shape = matrices.shape().to_vec();
            return Err(Error::WrongShape { what: "matrix", wanted: "(n, 3, 3)", shape });
        }
        let irradiance = vectors("irradiance", irradiance)?;
        let lengths = [("is_disc", is_disc.len()), ("irradiance", irradiance.len())];
        check_lengths("matrix", matrices.dim().0, lengths)?;
        for ((matrix, &is_disc), irradiance) in matrices.outer_iter().zip(is_disc).zip(irradiance) {
            let columns = vectors("matrix", matrix.t())?;
            let matrix = DMat3::from_cols(columns[0], columns[1], columns[2]);
            let vertices = outline(&matrix, is_disc);
            let centre = (matrix * DVec3::new(0.5, 0.5, 1.0)).normalize_or_zero();
            let unit = polygon::vector_irradiance(&vertices).dot(centre);
            let radiance = if unit > 0.0 { irradiance / unit } else { DVec3::ZERO };
            self.outlines.push(Outline { vertices, radiance });
        }
        Ok(())
    }

    /// Add patches: (n, 3) centres, (n, 3) unit normals, (n,) areas, (n, 3) radiance.
    ///
    /// # Errors
    ///
    /// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NotUnit`], [`Error::LengthMismatch`].
    pub fn add_patches(
        &mut self,
        centres: ArrayView2<'_, f64>,
        normals: ArrayView2<'_, f64>,
        areas: ArrayView1<'_, f64>,
        radiance: ArrayView2<'_, f64>,
    ) -> Result<()> {
        let (centres, normals) = (vectors("position", centres)?, unit_vectors("normal", normals)?);
        let radiance = vectors("radiance", radiance)?;
        let lengths = [("normal", normals.len()), ("area", areas.len()), ("radiance", radiance.len())];
        check_lengths("position", centres.len(), lengths)?;
        let patches = centres.into_iter().zip(normals).zip(areas).zip(radiance);
        self.patches.extend(patches.map(|(((centre, normal), &area), radiance)| Patch {
            centre,
            normal,
            area,
            radiance,
        }));
        Ok(())
    }

    /// Irradiance, (p, n, 3), of `normals`, (n, 3), at each of the `points`, (p, 3).
    ///
    /// # Errors
    ///
    /// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NotUnit`].
    pub fn irradiance(
        &self,
        points: ArrayView2<'_, f64>,
        normals: ArrayView2<'_, f64>,
    ) -> Result<Array3<f64>> {
        check_rows("points", points, 3)?;
        let (points, normals) = (vectors("points", points)?, unit_vectors("normal", normals)?);
        let columns = [0, 1, 2].map(|axis| normals.iter().map(|normal| normal[axis]).collect::<Vec<_>>());
        let at = |&point: &DVec3| {
            interrupt::check();
            let view = self.seen_from(point);
            let mut sums = [(); 3].map(|()| vec![0.0; normals.len()]);
            Arch::new().dispatch(Sources { sources: &view.sources, normals: &columns, sums: &mut sums });
            view.add_lamps(&normals, &mut sums);
            sums
        };
        let min_len = interrupt::min_task_len(points.len());
        let sums: Vec<[Vec<f64>; 3]> = points.par_iter().with_min_len(min_len).map(at).collect();
        Ok(Array3::from_shape_fn((points.len(), normals.len(), 3), |(i, j, channel)| sums[i][channel][j]))
    }

    /// Lights as they appear from a point.
    fn seen_from(&self, point: DVec3) -> View {
        let discs = self.balls.iter().map(|ball| ball.seen_from(point));
        let outlines = self.outlines.iter().filter_map(|card| card.seen_from(point));
        let sources = self.patches.iter().map(|patch| patch.seen_from(point));
        View { discs: discs.collect(), outlines: outlines.collect(), sources: sources.collect() }
    }
}

impl Ball {
    /// Direction, irradiance and angular radius; a point inside sees a hemisphere.
    fn seen_from(&self, point: DVec3) -> (DVec3, DVec3, f64) {
        let to = self.centre - point;
        let distance = to.length().max(self.radius).max(f64::MIN_POSITIVE);
        let radius = (self.radius / distance).asin().min(FRAC_PI_2);
        (to.normalize_or(DVec3::Y), self.intensity / (distance * distance), radius)
    }
}

impl Outline {
    /// Vectors to the vertices, vector irradiance and radiance; none behind the plane.
    fn seen_from(&self, point: DVec3) -> Option<(Vec<DVec3>, DVec3, DVec3)> {
        let around: Vec<DVec3> = self.vertices.iter().map(|vertex| vertex - point).collect();
        let vector = polygon::vector_irradiance(&around);
        (vector.dot(around.iter().sum()) > 0.0).then_some((around, vector, self.radiance))
    }
}

impl Patch {
    /// Direction and irradiance.
    fn seen_from(&self, point: DVec3) -> (DVec3, DVec3) {
        let to = self.centre - point;
        let direction = to.normalize_or_zero();
        let cosine = (-direction.dot(self.normal)).max(0.0);
        (direction, self.radiance * (self.area * cosine / (to.length_squared() + self.area / PI)))
    }
}

/// Lights as one point sees them.
struct View {
    discs: Vec<(DVec3, DVec3, f64)>,
    outlines: Vec<(Vec<DVec3>, DVec3, DVec3)>,
    sources: Vec<(DVec3, DVec3)>,
}

impl View {
    /// Add the irradiance of balls and cards at each normal to the sums of red, green and blue.
    fn add_lamps(&self, normals: &[DVec3], sums: &mut [Vec<f64>; 3]) {
        for (row, &normal) in normals.iter().enumerate() {
            let discs = self.discs.iter().map(|(direction, irradiance, radius)| {
                irradiance * irradiance_share(normal.dot(*direction), *radius)
            });
            let outlines = self.outlines.iter();
            let cards = outlines
                .map(|(around, vector, radiance)| radiance * polygon::irradiance(around, *vector, normal));
            let received: DVec3 = discs.chain(cards).sum();
            for (sum, part) in sums.iter_mut().zip(received.to_array()) {
                sum[row] += part;
            }
        }
    }
}

/// Addition of the irradiance of point sources to the sums of red, green and blue at each normal.
struct Sources<'a> {
    sources: &'a [(DVec3, DVec3)],
    normals: &'a [Vec<f64>; 3],
    sums: &'a mut [Vec<f64>; 3],
}

impl WithSimd for Sources<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let [x, y, z] = self.normals.each_ref().map(Vec::as_slice);
        let [red, green, blue] = self.sums.each_mut().map(Vec::as_mut_slice);
        let count = x.len();
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

/// Corners of a card, or vertices of a polygon of the area of its ellipse.
fn outline(matrix: &DMat3, is_disc: bool) -> Vec<DVec3> {
    if !is_disc {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        return corners.map(|(a, b)| *matrix * DVec3::new(a, b, 1.0)).to_vec();
    }
    let step = TAU / VERTICES as f64;
    let radius = (FRAC_PI_4 / (0.5 * VERTICES as f64 * step.sin())).sqrt();
    let vertex = |i: usize| {
        let (sin, cos) = (step * i as f64).sin_cos();
        *matrix * DVec3::new(0.5 + radius * cos, 0.5 + radius * sin, 1.0)
    };
    (0..VERTICES).map(vertex).collect()
}
