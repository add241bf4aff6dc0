//! The steps of Loghin (2021), each for itself on a luminance image. `envlights.detect_article` puts
//! them together; they serve a plane image as well as a map.
//!
//! | step                                          | file            |
//! |-----------------------------------------------|-----------------|
//! | 1: a smaller image                            | `resize.rs`     |
//! | 2: its luminance                              | `luminance.rs`  |
//! | 2: smoother, if wanted                        | `blur.rs`       |
//! | 5: the brightest pixel around a sample        | `neighbours.rs` |
//! | 7: samples near a brighter one                | `suppress.rs`   |
//! | 8: the line between two samples               | `bresenham.rs`  |
//! | 8: which samples a bright line joins          | `merge.rs`      |
//!
//! Steps 3, 4 and 6 are `kernels::sampling`, `kernels::sphere` and a sort; step 9 is a weighted mean.

pub mod blur;
pub mod bresenham;
pub mod luminance;
pub mod merge;
pub mod neighbours;
pub mod resize;
pub mod suppress;

use glam::DVec3;
use ndarray::{ArrayView2, Axis};

use crate::error::{Error, Result};
use crate::kernels::sphere::check_rows;

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

/// `points`, (n, 2) or (n, 3), in space; those of a plane at height 0.
fn places(points: ArrayView2<'_, f64>) -> Result<Vec<DVec3>> {
    let columns = if points.ncols() == 3 { 3 } else { 2 };
    check_rows("points", points, columns)?;
    let height = |row: ndarray::ArrayView1<'_, f64>| if columns == 3 { row[2] } else { 0.0 };
    Ok(points.rows().into_iter().map(|row| DVec3::new(row[0], row[1], height(row))).collect())
}

/// A gray image whose pixels are finite, row behind row.
struct Image<'a> {
    height: usize,
    width: usize,
    samples: &'a [f32],
}

impl<'a> Image<'a> {
    /// The `image` that is called `what`, in standard layout.
    fn new(what: &'static str, image: ArrayView2<'a, f32>) -> Result<Self> {
        let (height, width) = image.dim();
        if height == 0 || width == 0 {
            return Err(Error::EmptyImage { height, width });
        }
        let samples = image.to_slice().unwrap_or(&[]);
        for (row, samples) in samples.chunks(width).enumerate() {
            // Without an early way out the row is tested eight pixels at a time.
            if !samples.iter().fold(true, |all, value| all & value.is_finite()) {
                let bad = samples.iter().position(|value| !value.is_finite()).unwrap_or(0);
                return Err(Error::BadPixel { what, row, column: bad, value: samples[bad] });
            }
        }
        Ok(Self { height, width, samples })
    }

    fn row(&self, row: usize) -> &'a [f32] {
        &self.samples[row * self.width..][..self.width]
    }

    fn at(&self, [row, column]: Pixel) -> f32 {
        self.samples[row * self.width + column]
    }
}
