//! The clipped part of a map, and the light that was cut off there: the kernels of `envlights.repair`.
//!
//! | number                                             | file               |
//! |----------------------------------------------------|--------------------|
//! | clipped fraction of the sphere and of the flux     | `clipped_fraction.rs` |
//! | distribution of the light that was cut off         | `missing_light.rs` |

pub mod clipped_fraction;
pub mod missing_light;
