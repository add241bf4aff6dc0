//! Circular cones of directions, and the part of a circle of directions that lies within one.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use super::arcs::Arcs;

/// Angle in radians below which two circles that touch do not cross. Both circles of a pair use it, so that neither has
/// an arc that the other does not close: that cost 2e-9 for a ball on a floor.
const TOUCH: f64 = 1e-12;
/// Sine from which on the comparison of sines is certain, so that both circles of a pair agree with `TOUCH`.
const CERTAIN: f64 = 1e-9;

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

/// Circle of a cone, with two tangents that span its plane: u at the angle 0, v at a quarter of a turn.
#[derive(Clone, Copy, Debug)]
pub struct Circle {
    pub cone: Cone,
    pub u: DVec3,
    pub v: DVec3,
}

impl Cone {
    /// All directions.
    pub const ALL: Self = Self { axis: DVec3::Y, angle: PI, cos: -1.0, sin: 0.0 };

    /// Directions `w` with `w . axis >= 0`.
    pub const fn half_space(axis: DVec3) -> Self {
        Self { axis, angle: FRAC_PI_2, cos: 0.0, sin: 1.0 }
    }

    /// Directions within `angle` of `axis`.
    pub fn of_angle(axis: DVec3, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { axis, angle, cos: cos.max(0.0), sin }
    }

    #[inline]
    pub fn contains(&self, direction: DVec3) -> bool {
        direction.dot(self.axis) >= self.cos
    }

    #[inline]
    pub fn is_half_space(&self) -> bool {
        self.cos == 0.0
    }

    /// True if the borders of two half-spaces are one plane.
    #[inline]
    pub fn has_plane_of(&self, other: &Self) -> bool {
        self.axis.cross(other.axis).length_squared() <= TOUCH * TOUCH
    }

    /// False if no direction is in both cones.
    #[inline]
    pub fn touches(&self, other: &Self) -> bool {
        // The cosine of the sum of the angles, unless that is more than 180 degrees.
        let is_wide = self.angle + other.angle >= PI;
        is_wide || self.axis.dot(other.axis) > self.cos * other.cos - self.sin * other.sin
    }
}

impl Circle {
    /// Circle of a cone, from any angle on.
    pub fn of(cone: Cone) -> Self {
        let u = cone.axis.any_orthonormal_vector();
        Self { cone, u, v: cone.axis.cross(u) }
    }

    /// Angle of the direction nearest to `towards`.
    #[inline]
    fn angle_of(&self, towards: DVec3) -> f64 {
        self.v.dot(towards).atan2(self.u.dot(towards))
    }

    /// Integral of `n . (w x dw)` along an arc.
    #[inline]
    pub fn integral(&self, normal: DVec3, (start, length): (f64, f64)) -> f64 {
        let Cone { axis, sin, cos, .. } = self.cone;
        let along = sin * sin * normal.dot(axis) * length;
        if self.cone.is_half_space() || length >= 2.0 * PI {
            return along;
        }
        // The difference of two sines at the ends, without its cancellation for a short arc.
        let (sin_middle, cos_middle) = (start + length / 2.0).sin_cos();
        let chord = 2.0 * (length / 2.0).sin();
        along - sin * cos * chord * (normal.dot(self.u) * cos_middle + normal.dot(self.v) * sin_middle)
    }

    /// Keep the arcs of the circle that lie within `other`.
    ///
    /// `is_first` decides between two equal cones, so that one of their circles counts.
    #[inline]
    pub fn keep_within(&self, arcs: &mut Arcs, other: &Cone, is_first: bool) {
        let cone = &self.cone;
        let cosine = cone.axis.dot(other.axis);
        match (cone.is_half_space(), other.is_half_space()) {
            (true, true) => self.keep_half(arcs, other, is_first),
            // A cap far from the border of a half-space.
            (false, true) if cosine > cone.sin + CERTAIN => {}
            (false, true) if cosine < -cone.sin - CERTAIN => arcs.clear(),
            (true, false) if cosine.abs() > other.sin + CERTAIN => arcs.clear(),
            _ => self.keep_cap(arcs, other, cosine, is_first),
        }
    }

    /// Keep the half of a great circle that lies within a half-space.
    fn keep_half(&self, arcs: &mut Arcs, other: &Cone, is_first: bool) {
        if !self.cone.has_plane_of(other) {
            // The other circle of the pair has the same point of crossing, with the other sign.
            arcs.intersect(self.angle_of(other.axis.cross(self.cone.axis)), PI);
        } else if !is_first || self.cone.axis.dot(other.axis) < 0.0 {
            arcs.clear();
        }
    }

    fn keep_cap(&self, arcs: &mut Arcs, other: &Cone, cosine: f64, is_first: bool) {
        let cone = &self.cone;
        let separation = cone.axis.cross(other.axis).length().atan2(cosine);
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
            arcs.intersect(self.angle_of(other.axis) - half, 2.0 * half);
        }
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
