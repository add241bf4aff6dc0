//! Convex regions of directions, and the cosine-weighted solid angle of their intersection.
//!
//! The cosine-weighted solid angle of a region of the sphere is half the integral of `n . (w x dw)` along its
//! border (Stokes), counterclockwise around the region. The border of an intersection of cones consists of arcs of
//! their circles. On the circle at the angle a around c, with `w = cos a c + sin a (cos p u + sin p v)`,
//!
//! ```text
//!   n . (w x dw) = [sin^2 a (n . c) - sin a cos a (n . u cos p + n . v sin p)] dp
//! ```

use std::f64::consts::TAU;

use glam::DVec3;

use super::arcs::Arcs;
use super::cone::{Circle, Cone};

/// Intersection of cones: a cap, a half-space, or a polygon of great arcs.
#[derive(Clone, Debug)]
pub struct ConvexRegion {
    /// Its border; nothing for the whole sphere.
    sides: Vec<Side>,
    /// Cone around it.
    pub bound: Cone,
}

/// Arc of the border of a region, which lies within the cone of the arc.
#[derive(Clone, Copy, Debug)]
pub struct Side {
    circle: Circle,
    /// First angle and length in radians.
    arc: (f64, f64),
    /// Directions of both ends, of any length; an arc of half a turn at most lies between them.
    ends: Option<[DVec3; 2]>,
}

impl ConvexRegion {
    /// All directions.
    pub const ALL: Self = Self { sides: Vec::new(), bound: Cone::ALL };

    /// Directions in a cone.
    pub fn cone(cone: Cone) -> Self {
        let side = Side { circle: Circle::of(cone), arc: (0.0, TAU), ends: None };
        Self { sides: vec![side], bound: cone }
    }

    /// Directions within a polygon, in a cone around it.
    pub const fn polygon(sides: Vec<Side>, bound: Cone) -> Self {
        Self { sides, bound }
    }

    /// False if no direction is in both regions; true in most other cases.
    #[inline]
    pub fn may_meet(&self, other: &Self) -> bool {
        let reaches = |one: &Self, bound: &Cone| one.sides.iter().all(|side| side.circle.cone.touches(bound));
        self.bound.touches(&other.bound) && reaches(self, &other.bound) && reaches(other, &self.bound)
    }

    pub fn contains(&self, direction: DVec3) -> bool {
        self.sides.iter().all(|side| side.circle.cone.contains(direction))
    }
}

impl Side {
    /// Great arc between two directions of any length, on the border of the half-space of `inside`.
    ///
    /// Nothing if their cross product is shorter than `least`: they are one direction.
    #[inline]
    pub fn between([a, b]: [DVec3; 2], inside: DVec3, least: f64) -> Option<Self> {
        let across = a.cross(b);
        let sine = across.length();
        if sine <= least {
            return None;
        }
        let length = sine.atan2(a.dot(b));
        let (axis, ends) = if across.dot(inside) < 0.0 { (-across, [b, a]) } else { (across, [a, b]) };
        let (axis, u) = (axis / sine, ends[0].normalize());
        let circle = Circle { cone: Cone::half_space(axis), u, v: axis.cross(u) };
        Some(Self { circle, arc: (0.0, length), ends: Some(ends) })
    }

    /// Keep the arcs that lie within one cone of another region.
    #[inline]
    fn keep_within(&self, arcs: &mut Arcs, other: &Cone, is_first: bool) {
        let heights = self.ends.map(|ends| ends.map(|end| end.dot(other.axis)));
        let is_certain = other.is_half_space() && !self.circle.cone.has_plane_of(other);
        match heights {
            Some([a, b]) if is_certain && a >= 0.0 && b >= 0.0 => {}
            Some([a, b]) if is_certain && a <= 0.0 && b <= 0.0 => arcs.clear(),
            _ => self.circle.keep_within(arcs, other, is_first),
        }
    }
}

/// Integral of the cosine to `normal` over the directions that are in all `regions`.
///
/// Directions below the horizon of `normal` count as negative: include its half-space if there may be some.
pub fn cosine_integral(normal: DVec3, regions: &[&ConvexRegion]) -> f64 {
    let mut arcs = Arcs::default();
    let mut sum = 0.0;
    for (index, region) in regions.iter().enumerate() {
        for side in &region.sides {
            arcs.reset(side.arc);
            keep_common(&mut arcs, side, index, regions);
            sum += arcs.iter().map(|arc| side.circle.integral(normal, arc)).sum::<f64>();
        }
    }
    sum / 2.0
}

/// Keep the arcs of a side of one region that lie within all others.
fn keep_common(arcs: &mut Arcs, side: &Side, index: usize, regions: &[&ConvexRegion]) {
    for (place, region) in regions.iter().enumerate().filter(|(place, _)| *place != index) {
        for other in &region.sides {
            side.keep_within(arcs, &other.circle.cone, index < place);
            if arcs.is_empty() {
                return;
            }
        }
    }
}
