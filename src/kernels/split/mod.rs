//! Lights taken out of a map, and their places filled from the surroundings.
//!
//! [`split`] calls the steps in this order:
//!
//! | step                                                     | file           |
//! |----------------------------------------------------------|----------------|
//! | the lights as they were found                           | `found.rs`     |
//! | the map in the pixels in which its lights were found     | `working.rs`   |
//! | which pixels each light fills: itself, its rim, its glare | `region.rs`   |
//! | - and the glow that would be found as a light without it | `glow.rs`      |
//! | the membrane that closes the hole of each light          | `membrane.rs`  |
//! | - the sphere in fewer and fewer pixels                   | `level.rs`     |
//! | what is taken from the map, as one direction and one RGB | `taken.rs`     |
//! | - row by row of its own pixels                           | `pixels.rs`    |
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
//! lamp: in real maps the vectors stand apart by some hundredths of a degree. `taken.rs` makes them parallel as
//! far as that does not show.

mod cells;
mod found;
mod glow;
mod level;
mod membrane;
mod moments;
mod pixels;
mod region;
mod taken;
mod working;

use glam::DVec3;
use ndarray::ArrayView3;

use crate::error::Result;
use crate::kernels::image::{self, Grid};
use crate::kernels::sphere::{self, Registration};
use cells::Cells;
pub use found::Found;
use level::Enlarged;
use pixels::{Map, Part};
use region::Regions;
use taken::Room;
pub use taken::Taken;
use working::Working;

/// What is left of a map without some lights, and what each of them was.
pub struct Split {
    /// Flat indices of the pixels of all lights, each once.
    pub pixels: Vec<i64>,
    /// The radiance that is left in each of them, nowhere negative. The other pixels keep theirs.
    pub left: Vec<[f32; 3]>,
    /// One for each direction that was given.
    pub lights: Vec<Taken>,
    /// Largest luminance of the pixels in which each of them was found.
    pub peaks: Vec<f32>,
}

/// Take lights out of an equirectangular map of radiance, (height, width, 3), finite and not negative.
///
/// # Errors
///
/// [`Error::NotAMap`], [`Error::OutsideImage`], [`Error::LengthMismatch`], [`Error::WrongColumns`],
/// [`Error::NotUnit`], [`Error::NoMemory`].
pub fn split(radiance: ArrayView3<'_, f32>, registration: Registration, found: &Found<'_>) -> Result<Split> {
    image::check_rgb(radiance)?;
    let directions = sphere::unit_vectors("direction", found.directions)?;
    let (height, width, _) = radiance.dim();
    sphere::check_memory(&[height, width, 2])?;
    let samples = image::samples_of(radiance, 0..height);
    let map = samples.as_chunks::<3>().0;
    let (size, block) = ((height, width), found.block.max(1));
    let working = Working::of(map, size, registration, block);
    let members = found.members(working.size)?;
    let peaks = found.peaks(map, size, &members);
    let regions = region::regions(&working, &members, directions.len(), found.threshold);
    let membrane = membrane::membrane(&working, &regions);
    let map = Map {
        pixels: map,
        size,
        cells: Cells::new(&Grid::of_pixels(height, width, registration)),
        membrane: Enlarged::new(&membrane, block),
        block,
    };
    let (pixels, left, lights) = taken(&map, &Cells::new(&working.grid), &regions, &directions);
    Ok(Split { pixels, left, lights, peaks })
}

/// Take one light after the other, each from its region: flat indices of pixels, what is left of them, and the lights.
fn taken(
    map: &Map<'_>,
    working: &Cells,
    regions: &Regions,
    directions: &[DVec3],
) -> (Vec<i64>, Vec<[f32; 3]>, Vec<Taken>) {
    let parts: Vec<Vec<Part>> = regions.pixels.iter().map(|region| map.parts(region)).collect();
    let count = parts.iter().flatten().map(|part| part.pixels).sum();
    let (mut pixels, mut left) = (vec![0; count], vec![[0.0; 3]; count]);
    let mut room = Room { pixels: &mut pixels, left: &mut left };
    let lights = regions.pixels.iter().zip(&parts).zip(directions);
    let lights = lights
        .map(|((region, parts), &direction)| taken::take(map, working, region, parts, direction, &mut room))
        .collect();
    (pixels, left, lights)
}
