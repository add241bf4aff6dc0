//! Common parts of all readers: limits and refusals.

use crate::error::{Error, Result};

/// Refuse an image without pixels, or with more than `max_pixels`, before memory is allocated.
///
/// # Errors
///
/// [`Error::EmptyImage`], [`Error::HugeImage`].
pub fn check_size(height: usize, width: usize, max_pixels: usize) -> Result<()> {
    if height == 0 || width == 0 {
        return Err(Error::EmptyImage { height, width });
    }
    if height.saturating_mul(width) > max_pixels {
        return Err(Error::HugeImage { height, width, limit: max_pixels });
    }
    Ok(())
}

/// Refusal of a file whose content is not converted, for a `reason` with the way out.
pub fn unread(reason: impl Into<String>) -> Error {
    Error::UnreadFile { reason: reason.into() }
}

/// Refusal of a damaged file for a `reason`.
pub fn damage(reason: impl Into<String>) -> Error {
    Error::DamagedFile { reason: reason.into() }
}

/// Zeros in an array of the `shape` (height, width, channels), on pages that the system clears when they are used.
///
/// # Errors
///
/// [`Error::NoMemory`].
pub fn zeros<T: Clone + Default>(shape: (usize, usize, usize), length: usize) -> Result<Vec<T>> {
    let no_memory = |_| Error::NoMemory { shape: vec![shape.0, shape.1, shape.2] };
    // `vec!` clears no page by itself, but aborts without memory; this reports it.
    Vec::<T>::new().try_reserve_exact(length).map_err(no_memory)?;
    Ok(vec![T::default(); length])
}
