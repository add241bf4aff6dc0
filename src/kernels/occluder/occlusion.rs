//! Share of the light of an ambient term and of discs that solids hide from surfaces.

use std::f64::consts::PI;

use glam::DVec3;
use ndarray::{Array2, Axis};
use rayon::prelude::*;

use super::cone::Cone;
use super::convex::{ConvexRegion, cosine_integral};
use super::solid::Solid;
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

    /// Values of each receiver, one for each column.
    fn table(
        &self,
        solids: &[Solid],
        columns: usize,
        value: impl Fn(&Place, usize) -> f64 + Sync,
    ) -> Array2<f64> {
        let mut values = Array2::zeros((self.points.len(), columns));
        let min_len = interrupt::min_task_len(self.points.len());
        let rows = values.axis_iter_mut(Axis(0)).into_par_iter().enumerate().with_min_len(min_len);
        rows.for_each(|(row, mut out)| {
            interrupt::check();
            let place = self.place(row, solids);
            for (column, value_at) in out.iter_mut().enumerate() {
                *value_at = value(&place, column);
            }
        });
        values
    }
}

/// An ambient term and discs.
#[derive(Clone, Debug)]
pub struct Sources {
    /// Directions of each disc.
    discs: Vec<ConvexRegion>,
    /// Directions above the horizon of the scene.
    sky: ConvexRegion,
    /// True if no light comes from below the horizon of the scene.
    pub has_floor: bool,
}

impl Sources {
    /// Ambient term, over a floor or all around, and discs of unit directions and of radii in radians.
    pub fn new(directions: &[DVec3], radii: &[f64], has_floor: bool) -> Self {
        let discs = directions.iter().zip(radii);
        let discs = discs.map(|(&axis, &radius)| ConvexRegion::cone(Cone::of_angle(axis, radius)));
        let sky = ConvexRegion::cone(Cone::half_space(DVec3::Y));
        Self { discs: discs.collect(), sky, has_floor }
    }

    /// Sources whose discs have at least the radius `least`.
    #[must_use]
    pub fn with_least_radius(&self, least: f64) -> Self {
        let cones = self.discs.iter().map(|disc| disc.bound);
        let (axes, radii): (Vec<_>, Vec<_>) = cones.map(|cone| (cone.axis, cone.angle.max(least))).unzip();
        Self::new(&axes, &radii, self.has_floor)
    }

    /// Number of discs.
    pub const fn discs(&self) -> usize {
        self.discs.len()
    }

    /// Irradiance of the ambient term at a normal with nothing in the way, over that of a whole sphere.
    pub fn open_ambient(&self, normal: DVec3) -> f64 {
        if self.has_floor { f64::midpoint(1.0, normal.y.clamp(-1.0, 1.0)) } else { 1.0 }
    }

    /// Irradiance of a disc at a normal with nothing in the way, over that at normal incidence.
    pub fn open(&self, light: usize, normal: DVec3) -> f64 {
        let disc = &self.discs[light].bound;
        irradiance_share(normal.dot(disc.axis), disc.angle)
    }
}

/// Hidden share of the ambient term and then of each disc at each receiver, (n, 1 + m).
///
/// A share is the hidden irradiance over that of the source at normal incidence, or over that of a whole sphere
/// for the ambient term.
pub fn hidden_fractions(receivers: &Receivers, sources: &Sources, solids: &[Solid]) -> Array2<f64> {
    receivers.table(solids, 1 + sources.discs(), |place, column| match column {
        0 => place.hidden_ambient(sources),
        disc => place.hidden_disc(sources, disc - 1),
    })
}

/// Share of each solid in the irradiance of each receiver, (n, solids), if all had the same radiance.
pub fn form_factors(receivers: &Receivers, solids: &[Solid]) -> Array2<f64> {
    receivers.table(solids, solids.len(), Place::form_factor)
}

/// A receiver, and the solids in front of it.
pub struct Place {
    normal: DVec3,
    /// Directions above the surface.
    horizon: ConvexRegion,
    /// Silhouette of each solid; `None` for that of the receiver, because a convex solid does not hide itself.
    silhouettes: Vec<Option<ConvexRegion>>,
}

impl Place {
    /// Receiver at a point, with a normal, and on a solid unless it is on the floor.
    pub fn new(point: DVec3, normal: DVec3, own: Option<usize>, solids: &[Solid]) -> Self {
        let others = solids.iter().enumerate();
        let seen = others.map(|(solid, one)| (Some(solid) != own).then(|| one.silhouette(point)));
        let horizon = ConvexRegion::cone(Cone::half_space(normal));
        Self { normal, horizon, silhouettes: seen.collect() }
    }

    /// Hidden share of the ambient term.
    pub fn hidden_ambient(&self, sources: &Sources) -> f64 {
        // On a floor, its horizon and that of the scene are one.
        let has_sky = sources.has_floor && self.normal.y < 1.0;
        let mut regions = vec![&self.horizon, &sources.sky];
        regions.truncate(1 + usize::from(has_sky));
        let hidden = self.union_integral(&mut regions, 0) / PI;
        hidden.clamp(0.0, sources.open_ambient(self.normal))
    }

    /// Hidden share of one disc.
    pub fn hidden_disc(&self, sources: &Sources, light: usize) -> f64 {
        let region = &sources.discs[light];
        let disc = &region.bound;
        let height = self.normal.dot(disc.axis);
        if disc.angle < LEAST_RADIUS {
            let is_hidden = self.silhouettes.iter().flatten().any(|one| one.contains(disc.axis));
            return if is_hidden { sources.open(light, self.normal) } else { 0.0 };
        }
        // The horizon of the receiver cuts only discs that reach it.
        let mut regions = vec![region, &self.horizon];
        regions.truncate(1 + usize::from(height < disc.sin));
        let hidden = self.union_integral(&mut regions, 0);
        if hidden == 0.0 {
            return 0.0;
        }
        (hidden / (PI * disc.sin * disc.sin)).clamp(0.0, sources.open(light, self.normal))
    }

    /// Share of a Lambertian receiver's irradiance that would come from one solid of uniform radiance.
    pub fn form_factor(&self, solid: usize) -> f64 {
        let integral = |silhouette| cosine_integral(self.normal, &[&self.horizon, silhouette]);
        (self.silhouettes[solid].as_ref().map_or(0.0, integral) / PI).clamp(0.0, 1.0)
    }

    /// Integral over the directions in `regions` and in any solid from `first` on, by inclusion and exclusion.
    fn union_integral<'a>(&'a self, regions: &mut Vec<&'a ConvexRegion>, first: usize) -> f64 {
        let mut sum = 0.0;
        for (solid, silhouette) in self.silhouettes.iter().enumerate().skip(first) {
            let Some(silhouette) = silhouette else { continue };
            if !regions.iter().all(|known| silhouette.may_meet(known)) {
                continue;
            }
            regions.push(silhouette);
            let alone = cosine_integral(self.normal, regions);
            if alone != 0.0 {
                sum += alone - self.union_integral(regions, solid + 1);
            }
            regions.pop();
        }
        sum
    }
}
