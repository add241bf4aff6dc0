//! Readers and writers of picture files, bytes in, a header and samples out. Callers decide on colour and placement.
//!
//! | part                               | folder or file |
//! |------------------------------------|----------------|
//! | statements of a file               | `header.rs`    |
//! | the trait of all readers           | `picture.rs`   |
//! | limits and refusals of all readers | `input.rs`     |
//! | numbers of EXIF                    | `exif.rs`      |
//! | gain maps for high dynamic range   | `gain_map.rs`  |
//! | Radiance .hdr                      | `radiance/`    |
//! | PNG                                | `png.rs`       |
//! | JPEG                               | `jpeg/`        |

pub mod exif;
pub mod gain_map;
pub mod header;
pub mod input;
pub mod jpeg;
pub mod picture;
pub mod png;
pub mod radiance;

pub use input::Rows;
