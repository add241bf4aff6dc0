//! Readers and writers of picture files, bytes in, a header and samples out. Callers decide on colour and placement.
//!
//! | part                               | folder or file |
//! |------------------------------------|----------------|
//! | statements of a file               | `header.rs`    |
//! | the trait of all readers           | `picture.rs`   |
//! | limits and refusals of all readers | `input.rs`     |
//! | Radiance .hdr                      | `radiance/`    |
//! | OpenEXR                            | `exr/`         |
//! | PNG                                | `png.rs`       |

pub mod exr;
pub mod header;
pub mod input;
pub mod picture;
pub mod png;
pub mod radiance;

pub use input::Rows;
