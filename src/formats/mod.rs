//! Readers and writers of picture files, bytes in, a header and samples out. Callers decide on colour and placement.
//!
//! | part                               | folder or file |
//! |------------------------------------|----------------|
//! | statements of a file               | `header.rs`    |
//! | the trait of all readers           | `picture.rs`   |
//! | limits and refusals of all readers | `input.rs`     |
//! | tags in the layout of TIFF         | `directory.rs` |
//! | numbers of EXIF                    | `exif.rs`      |
//! | gain maps for high dynamic range   | `gain_map.rs`  |
//! | Radiance .hdr                      | `radiance/`    |
//! | OpenEXR                            | `exr/`         |
//! | PNG                                | `png/`         |
//! | JPEG                               | `jpeg/`        |
//! | TIFF                               | `tiff/`        |

pub mod directory;
pub mod exif;
pub mod exr;
pub mod gain_map;
pub mod header;
pub mod input;
pub mod jpeg;
pub mod picture;
pub mod png;
pub mod radiance;
pub mod tiff;

use self::picture::PictureFile;
use crate::error::Result;

/// File of a `kind`, such as "png", in `bytes`, with images of at most `max_pixels`.
///
/// # Errors
///
/// If the bytes are damaged, an image has too many pixels, or there is no such kind.
pub fn open<Bytes>(kind: &str, bytes: Bytes, max_pixels: usize) -> Result<Box<dyn PictureFile>>
where
    Bytes: AsRef<[u8]> + Send + Sync + 'static,
{
    Ok(match kind {
        "radiance" => Box::new(radiance::Radiance::open(bytes, max_pixels)?),
        "openexr" => Box::new(exr::open(bytes, max_pixels)?),
        "png" => Box::new(png::Png::open(bytes, max_pixels)?),
        "jpeg" => Box::new(jpeg::open(bytes, max_pixels)?),
        "tiff" => Box::new(tiff::open(bytes, max_pixels)?),
        _ => return Err(input::unread(format!("there is no reader of the kind {kind}"))),
    })
}
