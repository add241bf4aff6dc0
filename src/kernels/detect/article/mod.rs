//! The steps of Loghin (2021), each for itself on a luminance image. `envlights.detect_article` puts
//! them together; they serve a plane image as well as a map.
//!
//! | step                                          | file            |
//! |-----------------------------------------------|-----------------|
//! | 1, 2: a smaller, smoother luminance image     | `image.rs`      |
//! | 5: the brightest pixel around a sample        | `neighbours.rs` |
//! | 7: samples near a brighter one                | `suppress.rs`   |
//! | 8: which samples a bright line joins          | `bresenham.rs`  |
//!
//! Steps 3, 4 and 6 are `kernels::sampling`, `kernels::sphere` and a sort; step 9 is a weighted mean.

pub mod bresenham;
pub mod image;
pub mod neighbours;
pub mod suppress;

use ndarray::{ArrayView2, Axis};

use crate::error::{Error, Result};

/// Row and column.
pub type Pixel = [usize; 2];

/// `pixels`, (n, 2), rows and columns, each inside of an image of `size`.
fn pixels_inside(pixels: ArrayView2<'_, i64>, size: (usize, usize)) -> Result<Vec<Pixel>> {
    if pixels.ncols() != 2 {
        return Err(Error::WrongColumns { what: "pixels", columns: 2, shape: pixels.shape().to_vec() });
    }
    let (height, width) = size;
    let inside = |(index, row): (usize, ndarray::ArrayView1<'_, i64>)| {
        let pixel = [usize::try_from(row[0]), usize::try_from(row[1])];
        match pixel {
            [Ok(y), Ok(x)] if y < height && x < width => Ok([y, x]),
            _ => Err(Error::OutsideImage { index, row: row[0], column: row[1], height, width }),
        }
    };
    pixels.axis_iter(Axis(0)).enumerate().map(inside).collect()
}
