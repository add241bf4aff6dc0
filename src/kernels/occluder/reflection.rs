//! Irradiance of solids on a floor: with shadows, and with the light that floor and solids reflect to each other.
//!
//! The light of one reflection has no closed form. The model takes each solid as seen from a floor point x by the
//! side that faces x, with the normal m: it receives the open light at m and, for the share `b = (1 - m_y) / 2`,
//! the floor at x. With the form factor F and the albedo r of each solid and the albedo f of the floor,
//!
//! ```text
//!   E(x) = (e(x) + sum F r E_open(m)) / (1 - sum F r b f)
//! ```
//!
//! sums all reflections between x and the sides near it. A surface of a solid sees the floor at one point.

use std::f64::consts::PI;

use glam::DVec3;
use ndarray::Array2;
use rayon::prelude::*;

use super::occlusion::{Place, Receivers, Sources};
use super::solid::Solid;
use crate::interrupt;
use crate::kernels::sphere::from_vectors;

/// Tilt of the ray that finds the floor point of a surface: the tangent of its least angle below the horizon.
/// Values of 0.2 and 1.02 raise the error of path-traced images by up to 0.4 points.
const TILT: f64 = 0.45;
/// Least radius in radians of the discs that light this point, for a mean over the floor around it. Without it, a hard
/// edge of a shadow is seen on walls.
const BLUR: f64 = 0.35;

/// Least fraction of light that is lost in one reflection between floor and solids. Without it, white surfaces in
/// contact divide by 0.
const LEAST_LOSS: f64 = 1e-9;

/// Radiances and reflectances of a scene.
#[derive(Clone, Debug)]
pub struct Surroundings {
    /// Radiance of the ambient term.
    pub ambient: DVec3,
    /// Irradiance of each disc at normal incidence.
    pub irradiance: Vec<DVec3>,
    /// Albedo of each solid.
    pub albedo: Vec<DVec3>,
    /// Albedo of the floor; black without a floor.
    pub floor_albedo: DVec3,
}

/// Irradiance at each receiver, (n, 3), with shadows and reflected light.
pub fn received_irradiance(
    receivers: &Receivers,
    sources: &Sources,
    solids: &[Solid],
    surroundings: &Surroundings,
) -> Array2<f64> {
    let model = Model { sources, blurred: sources.with_least_radius(BLUR), solids, surroundings };
    let min_len = interrupt::min_task_len(receivers.points.len());
    let rows = (0..receivers.points.len()).into_par_iter().with_min_len(min_len);
    let values: Vec<DVec3> = rows
        .map(|row| {
            interrupt::check();
            match receivers.own[row] {
                None => model.on_floor(receivers.points[row], receivers.normals[row], sources),
                Some(_) => model.on_solid(receivers, row),
            }
        })
        .collect();
    from_vectors(values.into_iter())
}

/// Scene in which light is reflected.
struct Model<'a> {
    sources: &'a Sources,
    /// Sources with discs of at least the radius `BLUR`.
    blurred: Sources,
    solids: &'a [Solid],
    surroundings: &'a Surroundings,
}

impl Model<'_> {
    /// Irradiance with nothing in the way.
    fn open(&self, normal: DVec3) -> DVec3 {
        let ambient = PI * self.surroundings.ambient * self.sources.open_ambient(normal);
        let lights = self.surroundings.irradiance.iter().enumerate();
        lights.fold(ambient, |sum, (light, irradiance)| sum + irradiance * self.sources.open(light, normal))
    }

    /// Direct irradiance that is not hidden.
    fn direct(&self, place: &Place, sources: &Sources, normal: DVec3) -> DVec3 {
        let share = sources.open_ambient(normal) - place.hidden_ambient(sources);
        let ambient = PI * self.surroundings.ambient * share;
        let lights = self.surroundings.irradiance.iter().enumerate();
        lights.fold(ambient, |sum, (light, irradiance)| {
            sum + irradiance * (sources.open(light, normal) - place.hidden_disc(sources, light))
        })
    }

    /// Share of the floor in the irradiance of a surface with nothing in the way.
    fn floor_share(&self, normal: DVec3) -> f64 {
        if self.sources.has_floor { f64::midpoint(1.0, -normal.y) } else { 0.0 }
    }

    /// Irradiance of a point of the floor.
    fn on_floor(&self, point: DVec3, normal: DVec3, sources: &Sources) -> DVec3 {
        let place = Place::new(point, normal, None, self.solids);
        let (mut sum, mut back) = (self.direct(&place, sources, normal), DVec3::ZERO);
        for (solid, albedo) in self.surroundings.albedo.iter().enumerate() {
            let reflected = place.form_factor(solid) * albedo;
            let side = self.solids[solid].facing(point);
            sum += reflected * self.open(side);
            back += reflected * self.floor_share(side) * self.surroundings.floor_albedo;
        }
        // Between two white surfaces in contact, light would be reflected forever.
        sum / (DVec3::ONE - back).max(DVec3::splat(LEAST_LOSS))
    }

    /// Irradiance of a point of a solid.
    fn on_solid(&self, receivers: &Receivers, row: usize) -> DVec3 {
        let (point, normal) = (receivers.points[row], receivers.normals[row]);
        let place = receivers.place(row, self.solids);
        let mut sum = self.direct(&place, self.sources, normal);
        let mut hidden = 0.0;
        for (solid, albedo) in self.surroundings.albedo.iter().enumerate() {
            let factor = place.form_factor(solid);
            let side = self.solids[solid].facing(point);
            let from_floor = self.floor_share(side) * self.surroundings.floor_albedo * self.open(DVec3::Y);
            sum += factor * albedo * (self.open(side) + from_floor);
            hidden += factor;
        }
        sum + (1.0 - hidden).max(0.0) * self.light_of_floor(point, normal)
    }

    /// Irradiance that the floor reflects to a surface, taken at one point of the floor.
    fn light_of_floor(&self, point: DVec3, normal: DVec3) -> DVec3 {
        let share = self.floor_share(normal);
        if share <= 0.0 {
            return DVec3::ZERO;
        }
        let down = normal - DVec3::Y * (normal.y.max(0.0) + TILT);
        let hit = point - down * (point.y / down.y);
        share * self.surroundings.floor_albedo * self.on_floor(hit.with_y(0.0), DVec3::Y, &self.blurred)
    }
}
