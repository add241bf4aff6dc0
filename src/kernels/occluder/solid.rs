//! Balls and convex polyhedra, and the cones of directions in which a point sees them.

use glam::DVec3;

use super::cone::Cone;
use super::convex::{ConvexRegion, Side};
use crate::error::{Error, Result};

/// Distance from a plane, over the size of the solid, up to which a point lies in the plane.
const IN_PLANE: f64 = 1e-12;

/// A solid that hides light.
#[derive(Clone, Debug)]
pub enum Solid {
    /// A ball.
    Ball(Ball),
    /// A convex polyhedron, such as a box.
    Polyhedron(Polyhedron),
}

/// A ball.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    /// Centre.
    pub centre: DVec3,
    /// Radius.
    pub radius: f64,
}

/// A convex polyhedron.
#[derive(Clone, Debug)]
pub struct Polyhedron {
    centre: DVec3,
    size: f64,
    vertices: Vec<DVec3>,
    faces: Vec<Plane>,
    edges: Vec<SolidEdge>,
}

/// Plane of a face: outward normal and distance from the origin.
#[derive(Clone, Copy, Debug)]
struct Plane {
    normal: DVec3,
    distance: f64,
}

/// Edge between two vertices, and the two faces that it joins.
#[derive(Clone, Copy, Debug)]
struct SolidEdge {
    vertices: [usize; 2],
    faces: [usize; 2],
}

impl Solid {
    /// Directions in which `point` sees the solid.
    pub fn silhouette(&self, point: DVec3) -> ConvexRegion {
        match self {
            Self::Ball(ball) => ball.silhouette(point),
            Self::Polyhedron(polyhedron) => polyhedron.silhouette(point),
        }
    }

    /// Outward normal of the side that faces `point`: that of the closest point of the surface.
    pub fn facing(&self, point: DVec3) -> DVec3 {
        match self {
            Self::Ball(ball) => (point - ball.centre).try_normalize().unwrap_or(DVec3::Y),
            Self::Polyhedron(polyhedron) => polyhedron.facing(point),
        }
    }
}

impl Ball {
    fn silhouette(&self, point: DVec3) -> ConvexRegion {
        self.cone(point).map_or(ConvexRegion::ALL, ConvexRegion::cone)
    }

    /// Directions from `point` to the ball; none if it is inside.
    fn cone(&self, point: DVec3) -> Option<Cone> {
        let away = self.centre - point;
        let distance = away.length();
        if distance < self.radius * (1.0 - IN_PLANE) {
            return None;
        }
        let sin = (self.radius / distance).min(1.0);
        // The tangent length, without the cancellation of 1 - sin^2 near the surface.
        let cos = ((distance - self.radius).max(0.0) * (distance + self.radius)).sqrt() / distance;
        Some(Cone { axis: away / distance, angle: sin.atan2(cos), cos, sin })
    }
}

impl Polyhedron {
    /// Convex polyhedron of vertices and of loops of vertices, one for each face, in either orientation.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchSolid`] if a face is flat, an edge has not two faces, or a vertex lies outside of a face.
    pub fn new(vertices: Vec<DVec3>, loops: &[Vec<usize>]) -> Result<Self> {
        if vertices.len() < 4 || loops.iter().flatten().any(|&vertex| vertex >= vertices.len()) {
            return Err(Error::NoSuchSolid { what: "faces must hold rows of vertices, which are 4 or more" });
        }
        let centre = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
        let size = vertices.iter().map(|vertex| vertex.distance(centre)).fold(0.0, f64::max);
        let faces =
            loops.iter().map(|face| Plane::of(&vertices, face, centre)).collect::<Result<Vec<_>>>()?;
        let above = |plane: &Plane| vertices.iter().any(|&vertex| plane.height(vertex) > 1e-9 * size);
        if faces.iter().any(above) {
            return Err(Error::NoSuchSolid { what: "a polyhedron must be convex" });
        }
        let edges = edges_of(loops)?;
        Ok(Self { centre, size, vertices, faces, edges })
    }

    /// True if a ray meets the solid: the interval of its length within all faces is not empty.
    #[cfg(test)]
    pub fn is_hit(&self, point: DVec3, direction: DVec3) -> bool {
        let (mut near, mut far) = (0.0_f64, f64::INFINITY);
        for face in &self.faces {
            let (height, slope) = (face.height(point), face.normal.dot(direction));
            if slope < 0.0 {
                near = near.max(-height / slope);
            } else if slope > 0.0 {
                far = far.min(-height / slope);
            } else if height > 0.0 {
                return false;
            }
        }
        near < far
    }

    /// Vertices.
    #[cfg(test)]
    pub fn corners(&self) -> &[DVec3] {
        &self.vertices
    }

    fn silhouette(&self, point: DVec3) -> ConvexRegion {
        let is_front = |face: usize| self.faces[face].height(point) >= -IN_PLANE * self.size;
        let front: Vec<bool> = (0..self.faces.len()).map(is_front).collect();
        if !front.contains(&true) {
            return ConvexRegion::ALL;
        }
        let outline = self.edges.iter().filter(|edge| front[edge.faces[0]] != front[edge.faces[1]]);
        let mut sides = Vec::with_capacity(8);
        sides.extend(outline.filter_map(|edge| self.side(edge, point)));
        // Half-spaces of directions bound nothing; a ball around the solid does, from outside.
        let around = Ball { centre: self.centre, radius: self.size }.cone(point);
        ConvexRegion::polygon(sides, around.unwrap_or(Cone::ALL))
    }

    /// Edge as `point` sees it, with the centre of the solid inside.
    #[inline]
    fn side(&self, edge: &SolidEdge, point: DVec3) -> Option<Side> {
        let ends = edge.vertices.map(|vertex| self.vertices[vertex] - point);
        // A point on the line of the edge sees it as one direction, which other edges bound.
        let least = 1e-14 * self.size * ends[0].distance(ends[1]);
        Side::between(ends, self.centre - point, least)
    }

    fn facing(&self, point: DVec3) -> DVec3 {
        let closest = self.closest(point);
        (point - closest).try_normalize().unwrap_or_else(|| {
            let heights = self.faces.iter().map(|face| (face.height(point), face.normal));
            heights.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(DVec3::Y, |(_, normal)| normal)
        })
    }

    /// Point of the solid closest to `point`, by Dykstra's projections onto the half-spaces of the faces.
    fn closest(&self, point: DVec3) -> DVec3 {
        let mut found = point;
        let mut corrections = vec![DVec3::ZERO; self.faces.len()];
        for _ in 0..64 {
            let before = found;
            for (face, correction) in self.faces.iter().zip(&mut corrections) {
                let from = found + *correction;
                found = from - face.normal * face.height(from).max(0.0);
                *correction = from - found;
            }
            if found.distance(before) < IN_PLANE * self.size {
                break;
            }
        }
        found
    }
}

impl Plane {
    /// Plane of a loop of vertices, with the normal away from `centre`.
    fn of(vertices: &[DVec3], face: &[usize], centre: DVec3) -> Result<Self> {
        let first =
            vertices[*face.first().ok_or(Error::NoSuchSolid { what: "a face must have vertices" })?];
        let corners = face.windows(2).map(|pair| (vertices[pair[0]] - first, vertices[pair[1]] - first));
        let area: DVec3 = corners.map(|(a, b)| a.cross(b)).sum();
        let normal = area.try_normalize().ok_or(Error::NoSuchSolid { what: "a face must have an area" })?;
        let normal = if normal.dot(first - centre) < 0.0 { -normal } else { normal };
        Ok(Self { normal, distance: normal.dot(first) })
    }

    /// Height of a point above the plane.
    #[inline]
    fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.distance
    }
}

/// Edges of loops of vertices; each joins two faces.
fn edges_of(loops: &[Vec<usize>]) -> Result<Vec<SolidEdge>> {
    let mut sides = Vec::new();
    for (face, vertices) in loops.iter().enumerate() {
        for (place, &a) in vertices.iter().enumerate() {
            let b = vertices[(place + 1) % vertices.len()];
            sides.push(([a.min(b), a.max(b)], face));
        }
    }
    sides.sort_unstable();
    let pairs = sides.chunks(2).map(|pair| match pair {
        [(a, face), (b, other)] if a == b && face != other => {
            Ok(SolidEdge { vertices: *a, faces: [*face, *other] })
        }
        _ => Err(Error::NoSuchSolid { what: "each edge of a polyhedron must join two faces" }),
    });
    pairs.collect()
}
