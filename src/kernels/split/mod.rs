//! Lights taken out of a map, and their places filled from the surroundings.
//!
//! [`split`] calls the steps in this order:
//!
//! | step                                                     | file           |
//! |----------------------------------------------------------|----------------|
//! | the lights as they were found                           | `found.rs`     |
//! | the map in the pixels in which its lights were found     | `working.rs`   |
//! | which pixels each light fills: itself, its rim, its glare | `region.rs`   |
//! | - the glow that would be found as a light without it     | `glow.rs`      |
//! | the membrane that closes the hole of each light          | `membrane.rs`  |
//! | - the sphere in fewer and fewer pixels                   | `level.rs`     |
//! | the lights, each of one direction and one RGB            | `taken.rs`     |
//! | - their pixels closed, the glow dimmed                   | `close.rs`     |
//! | - the membrane in the pixels of the map                  | `stretched.rs` |
//! | - what is left tilted, so that the direction is one      | `tilt.rs`      |
//! | - what was lost                                          | `loss.rs`      |
//! | - bands and strips of pixels, channel by channel         | `pixels.rs`, `planes.rs` |
//! | - their solid angles and directions                      | `cells.rs`     |
//! | - sums over them                                         | `moments.rs`   |
//!
//! A light has one direction and an RGB irradiance. Wherever all of it is before a surface, it gives
//! `E max(0, n.d)`, and what was taken from the map, `T = L - L'`, gives
//!
//! ```text
//!   n . V,   V = integral of T(w) w dw        (a vector for each channel)
//! ```
//!
//! So map and rest with light are the same where the three vectors are parallel to `d`, and `E` are their
//! lengths. The lens of a camera refracts red and blue differently, and a halo has another colour than its
//! lamp: in real maps the vectors stand apart by some hundredths of a degree. `tilt.rs` makes them parallel as
//! far as that does not show.

mod cells;
mod close;
mod found;
mod glow;
mod level;
mod loss;
mod membrane;
mod moments;
mod pixels;
mod planes;
mod region;
mod stretched;
mod taken;
mod tilt;
mod working;

use ndarray::{ArrayView3, ArrayViewMut3};
use rayon::prelude::*;

use crate::error::Result;
use crate::interrupt;
use crate::kernels::image::{self, Grid};
use crate::kernels::sphere::{self, Registration};
use cells::Cells;
pub use found::Found;
use glow::Bright;
use level::Level;
use pixels::Map;
use region::Regions;
pub use taken::Taken;
use working::Working;

/// Take lights out of an equirectangular map of radiance, (height, width, 3), finite and not negative: one for each
/// direction that was found.
///
/// What is left, nowhere negative, is written into `rest`, of the same size.
///
/// # Errors
///
/// [`Error::NotAMap`], [`Error::OutsideImage`], [`Error::LengthMismatch`], [`Error::WrongColumns`],
/// [`Error::NotUnit`], [`Error::NoMemory`].
pub fn split(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    found: &Found<'_>,
    rest: ArrayViewMut3<'_, f32>,
) -> Result<Vec<Taken>> {
    image::check_rgb(radiance)?;
    let directions = sphere::unit_vectors("direction", found.directions)?;
    let (height, width, _) = radiance.dim();
    sphere::check_memory(&[height, width, 2])?;
    // What is not in rows one after the other is empty here, and refused for its length.
    let rest = rest.into_slice().unwrap_or_default();
    sphere::check_lengths("radiance", radiance.len(), [("rest", rest.len())])?;
    let samples = image::samples_of(radiance, 0..height);
    let map = samples.as_chunks::<3>().0;
    let (size, block) = ((height, width), found.block.max(1));
    let working = Working::of(map, size, registration, block, found.luminance);
    sphere::check_lengths("pixels", working.size.0 * working.size.1, [("luminance", working.luminances())])?;
    let members = found.members(working.size)?;
    // To find what closes the holes takes about as long as to copy the map: two threads do both.
    let rest = rest.as_chunks_mut::<3>().0;
    let closed = || closed(&working, &members, directions.len(), found.bright());
    let ((), (regions, membrane)) = rayon::join(|| copy(map, rest), closed);
    let map = Map {
        pixels: map,
        size,
        cells: Cells::new(&Grid::of_pixels(height, width, registration)),
        membrane: &membrane,
        block,
        bright: found.bright(),
    };
    Ok(taken::take(&map, &Cells::new(&working.grid), &regions, &directions, rest))
}

/// The pixels of the first `taken` lights, and the membrane that closes their holes.
fn closed(
    working: &Working<'_>,
    members: &[(usize, usize)],
    taken: usize,
    bright: Bright,
) -> (Regions, Level) {
    let regions = region::regions(working, members, taken, bright);
    let given = |pixel| regions.mean_left(working, pixel);
    let membrane = membrane::membrane(working.grid.clone(), regions.all_holes.clone(), given);
    (regions, membrane)
}

/// Copy a map, so that it can be interrupted.
fn copy(map: &[[f32; 3]], rest: &mut [[f32; 3]]) {
    const PIXELS_AT_ONCE: usize = 1 << 18;
    rest.par_chunks_mut(PIXELS_AT_ONCE).zip(map.par_chunks(PIXELS_AT_ONCE)).for_each(|(rest, map)| {
        interrupt::check();
        rest.copy_from_slice(map);
    });
}
