//! Directions around an axis on a circle: angular map, mirror ball, fisheye lenses.
//!
//! The radius rho in the picture, in units of the focal length, depends on the angle theta from the axis alone. The
//! solid angle of a part of the picture is an integral along its edge, by Green's theorem:
//!
//! ```text
//!   omega = integral of (1 - cos theta) dphi
//!         = integral of q (a db - b da),   q = (1 - cos theta) / rho^2   along a straight edge
//!         = (1 - cos reach) * angle                                      along the circle
//! ```
//!
//! Neighbours share edges, so all pixels sum to the solid angle of the circle.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::interface::{NO_PIXEL, PictureNumbers, SphereProjection, check};
use super::places::{gauss_legendre, pixel_by_pixel};
use crate::error::{Error, Result};
use crate::interrupt;

/// Radius in the picture as a function of the angle theta from the axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AzimuthalMapping {
    /// rho = theta: angular map, many fisheye lenses.
    Equidistant,
    /// rho = 2 sin(theta / 2): mirror ball seen from afar.
    Equisolid,
    /// rho = 2 tan(theta / 2).
    Stereographic,
    /// rho = sin theta.
    Orthographic,
}

impl AzimuthalMapping {
    /// Mapping by its name, and its largest reach.
    fn of(name: &str) -> Result<(Self, f64)> {
        match name {
            "equidistant" => Ok((Self::Equidistant, PI)),
            "equisolid" => Ok((Self::Equisolid, PI)),
            "stereographic" => Ok((Self::Stereographic, 0.999 * PI)),
            "orthographic" => Ok((Self::Orthographic, 0.5 * PI)),
            _ => Err(Error::NoSuchLayout { what: "the mapping of a circle is not known" }),
        }
    }

    fn radius(self, theta: f64) -> f64 {
        match self {
            Self::Equidistant => theta,
            Self::Equisolid => 2.0 * (0.5 * theta).sin(),
            Self::Stereographic => 2.0 * (0.5 * theta).tan(),
            Self::Orthographic => theta.sin(),
        }
    }

    /// Ratio of the radius to the sine of theta, from sine and cosine.
    #[inline(always)]
    fn radius_over_sine(self, sine: f64, cosine: f64) -> f64 {
        match self {
            Self::Equidistant if sine < 1e-9 && cosine > 0.0 => 1.0,
            Self::Equidistant => sine.atan2(cosine) / sine,
            // Half angles without cancellation: 2 cos^2(theta / 2) = 1 + cos theta, 2 sin^2(theta / 2) = 1 - cos theta.
            Self::Equisolid if cosine < 0.0 => (2.0 * (1.0 - cosine)).sqrt() / sine,
            Self::Equisolid => (2.0 / (1.0 + cosine)).sqrt(),
            Self::Stereographic if cosine < 0.0 => 2.0 * (1.0 - cosine) / (sine * sine),
            Self::Stereographic => 2.0 / (1.0 + cosine),
            Self::Orthographic => 1.0,
        }
    }

    fn theta(self, radius: f64) -> f64 {
        match self {
            Self::Equidistant => radius,
            Self::Equisolid => 2.0 * (0.5 * radius).min(1.0).asin(),
            Self::Stereographic => 2.0 * (0.5 * radius).atan(),
            Self::Orthographic => radius.min(1.0).asin(),
        }
    }

    /// (1 - cos theta) / rho^2 from the square of rho.
    fn q(self, square: f64) -> f64 {
        match self {
            Self::Equidistant if square < 1e-3 => {
                0.5 - square / 24.0 + square * square / 720.0 - square.powi(3) / 40_320.0
            }
            Self::Equidistant => (1.0 - square.sqrt().cos()) / square,
            Self::Equisolid => 0.5,
            Self::Stereographic => 2.0 / (4.0 + square),
            Self::Orthographic => 1.0 / (1.0 + (1.0 - square).max(0.0).sqrt()),
        }
    }

    /// Solid angle for each unit of area at a radius.
    fn density(self, radius: f64) -> f64 {
        match self {
            Self::Equidistant if radius < 1e-6 => 1.0,
            Self::Equidistant => radius.sin().abs() / radius,
            Self::Equisolid => 1.0,
            Self::Stereographic => (1.0 + 0.25 * radius * radius).powi(-2),
            Self::Orthographic => 1.0 / (1.0 - radius * radius).max(1e-12).sqrt(),
        }
    }
}

/// Circle of directions around an axis.
pub struct AzimuthalCircle {
    size: [usize; 2],
    mapping: AzimuthalMapping,
    /// Angle from the axis at the circle.
    reach: f64,
    /// Cosine of the reach, less rounding.
    least_cosine: f64,
    centre: DVec2,
    /// Radius of the circle in pixels.
    circle: f64,
    /// Pixels for each unit of the mapping's radius.
    scale: f64,
    angles: Vec<f64>,
}

impl AzimuthalCircle {
    /// Layout of a picture, or a refusal of numbers that it cannot have.
    pub(super) fn of(picture: &PictureNumbers) -> Result<Self> {
        let (mapping, most) = AzimuthalMapping::of(&picture.mapping)?;
        let reach = picture.reach;
        check(reach > 0.0 && reach <= most, "the reach of a circle is beyond its mapping")?;
        let [half_height, half_width] = picture.size.map(|pixels| 0.5 * pixels as f64);
        let (x, y, radius) = picture.circle.unwrap_or((half_width, half_height, half_height.min(half_width)));
        let is_finite = x.is_finite() && y.is_finite() && radius.is_finite();
        check(is_finite && radius > 0.0, "the circle needs a centre and a radius above 0")?;
        Ok(Self::new(picture.size, mapping, reach, (DVec2::new(x, y), radius)))
    }

    /// Circle with its centre and radius in pixels.
    pub fn new(
        size: [usize; 2],
        mapping: AzimuthalMapping,
        reach: f64,
        (centre, circle): (DVec2, f64),
    ) -> Self {
        let scale = circle / mapping.radius(reach);
        let least_cosine = reach.cos() - 1e-12;
        let angles = Vec::new();
        let layout = Self { size, mapping, reach, least_cosine, centre, circle, scale, angles };
        Self { angles: layout.solid_angles(), ..layout }
    }

    /// Place in units of the mapping, y up.
    fn on_plane(&self, x: f64, y: f64) -> DVec2 {
        DVec2::new(x - self.centre.x, self.centre.y - y) / self.scale
    }

    fn solid_angles(&self) -> Vec<f64> {
        let [height, width] = self.size;
        let (mut angles, radius) = (vec![0.0; height * width], self.circle / self.scale);
        let columns: Vec<f64> = (0..=width).map(|x| self.on_plane(x as f64, 0.0).x).collect();
        // The root at the rim of an orthographic picture, and large pixels, take more nodes.
        let is_smooth = self.mapping != AzimuthalMapping::Orthographic && self.scale > 20.0;
        let rule = gauss_legendre(if is_smooth { 4 } else { 16 });
        angles.par_chunks_mut(width).enumerate().for_each(|(row, line)| {
            interrupt::check();
            let (top, bottom) = (self.on_plane(0.0, row as f64).y, self.on_plane(0.0, row as f64 + 1.0).y);
            let along = |at: f64, from: f64, to: f64| at * self.edge(&rule, at, from, to, radius);
            let mut left = along(columns[0], bottom, top);
            for (angle, edges) in line.iter_mut().zip(columns.windows(2)) {
                let right = along(edges[1], bottom, top);
                *angle = along(top, edges[0], edges[1]) - along(bottom, edges[0], edges[1]) + right - left;
                left = right;
            }
        });
        let share = 1.0 - self.reach.cos();
        for (pixel, arc) in self.arcs() {
            angles[pixel] += share * arc;
        }
        for angle in &mut angles {
            *angle = angle.max(0.0);
        }
        angles
    }

    /// Integral of q along the part of a straight edge that lies in the circle.
    fn edge(&self, rule: &[(f64, f64)], at: f64, from: f64, to: f64, radius: f64) -> f64 {
        let half = (radius * radius - at * at).max(0.0).sqrt();
        let (from, to) = (from.clamp(-half, half), to.clamp(-half, half));
        let length = to - from;
        if length <= 0.0 {
            return 0.0;
        }
        let value = |&(place, weight): &(f64, f64)| {
            let along = from + place * length;
            weight * self.mapping.q(along * along + at * at)
        };
        length * rule.iter().map(value).sum::<f64>()
    }

    /// Angle of the circle in each pixel that it crosses.
    fn arcs(&self) -> Vec<(usize, f64)> {
        let [height, width] = self.size;
        // Cut the circle where it crosses lines between pixels.
        let mut cuts = vec![-PI, PI];
        for x in 0..=width {
            let cosine = (x as f64 - self.centre.x) / self.circle;
            if cosine.abs() < 1.0 {
                cuts.extend([cosine.acos(), -cosine.acos()]);
            }
        }
        for y in 0..=height {
            let sine = (self.centre.y - y as f64) / self.circle;
            if sine.abs() < 1.0 {
                let angle = sine.asin();
                cuts.extend([angle, if angle > 0.0 { PI - angle } else { -PI - angle }]);
            }
        }
        cuts.sort_unstable_by(f64::total_cmp);
        // Attribute each piece to the pixel of its middle, which may touch the border of the picture from inside.
        let inwards = self.circle * (1.0 - 1e-12);
        let pieces = cuts.windows(2).filter_map(|cut| {
            let (sine, cosine) = (0.5 * (cut[0] + cut[1])).sin_cos();
            let (x, y) = (self.centre.x + inwards * cosine, self.centre.y - inwards * sine);
            let is_inside = x >= 0.0 && y >= 0.0 && x < width as f64 && y < height as f64;
            is_inside.then(|| (y as usize * width + x as usize, cut[1] - cut[0]))
        });
        pieces.collect()
    }
}

impl SphereProjection for AzimuthalCircle {
    fn size(&self) -> [usize; 2] {
        self.size
    }

    fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        let place = self.on_plane(x, y);
        let radius = place.length();
        if radius * self.scale > self.circle * (1.0 + 1e-12) {
            return None;
        }
        let theta = self.mapping.theta(radius);
        let along = if radius > 0.0 { theta.sin() / radius } else { 1.0 };
        Some(DVec3::new(-along * place.x, along * place.y, theta.cos()))
    }

    #[inline(always)]
    fn place(&self, direction: DVec3) -> Option<DVec2> {
        let DVec3 { x, y, z } = direction;
        if z < self.least_cosine {
            return None;
        }
        let sine = (x * x + y * y).sqrt();
        // The direction behind is the whole circle: choose its right end.
        let is_behind = sine == 0.0 && z < 0.0;
        let scale = self.scale * self.mapping.radius_over_sine(sine, z);
        let offset = if is_behind { DVec2::new(self.circle, 0.0) } else { -scale * DVec2::new(x, y) };
        Some(self.centre + offset)
    }

    fn density(&self, x: f64, y: f64) -> f64 {
        self.mapping.density(self.on_plane(x, y).length()) / (self.scale * self.scale)
    }

    fn solid_angle(&self, pixel: usize) -> f64 {
        self.angles[pixel]
    }

    fn is_whole(&self) -> bool {
        let [height, width] = self.size.map(|pixels| pixels as f64);
        let DVec2 { x, y } = self.centre;
        let room = x.min(width - x).min(y).min(height - y);
        self.reach >= PI && room >= self.circle * (1.0 - 1e-12)
    }

    #[inline(always)]
    fn pixel(&self, direction: [f64; 3]) -> u32 {
        let [height, width] = self.size;
        let direction = DVec3::from_array(direction);
        self.place(direction / direction.length()).map_or(NO_PIXEL, |place| {
            let is_inside =
                place.x >= 0.0 && place.y >= 0.0 && place.x <= width as f64 && place.y <= height as f64;
            let (row, column) = ((place.y as usize).min(height - 1), (place.x as usize).min(width - 1));
            if is_inside { (row * width + column) as u32 } else { NO_PIXEL }
        })
    }

    pixel_by_pixel!();
}
