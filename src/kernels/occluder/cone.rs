//! Directions within a set of circular cones, and their cosine-weighted solid angle.
//!
//! The cosine-weighted solid angle of a region of the sphere is half the integral of `n . (w x dw)` along its
//! border (Stokes), counterclockwise around the region. The border of an intersection of cones consists of arcs of
//! their circles. On the circle at the angle a around c, with `w = cos a c + sin a (cos p u + sin p v)`,
//!
//! ```text
//!   n . (w x dw) = [sin^2 a (n . c) - sin a cos a (n . u cos p + n . v sin p)] dp
//! ```

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;

use super::arcs::Arcs;

/// Angle in radians below which two circles that touch do not cross. Both circles of a pair use it, so that neither has
/// an arc that the other does not close: that cost 2e-9 for a ball on a floor.
const TOUCH: f64 = 1e-12;

/// Directions within an angle of at most 90 degrees around an axis; a half-space of directions at 90 degrees.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    pub axis: DVec3,
    /// Angle in radians.
    pub angle: f64,
    /// Its cosine and sine.
    pub cos: f64,
    pub sin: f64,
}

impl Cone {
    /// Directions `w` with `w . axis >= 0`.
    pub const fn half_space(axis: DVec3) -> Self {
        Self { axis, angle: FRAC_PI_2, cos: 0.0, sin: 1.0 }
    }

    /// Directions within `angle` of `axis`.
    pub fn of_angle(axis: DVec3, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { axis, angle, cos: cos.max(0.0), sin }
    }

    pub fn contains(&self, direction: DVec3) -> bool {
        direction.dot(self.axis) >= self.cos
    }

    /// False if no direction is in both cones.
    pub fn touches(&self, other: &Self) -> bool {
        // The cosine of the sum of the angles, unless that is more than 180 degrees.
        let is_wide = self.angle + other.angle >= PI;
        is_wide || self.axis.dot(other.axis) > self.cos * other.cos - self.sin * other.sin
    }
}

/// Integral of the cosine to `normal` over the directions that are in all `cones`.
///
/// Directions below the horizon of `normal` count as negative: include its half-space if there may be some.
pub fn cosine_integral(normal: DVec3, cones: &[Cone]) -> f64 {
    let border = |index: usize| border_integral(normal, cones, index);
    (0..cones.len()).map(border).sum::<f64>() / 2.0
}

/// Integral along the part of the circle of one cone that lies in all others.
fn border_integral(normal: DVec3, cones: &[Cone], index: usize) -> f64 {
    let cone = &cones[index];
    let u = cone.axis.any_orthonormal_vector();
    let v = cone.axis.cross(u);
    let mut arcs = Arcs::whole();
    for (place, other) in cones.iter().enumerate().filter(|(place, _)| *place != index) {
        keep_within(&mut arcs, cone, (u, v), other, index < place);
        if arcs.is_empty() {
            return 0.0;
        }
    }
    let (along, across) = (cone.sin * cone.sin * normal.dot(cone.axis), cone.sin * cone.cos);
    let integral = |(start, length): (f64, f64)| {
        // The difference of two sines at the ends, without its cancellation for a short arc.
        let (sin, cos) = (start + length / 2.0).sin_cos();
        let chord = if length < TAU { 2.0 * (length / 2.0).sin() } else { 0.0 };
        along * length - across * chord * (normal.dot(u) * cos + normal.dot(v) * sin)
    };
    arcs.iter().map(integral).sum()
}

/// Keep the arcs of the circle of `cone`, with the tangents u and v, that lie within `other`.
///
/// `is_first` decides between two equal cones, so that one of their circles counts.
fn keep_within(arcs: &mut Arcs, cone: &Cone, (u, v): (DVec3, DVec3), other: &Cone, is_first: bool) {
    let separation = cone.axis.cross(other.axis).length().atan2(cone.axis.dot(other.axis));
    let wider = other.angle - cone.angle;
    let is_inside = wider > 0.0 || (wider == 0.0 && is_first);
    if separation <= wider.abs() + TOUCH {
        if !is_inside {
            arcs.clear();
        }
    } else if separation >= cone.angle + other.angle - TOUCH {
        arcs.clear();
    } else {
        let half = crossing_angle(cone.angle, other.angle, separation);
        let towards = v.dot(other.axis).atan2(u.dot(other.axis));
        arcs.intersect(towards - half, 2.0 * half);
    }
}

/// Angle at the first axis between the other axis and a point where two circles cross.
///
/// The half-angle formula of the spherical triangle of both axes and the point keeps its digits where they touch.
fn crossing_angle(angle: f64, other: f64, separation: f64) -> f64 {
    let beyond =
        f64::midpoint(angle, other - separation).sin() * f64::midpoint(separation, other - angle).sin();
    let within =
        f64::midpoint(angle, other + separation).sin() * f64::midpoint(angle, separation - other).sin();
    2.0 * beyond.max(0.0).sqrt().atan2(within.max(0.0).sqrt())
}
