//! Lights removed from a map, and their regions filled from the surroundings.
//!
//! | step                                                     | file                 |
//! |----------------------------------------------------------|----------------------|
//! | pixels of the detected lights                            | `light_pixels.rs`    |
//! | the map averaged over blocks of pixels                   | `coarse_map.rs`      |
//! | the region of each light: its pixels, rim, glare, glow   | `region.rs`          |
//! | - rings of glare                                         | `rings.rs`           |
//! | - the bright surroundings                                | `glow.rs`            |
//! | the rest of the map, and the light that was removed      | `removal.rs`         |
//!
//! In the region of a light, each channel of the rest is the smaller one of the map and the fill. So map = rest + light,
//! and both are nowhere negative. A surface that faces all of a light receives from the removed radiance `T`
//!
//! ```text
//!   n . V,   V = integral of T(w) w dw        (one vector for each channel)
//! ```
//!
//! The radiance of partly seen pixels is already multiplied by the seen share `s`. Unseen pixels are holes of the fill, so
//! nothing is filled from their black. The rest is the smaller one of the map and `s` times the fill.
//!
//! A light has one direction `d` and an RGB irradiance `E`; a surface receives `E n.d`. `d` is the direction of the luminance of V,
//! so luminance is exact. A channel whose vector has another direction differs by its component across `d`: red and blue
//! are refracted differently by a lens, and a halo has another colour than its lamp. Callers get all three vectors.

mod coarse_map;
mod glow;
mod light_pixels;
mod region;
mod removal;
mod rings;

use ndarray::{ArrayView3, ArrayViewMut3};
use rayon::prelude::*;

use crate::error::Result;
use crate::interrupt;
use crate::kernels::fill::harmonic_fill;
use crate::kernels::image;
use crate::kernels::sphere::{self, Registration};
use coarse_map::CoarseMap;
pub use light_pixels::LightPixels;
use region::Region;
pub use removal::RemovedLight;

/// Lights that were removed from a map.
pub struct MapSplit {
    /// Integral of the luminance of the map over the sphere.
    pub map_flux: f64,
    /// One light for each direction.
    pub lights: Vec<RemovedLight>,
    /// Light of each block of pixels, counted from 1, row after row; 0 where nothing was removed.
    pub light_of_block: Vec<u32>,
}

/// Remove lights from an equirectangular map of radiance, (height, width, 3), finite and not negative.
///
/// `seen` is the share of each pixel that the map shows, row after row, by which its radiance is multiplied already.
/// `rest` receives the map without the lights. It has the shape of the map, in C order.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::OutsideImage`], [`crate::error::Error::LengthMismatch`],
/// [`crate::error::Error::WrongColumns`], [`crate::error::Error::NotUnit`], [`crate::error::Error::NoMemory`].
pub fn split(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    lights: &LightPixels<'_>,
    seen: Option<&[f32]>,
    mut rest: ArrayViewMut3<'_, f32>,
) -> Result<MapSplit> {
    image::check_rgb(radiance)?;
    let directions = sphere::unit_vectors("direction", lights.directions)?;
    let (height, width, _) = radiance.dim();
    sphere::check_memory(&[height, width, 2])?;
    let samples = image::samples_of(radiance, 0..height);
    let pixels = samples.as_chunks::<3>().0;
    let map = CoarseMap::new(pixels, (height, width), registration, lights, seen)?;
    let members = sphere::pixels_of_lights(lights.pixels, lights.light_of_pixel, map.size)?;
    let rest_pixels = rest.as_slice_mut().unwrap_or_default().as_chunks_mut::<3>().0;
    // Copy the map on one thread while another one fills the region: both last equally long.
    let fill = || {
        let region = Region::new(&map, &members, directions.len(), lights.threshold as f32);
        let fill =
            harmonic_fill(map.grid.clone(), region.pixels_to_fill(&map), |pixel| region.rest(&map, pixel));
        (region, fill)
    };
    let ((), (region, fill)) = rayon::join(|| copy(pixels, rest_pixels, width), fill);
    let lights = removal::remove(&map, &region, &fill, &directions, rest_pixels);
    Ok(MapSplit { map_flux: map.flux(), lights, light_of_block: region.light_of })
}

/// Copy the pixels of a map of this `width` row by row, so that the copy can be interrupted.
fn copy(map: &[[f32; 3]], rest: &mut [[f32; 3]], width: usize) {
    rest.par_chunks_mut(width).zip(map.par_chunks(width)).for_each(|(rest, map)| {
        interrupt::check();
        rest.copy_from_slice(map);
    });
}
