//! Light cards: lights of a map as planar shapes, each with a 3x3 matrix and a texture.
//!
//! A card is the parallelogram of the points `P(a, b) = O + a U + b V` with `0 <= a, b <= 1`, seen from the origin. Its
//! matrix has the columns U, V, O. A direction lies in the card if `M^-1 w = (p, q, r)` has `r > 0`, and `p / r` and
//! `q / r` lie in `0 ..= 1`. This has no pole and no seam.
//!
//! | step                                         | file               |
//! |----------------------------------------------|--------------------|
//! | matrix of a card                             | `card_matrix.rs`   |
//! | pixels near a direction                      | `card_pixels.rs`   |
//! | luminance around a light, in a plane         | `footprint.rs`     |
//! | soft shapes with derivatives                 | `soft_shapes.rs`   |
//! | damped least squares                         | `least_squares.rs` |
//! | shape of a light                             | `shape_fit.rs`     |
//! | windows with a view, by their edges          | `window_search.rs` |
//! | - the map in the plane of a wall             | `wall_plane.rs`    |
//! | - sides at the largest change                | `window_sides.rs`  |
//! | panes of a window                            | `panes.rs`         |
//! | the rest of the map behind a window          | `window_fill.rs`   |
//! | textures, and the map without the cards      | `card_cut.rs`      |
//! | drawing of cards into a map                  | `card_drawing.rs`  |

mod card_cut;
mod card_drawing;
mod card_matrix;
mod card_pixels;
mod footprint;
mod least_squares;
mod panes;
mod shape_fit;
mod soft_shapes;
mod wall_plane;
mod window_fill;
mod window_search;
mod window_sides;

use card_pixels::CardPixels;
use footprint::RemovedRadiance;

pub use card_cut::{CardCut, CardLight, cut};
pub use card_drawing::{DrawnCard, draw};

use glam::{DMat3, DVec3};
use ndarray::{ArrayView1, ArrayView2, ArrayView3, ArrayViewMut3};

use crate::error::{Error, Result};
use crate::kernels::sphere::{self, Registration};

/// Lights that were removed from a map, with their pixels in the map averaged over square blocks.
pub struct MapLights<'a> {
    /// Pixels of the map along each side of a block.
    pub block: usize,
    /// Row and column of each block, (k, 2).
    pub pixels: ArrayView2<'a, i64>,
    /// Index of the light of each block, (k,); lights that stay have the index after the last.
    pub light_of_pixel: ArrayView1<'a, i64>,
    /// Unit vectors, (n, 3).
    pub directions: ArrayView2<'a, f64>,
    /// Angular radii, (n,).
    pub radii: ArrayView1<'a, f64>,
}

/// Cards of the lights of a map; `rest` receives the map without them.
///
/// # Errors
///
/// [`Error::LengthMismatch`], [`Error::WrongShape`], [`Error::WrongColumns`], [`Error::NotFinite`],
/// [`Error::OutsideImage`], [`Error::Negative`].
pub fn cut_map(
    map: ArrayView3<'_, f32>,
    other: ArrayView3<'_, f32>,
    registration: Registration,
    lights: &MapLights<'_>,
    mut rest: ArrayViewMut3<'_, f32>,
) -> Result<Vec<CardCut>> {
    let (height, width, _) = map.dim();
    sphere::check_lengths("rest", height, [("radiance", other.dim().0)])?;
    sphere::check_lengths("directions", lights.directions.nrows(), [("radius", lights.radii.len())])?;
    let not_rows =
        || Error::WrongShape { what: "radiance", wanted: "(height, width, 3)", shape: map.shape().to_vec() };
    let (map_rows, other_rows) =
        (map.as_slice().ok_or_else(not_rows)?, other.as_slice().ok_or_else(not_rows)?);
    let blocks = width.div_ceil(lights.block.max(1));
    let removed = RemovedRadiance {
        pixels: CardPixels::new(height, width, registration),
        map: map_rows.as_chunks().0,
        rest: other_rows.as_chunks().0,
        labels: labels(lights, height.div_ceil(lights.block.max(1)), blocks)?,
        block: lights.block.max(1),
        blocks,
    };
    let directions = sphere::vectors("direction", lights.directions)?.into_iter();
    let all: Vec<CardLight> =
        directions.zip(lights.radii).map(|(direction, &radius)| CardLight { direction, radius }).collect();
    let samples = rest.as_slice_mut().ok_or_else(not_rows)?;
    Ok(cut(removed, &all, samples.as_chunks_mut().0))
}

/// Number of the light of each block from 1, or 0.
fn labels(lights: &MapLights<'_>, rows: usize, columns: usize) -> Result<Vec<u32>> {
    let mut labels = vec![0; rows * columns];
    for (pixel, light) in sphere::pixels_of_lights(lights.pixels, lights.light_of_pixel, (rows, columns))? {
        labels[pixel] = light as u32 + 1;
    }
    Ok(labels)
}

/// Draw cards with these matrices, (n, 3, 3), and textures into a map.
///
/// # Errors
///
/// [`Error::LengthMismatch`] if arrays have another number of cards or texels.
pub fn draw_map(
    matrix: ArrayView3<'_, f64>,
    is_disc: &[bool],
    irradiance: ArrayView2<'_, f64>,
    sizes: &[[usize; 2]],
    texels: ArrayView2<'_, f32>,
    registration: Registration,
    mut map: ArrayViewMut3<'_, f32>,
) -> Result<()> {
    let (height, width, _) = map.dim();
    let lengths = [("is_disc", is_disc.len()), ("irradiance", irradiance.nrows()), ("sizes", sizes.len())];
    sphere::check_lengths("matrix", matrix.dim().0, lengths)?;
    let total = sizes.iter().map(|[rows, columns]| rows * columns).sum();
    sphere::check_lengths("sizes", total, [("texels", texels.nrows())])?;
    let colours: Vec<[f32; 3]> = texels.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect();
    let mut first = 0;
    let card = |i: usize| {
        let [rows, columns] = sizes[i];
        let texels = &colours[first..first + rows * columns];
        first += rows * columns;
        DrawnCard {
            matrix: DMat3::from_cols_array_2d(&[0, 1, 2].map(|c| [0, 1, 2].map(|r| matrix[[i, r, c]]))),
            is_disc: is_disc[i],
            irradiance: DVec3::new(irradiance[[i, 0]], irradiance[[i, 1]], irradiance[[i, 2]]),
            size: sizes[i],
            texels,
        }
    };
    let cards: Vec<DrawnCard<'_>> = (0..sizes.len()).map(card).collect();
    if let Some(samples) = map.as_slice_mut() {
        draw(&cards, (height, width), registration, samples.as_chunks_mut().0);
    }
    Ok(())
}
