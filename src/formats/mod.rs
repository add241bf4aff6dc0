//! Readers of image files, bytes in, a header and samples out, and a writer of Radiance pictures. Callers decide on
//! colour and placement.
//!
//! | format        | folder or file |
//! |---------------|----------------|
//! | Radiance .hdr | `radiance/`    |
//! | PNG           | `png.rs`       |

pub mod input;
pub mod png;
pub mod radiance;

pub use input::Rows;
