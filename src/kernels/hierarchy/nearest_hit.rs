//! Nearest triangle that each of many rays hits.

use glam::{DVec2, DVec3};
use ndarray::ArrayView2;
use rayon::prelude::*;

use super::nodes::{AxisBox, BoxNode, box_nodes};
use crate::error::Result;
use crate::interrupt;
use crate::kernels::sphere::{check_lengths, vectors};

/// Enlargement of boxes relative to the scene, far above the rounding of rays.
const MARGIN: f64 = 1e-6;
/// Rays of a task.
const RAYS: usize = 1024;

/// A triangle, with edges from its first corner.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    corner: DVec3,
    edges: [DVec3; 2],
    /// Row in the array that was given.
    row: u32,
}

/// Point at which a ray hits a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Row of the triangle.
    pub row: u32,
    /// Weights of the second and third corner.
    pub weights: DVec2,
    /// True if the corners are counter-clockwise as seen along the ray's way.
    pub is_front: bool,
    length: f64,
}

/// Triangles with a bounding volume hierarchy.
#[derive(Clone, Debug)]
pub struct TriangleTree {
    nodes: Vec<BoxNode>,
    /// Triangles, leaf by leaf.
    triangles: Vec<Triangle>,
}

impl TriangleTree {
    /// Tree of triangles, whose corners are three rows each.
    ///
    /// # Errors
    ///
    /// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NoSuchSolid`] without a triangle or with more than 2^27,
    /// [`Error::LengthMismatch`] for a number of rows that is no multiple of three.
    pub fn new(corners: ArrayView2<'_, f64>) -> Result<Self> {
        let corners = vectors("corners", corners)?;
        let count = corners.len() / 3;
        check_lengths("three corners of a triangle", 3 * count, [("corners", corners.len())])?;
        let scene = AxisBox::around(corners.iter().copied());
        let margin = MARGIN * (scene.upper - scene.lower).max_element();
        let boxes = corners.chunks_exact(3).map(|corners| {
            let AxisBox { lower, upper } = AxisBox::around(corners.iter().copied());
            AxisBox { lower: lower - margin, upper: upper + margin }
        });
        let (nodes, order) = box_nodes(boxes)?;
        let triangle = |&row: &u32| {
            let [a, b, c] = [0, 1, 2].map(|k| corners[3 * row as usize + k]);
            Triangle { corner: a, edges: [b - a, c - a], row }
        };
        Ok(Self { nodes, triangles: order.iter().map(triangle).collect() })
    }

    /// Nearest hit of each ray, in front of its origin.
    ///
    /// # Errors
    ///
    /// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::LengthMismatch`].
    pub fn nearest_hits(
        &self,
        origins: ArrayView2<'_, f64>,
        directions: ArrayView2<'_, f64>,
    ) -> Result<Vec<Option<TriangleHit>>> {
        let (origins, directions) = (vectors("origins", origins)?, vectors("directions", directions)?);
        check_lengths("origins", origins.len(), [("directions", directions.len())])?;
        let mut hits = vec![None; origins.len()];
        let rays = origins.par_chunks(RAYS).zip(directions.par_chunks(RAYS));
        hits.par_chunks_mut(RAYS).zip(rays).for_each(|(hits, (origins, directions))| {
            interrupt::check();
            for ((hit, &origin), &direction) in hits.iter_mut().zip(origins).zip(directions) {
                *hit = self.nearest(origin, direction);
            }
        });
        Ok(hits)
    }

    /// Nearest hit of one ray; of equally near ones, that with the first row.
    fn nearest(&self, origin: DVec3, direction: DVec3) -> Option<TriangleHit> {
        // Divide by no zero: the product with a zero distance would not be a number.
        let inverse = DVec3::from(direction.to_array().map(|x| if x == 0.0 { 1e300 } else { 1.0 / x }));
        let (mut best, mut node) = (None::<TriangleHit>, 0);
        while let Some(next) = self.nodes.get(node) {
            let AxisBox { lower, upper } = next.bounds;
            let (near, far) = ((lower - origin) * inverse, (upper - origin) * inverse);
            let (entry, exit) = (near.min(far).max_element(), near.max(far).min_element());
            let meets = entry <= exit && exit >= 0.0 && best.is_none_or(|hit| entry <= hit.length);
            let leaf = next.leaf();
            node = if meets || leaf.is_some() { node + 1 } else { next.link as usize };
            for triangle in &self.triangles[leaf.filter(|_| meets).unwrap_or_default()] {
                let Some(hit) = triangle.hit(origin, direction) else { continue };
                let is_nearer =
                    |old: TriangleHit| hit.length.total_cmp(&old.length).then(hit.row.cmp(&old.row)).is_lt();
                if best.is_none_or(is_nearer) {
                    best = Some(hit);
                }
            }
        }
        best
    }
}

impl Triangle {
    /// Hit of a ray (Möller and Trumbore 1997).
    fn hit(&self, origin: DVec3, direction: DVec3) -> Option<TriangleHit> {
        let [one, two] = self.edges;
        let away = origin - self.corner;
        let (p, q) = (direction.cross(two), away.cross(one));
        let determinant = one.dot(p);
        let [u, v, length] = [away.dot(p), direction.dot(q), two.dot(q)].map(|x| x / determinant);
        let is_inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && length > 0.0 && length.is_finite();
        is_inside.then_some(TriangleHit {
            row: self.row,
            weights: DVec2::new(u, v),
            is_front: determinant > 0.0,
            length,
        })
    }
}
