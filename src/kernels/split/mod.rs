//! Lights taken out of a map, and their places filled from the surroundings.
//!
//! [`split`] calls the steps in this order:
//!
//! | step                                                     | file           |
//! |----------------------------------------------------------|----------------|
//! | the map in the pixels in which its lights were found     | `working.rs`   |
//! | which pixels each light fills: itself, its rim, its glare | `region.rs`   |
//! | - and the glow that would be found as a light without it | `glow.rs`      |
//! | the membrane that closes the hole of each light          | `membrane.rs`  |
//! | - the sphere in fewer and fewer pixels                   | `level.rs`     |
//! | solid angle and direction of the map's own pixels        | `cells.rs`     |
//! | what is taken from them, as one direction and one RGB    | `taken.rs`     |
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
mod glow;
mod level;
mod membrane;
mod region;
mod taken;
mod working;

use ndarray::{ArrayView1, ArrayView2, ArrayView3};

use crate::error::{Error, Result};
use crate::kernels::image;
use crate::kernels::sphere::{self, Registration};
use cells::Cells;
use taken::Map;
pub use taken::Taken;
use working::Working;

/// The lights that are to be taken, as they were found in a map.
pub struct Found<'a> {
    /// Row and column, (k, 2), of each light's pixels in the working image.
    pub pixels: ArrayView2<'a, i64>,
    /// The light of each of them, (k,). Those from the number of `directions` on stay in the map.
    pub light_of_pixel: ArrayView1<'a, i64>,
    /// A unit vector towards each light that is taken, (n, 3).
    pub directions: ArrayView2<'a, f64>,
    /// Pixels of the map along each side of a pixel of the working image.
    pub block: usize,
    /// Luminance above which a place is bright.
    pub threshold: f64,
}

/// What is left of a map without some lights, and what each of them was.
pub struct Split {
    /// Flat indices of the pixels of all lights, each once.
    pub pixels: Vec<i64>,
    /// The radiance that is left in each of them, nowhere negative. The other pixels keep theirs.
    pub left: Vec<[f32; 3]>,
    /// One for each direction that was given.
    pub lights: Vec<Taken>,
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
    let members = members(found, working.size)?;
    let regions = region::regions(&working, &members, directions.len(), found.threshold);
    let membrane = membrane::membrane(&working, &regions);
    let cells = Cells::new(height, width, registration);
    let map = Map { pixels: map, size, cells, membrane: membrane.enlarged(block, size), block };
    let (mut pixels, mut left, mut lights) = (Vec::new(), Vec::new(), Vec::new());
    for (region, &direction) in regions.pixels.iter().zip(&directions) {
        let (light, taken_from) = taken::take(&map, region, direction);
        for part in taken_from {
            pixels.extend(part.iter().map(|pixel| (pixel.row * width + pixel.column) as i64));
            left.extend(part.iter().map(|pixel| pixel.left));
        }
        lights.push(light);
    }
    Ok(Split { pixels, left, lights })
}

/// Flat indices of the pixels of lights in a working image of this size, each with its light.
fn members(found: &Found<'_>, (height, width): (usize, usize)) -> Result<Vec<(usize, usize)>> {
    let lengths = [("light_of_pixel", found.light_of_pixel.len())];
    sphere::check_lengths("pixels", found.pixels.nrows(), lengths)?;
    let mut members = Vec::with_capacity(found.pixels.nrows());
    for (index, (place, &light)) in found.pixels.rows().into_iter().zip(found.light_of_pixel).enumerate() {
        let (row, column) = (place[0], place[1]);
        if !(0..height as i64).contains(&row) || !(0..width as i64).contains(&column) || light < 0 {
            return Err(Error::OutsideImage { index, row, column, height, width });
        }
        members.push((row as usize * width + column as usize, light as usize));
    }
    Ok(members)
}
