//! The rest of a map without the radiance of its lights, and the lights that were removed.
//!
//! In the region of a light, each channel of the rest is the smaller one of the map and the fill, and a glow is dimmed.
//! So the light of a red lamp on a white wall has no negative blue. The light is the integral of the difference.

use std::ops::{Add, Range};

use glam::{DMat3, DVec3, Vec3A};
use rayon::prelude::*;

use super::coarse_map::CoarseMap;
use super::light_pixels::NO_LIGHT;
use super::region::Region;
use crate::interrupt;
use crate::kernels::cell_integrals::{ColumnIntegrals, RowIntegrals};
use crate::kernels::fill::{Level, Upsampling};
use crate::kernels::image::LUMINANCE;

/// A light that was removed from a map.
#[derive(Clone, Debug)]
pub struct RemovedLight {
    /// Unit vector of the removed luminance.
    pub direction: DVec3,
    /// Irradiance of each channel at normal incidence: the component of its vector along the direction.
    pub irradiance: DVec3,
    /// Integral of the removed radiance in each channel.
    pub flux: DVec3,
    /// Solid angle of a light of constant luminance with the same flux and the same integral of its square.
    pub solid_angle: f64,
    /// Largest angle from the direction to removed radiance.
    pub reach: f64,
    /// Vector irradiance, one column for each channel.
    pub vectors: DMat3,
}

/// Integrals over radiance that was removed, with the luminance `Y`.
#[derive(Clone, Copy)]
struct Removal {
    /// Vector irradiance, one column for each channel.
    vectors: DMat3,
    /// Integral of each channel.
    flux: DVec3,
    /// Integral of `Y^2`.
    squares: f64,
}

impl Removal {
    const ZERO: Self = Self { vectors: DMat3::ZERO, flux: DVec3::ZERO, squares: 0.0 };
}

impl Add for Removal {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            vectors: self.vectors + other.vectors,
            flux: self.flux + other.flux,
            squares: self.squares + other.squares,
        }
    }
}

/// Remove the lights of a region from `rest`, a copy of the map; a light without radiance has its `detected` direction.
pub fn remove(
    map: &CoarseMap<'_>,
    region: &Region,
    fill: &Level,
    detected: &[DVec3],
    rest: &mut [[f32; 3]],
) -> Vec<RemovedLight> {
    let remover = Remover {
        map,
        region,
        fill: Upsampling::new(fill, map.block, map.map_size),
        rows: RowIntegrals::of_rows(&map.pixel_grid.theta_edges),
        columns: ColumnIntegrals::of_columns(&map.pixel_grid.phi_edges),
    };
    // Sum the rows in their order: the same bits for any number of threads.
    let rows = rest.par_chunks_mut(map.block * map.map_size.1).enumerate();
    let removals: Vec<Vec<(usize, Removal)>> = rows.map(|(row, rest)| remover.row(row, rest)).collect();
    let mut sums = vec![Removal::ZERO; detected.len()];
    for (light, removal) in removals.into_iter().flatten() {
        sums[light] = sums[light] + removal;
    }
    let direction = |(sum, &detected): (&Removal, &DVec3)| direction(sum).unwrap_or(detected);
    let directions: Vec<DVec3> = sums.iter().zip(detected).map(direction).collect();
    let reaches = reaches(map, region, &directions);
    let lights = sums.iter().zip(directions).zip(reaches);
    lights.map(|((sum, direction), reach)| light(sum, direction, reach)).collect()
}

/// Direction of the removed luminance, if there is any.
fn direction(sum: &Removal) -> Option<DVec3> {
    (sum.vectors * DVec3::from_array(LUMINANCE)).try_normalize()
}

fn light(sum: &Removal, direction: DVec3, reach: f64) -> RemovedLight {
    let &Removal { vectors, flux, squares } = sum;
    let luminous_flux = flux.dot(DVec3::from_array(LUMINANCE));
    RemovedLight {
        direction,
        irradiance: (vectors.transpose() * direction).max(DVec3::ZERO),
        flux,
        solid_angle: if squares > 0.0 { luminous_flux * luminous_flux / squares } else { 0.0 },
        reach: if luminous_flux > 0.0 { reach } else { 0.0 },
        vectors,
    }
}

/// Largest angle from each direction to the region of its light.
fn reaches(map: &CoarseMap<'_>, region: &Region, directions: &[DVec3]) -> Vec<f64> {
    let mut cosines = vec![1.0_f64; directions.len()];
    for (pixel, &light) in region.light_of.iter().enumerate().filter(|(_, light)| **light != NO_LIGHT) {
        let light = light as usize - 1;
        cosines[light] = cosines[light].min(map.centre(pixel).dot(directions[light]));
    }
    cosines.iter().map(|cosine| cosine.max(-1.0).acos() + map.half_diagonal()).collect()
}

/// Everything that removal reads.
struct Remover<'a> {
    map: &'a CoarseMap<'a>,
    region: &'a Region,
    fill: Upsampling<'a>,
    rows: Vec<RowIntegrals>,
    columns: Vec<ColumnIntegrals>,
}

impl Remover<'_> {
    /// Remove light from one row of coarse pixels; the integrals of each run of pixels with its light.
    fn row(&self, row: usize, rest: &mut [[f32; 3]]) -> Vec<(usize, Removal)> {
        interrupt::check();
        let (width, block) = (self.map.size.1, self.map.block);
        let kind = |column: usize| {
            (self.region.light_of[row * width + column], self.region.is_filled[row * width + column])
        };
        let mut removals = Vec::new();
        let mut start = 0;
        while start < width {
            let (light, is_filled) = kind(start);
            let end = (start..width).find(|&column| kind(column) != (light, is_filled)).unwrap_or(width);
            if light != NO_LIGHT {
                let columns = start * block..(end * block).min(self.map.map_size.1);
                removals.push((light as usize - 1, self.run(row * block, columns, is_filled, rest)));
            }
            start = end;
        }
        removals
    }

    /// Remove light from some columns of a few rows from row `first` on.
    fn run(&self, first: usize, columns: Range<usize>, is_filled: bool, rest: &mut [[f32; 3]]) -> Removal {
        let width = self.map.map_size.1;
        let rows = rest.chunks_exact_mut(width).zip(first..);
        let integrals = rows.map(|(rest, row)| {
            let rest = &mut rest[columns.clone()];
            let integrals = &self.columns[columns.clone()];
            let share = |x: usize| self.map.share_of_pixel(row, columns.start + x);
            let sums = if is_filled {
                let fill = self.fill.row(row);
                remove_pixels(rest, integrals, |x, map| map.min(share(x) * fill.at(columns.start + x)))
            } else {
                remove_pixels(rest, integrals, |x, map| self.region.dim(map, share(x)))
            };
            sums.integrals(&self.rows[row])
        });
        integrals.fold(Removal::ZERO, Removal::add)
    }
}

/// Sums along a row over removed radiance, before the factors of the row.
#[derive(Default)]
struct AzimuthSums {
    sin: DVec3,
    cos: DVec3,
    width: DVec3,
    squares: f64,
}

/// Replace pixels by their `remaining` radiance, and sum the removed radiance.
#[inline]
fn remove_pixels(
    pixels: &mut [[f32; 3]],
    columns: &[ColumnIntegrals],
    remaining: impl Fn(usize, Vec3A) -> Vec3A,
) -> AzimuthSums {
    let mut sums = AzimuthSums::default();
    for (x, (pixel, column)) in pixels.iter_mut().zip(columns).enumerate() {
        let before = Vec3A::from_array(*pixel);
        let after = remaining(x, before);
        *pixel = after.to_array();
        let removed = before.as_dvec3() - after.as_dvec3();
        sums.sin += column.sin * removed;
        sums.cos += column.cos * removed;
        sums.width += column.width * removed;
        let luminance = removed.dot(DVec3::from_array(LUMINANCE));
        sums.squares += column.width * luminance * luminance;
    }
    sums
}

impl AzimuthSums {
    fn integrals(&self, row: &RowIntegrals) -> Removal {
        let axes =
            DMat3::from_cols(row.squares * self.sin, row.products * self.width, -row.squares * self.cos);
        Removal { vectors: axes.transpose(), flux: row.band * self.width, squares: row.band * self.squares }
    }
}
