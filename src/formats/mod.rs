//! Readers of image files, bytes in, a header and samples out, and a writer of Radiance pictures. Colour and placement are decided by the caller.
//!
//! | format        | folder or file |
//! |---------------|----------------|
//! | Radiance .hdr | `radiance/`    |
//! | PNG           | `png.rs`       |

pub mod png;
pub mod radiance;

use std::ops::Range;

use crate::error::{Error, Result};

/// An image whose rows are decoded from the bytes of its file in any order and by any number of threads.
pub trait Rows: Sync {
    /// Rows and columns.
    fn size(&self) -> (usize, usize);

    /// Write the samples of some rows into `out`, three for each pixel, row after row.
    ///
    /// # Errors
    ///
    /// If the bytes of a row are damaged.
    fn read(&self, rows: Range<usize>, out: &mut [f32]) -> Result<()>;
}

/// Refuse an image without pixels, or with more than `max_pixels`, before memory is allocated.
fn check_size(height: usize, width: usize, max_pixels: usize) -> Result<()> {
    if height == 0 || width == 0 {
        return Err(Error::EmptyImage { height, width });
    }
    if height.saturating_mul(width) > max_pixels {
        return Err(Error::HugeImage { height, width, limit: max_pixels });
    }
    Ok(())
}

/// Refusal of a file for a `reason`.
fn damage(reason: impl Into<String>) -> Error {
    Error::DamagedFile { reason: reason.into() }
}

/// Zeros in an array of the `shape` (height, width, channels), on pages that the system clears when they are used.
fn zeros<T: Clone + Default>(shape: (usize, usize, usize), length: usize) -> Result<Vec<T>> {
    let no_memory = |_| Error::NoMemory { shape: vec![shape.0, shape.1, shape.2] };
    // `vec!` clears no page by itself, but aborts without memory; this reports it.
    Vec::<T>::new().try_reserve_exact(length).map_err(no_memory)?;
    Ok(vec![T::default(); length])
}
