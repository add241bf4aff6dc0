//! Share of the light of an ambient term and of discs that solids hide from surfaces.

use std::f64::consts::PI;

use glam::DVec3;
use ndarray::{Array2, Axis};
use rayon::prelude::*;

use super::cone::{Cone, cosine_integral};
use super::solid::{Silhouette, Solid};
use crate::interrupt;
use crate::kernels::disc::irradiance_share;

/// Radius in radians below which a disc is a point: the sun has 0.0046. The closed form divides by its solid
/// angle, so that smaller discs would have an error above 1e-7.
const LEAST_RADIUS: f64 = 1e-5;

/// Points of surfaces that receive light.
#[derive(Clone, Debug)]
pub struct Receivers {
    /// Positions.
    pub points: Vec<DVec3>,
    /// Unit normals.
    pub normals: Vec<DVec3>,
    /// Solid that each point is on; none for all others.
    pub own: Vec<Option<usize>>,
}

impl Receivers {
    /// Receiver in a row.
    pub fn place(&self, row: usize, solids: &[Solid]) -> Place {
        Place::new(self.points[row], self.normals[row], self.own[row], solids)
    }
}

/// An ambient term and discs.
#[derive(Clone, Debug)]
pub struct Sources {
    /// Towards the centre of each disc.
    pub directions: Vec<DVec3>,
    /// Angular radii in radians.
    pub radii: Vec<f64>,
    /// True if no light comes from below the horizon of the scene.
    pub has_floor: bool,
}

impl Sources {
    /// Irradiance of the ambient term at a normal with nothing in the way, over that of a whole sphere.
    pub fn open_ambient(&self, normal: DVec3) -> f64 {
        if self.has_floor { f64::midpoint(1.0, normal.y.clamp(-1.0, 1.0)) } else { 1.0 }
    }

    /// Irradiance of a disc at a normal with nothing in the way, over that at normal incidence.
    pub fn open(&self, light: usize, normal: DVec3) -> f64 {
        irradiance_share(normal.dot(self.directions[light]), self.radii[light])
    }
}

/// Hidden share of the ambient term and then of each disc at each receiver, (n, 1 + m).
///
/// A share is the hidden irradiance over that of the source at normal incidence, or over that of a whole sphere
/// for the ambient term.
pub fn hidden_shares(receivers: &Receivers, sources: &Sources, solids: &[Solid]) -> Array2<f64> {
    let columns = 1 + sources.directions.len();
    let mut shares = Array2::zeros((receivers.points.len(), columns));
    let min_len = interrupt::min_task_len(receivers.points.len());
    let rows = shares.axis_iter_mut(Axis(0)).into_par_iter().enumerate().with_min_len(min_len);
    rows.for_each(|(row, mut out)| {
        interrupt::check();
        let place = receivers.place(row, solids);
        out[0] = place.hidden_ambient(sources);
        for light in 0..columns - 1 {
            out[1 + light] = place.hidden_disc(sources, light);
        }
    });
    shares
}

/// A receiver, and the solids in front of it.
pub struct Place {
    normal: DVec3,
    /// Silhouette of each solid; none of that of the receiver, because a convex solid hides nothing from itself.
    silhouettes: Vec<Option<Silhouette>>,
}

impl Place {
    /// Receiver at a point, with a normal, and on a solid unless it is on the floor.
    pub fn new(point: DVec3, normal: DVec3, own: Option<usize>, solids: &[Solid]) -> Self {
        let others = solids.iter().enumerate();
        let seen = others.map(|(solid, one)| (Some(solid) != own).then(|| one.silhouette(point)));
        Self { normal, silhouettes: seen.collect() }
    }

    /// Hidden share of the ambient term.
    pub fn hidden_ambient(&self, sources: &Sources) -> f64 {
        let mut cones = vec![Cone::half_space(self.normal)];
        // On a floor, its horizon and that of the scene are one.
        if sources.has_floor && self.normal.y < 1.0 {
            cones.push(Cone::half_space(DVec3::Y));
        }
        let hidden = self.union_integral(&mut cones, 0) / PI;
        hidden.clamp(0.0, sources.open_ambient(self.normal))
    }

    /// Hidden share of one disc.
    pub fn hidden_disc(&self, sources: &Sources, light: usize) -> f64 {
        let (direction, radius) = (sources.directions[light], sources.radii[light]);
        let open = sources.open(light, self.normal);
        if open <= 0.0 {
            return 0.0;
        }
        if radius < LEAST_RADIUS {
            let is_hidden = self.silhouettes.iter().flatten().any(|one| one.contains(direction));
            return if is_hidden { open } else { 0.0 };
        }
        let cone = Cone::of_angle(direction, radius);
        let mut cones = vec![cone];
        // The horizon of the receiver cuts only discs that reach it.
        if self.normal.dot(direction) < cone.sin {
            cones.push(Cone::half_space(self.normal));
        }
        let hidden = self.union_integral(&mut cones, 0) / (PI * cone.sin * cone.sin);
        hidden.clamp(0.0, open)
    }

    /// Share of a Lambertian receiver's irradiance that would come from one solid of uniform radiance.
    pub fn form_factor(&self, solid: usize) -> f64 {
        let mut cones = vec![Cone::half_space(self.normal)];
        let integral = |silhouette: &Silhouette| silhouette.integral(self.normal, &mut cones);
        (self.silhouettes[solid].as_ref().map_or(0.0, integral) / PI).clamp(0.0, 1.0)
    }

    /// Integral over the directions in `cones` and in any solid from `first` on, by inclusion and exclusion.
    fn union_integral(&self, cones: &mut Vec<Cone>, first: usize) -> f64 {
        let mut sum = 0.0;
        for (solid, silhouette) in self.silhouettes.iter().enumerate().skip(first) {
            let Some(silhouette) = silhouette else { continue };
            let before = cones.len();
            let alone = silhouette.integral(self.normal, cones);
            if alone != 0.0 {
                sum += alone - self.union_integral(cones, solid + 1);
            }
            cones.truncate(before);
        }
        sum
    }
}

impl Silhouette {
    /// True if a direction meets the solid.
    pub fn contains(&self, direction: DVec3) -> bool {
        match self {
            Self::All => true,
            Self::Cones(cones, _) => cones.iter().all(|cone| cone.contains(direction)),
        }
    }

    /// Integral over the directions in `cones` and in the silhouette, whose cones are added to them.
    fn integral(&self, normal: DVec3, cones: &mut Vec<Cone>) -> f64 {
        if let Self::Cones(own, bound) = self {
            if cones.iter().any(|known| !bound.touches(known)) {
                return 0.0;
            }
            cones.extend(own);
        }
        cosine_integral(normal, cones)
    }
}
