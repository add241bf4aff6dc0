//! Radiance pictures: 8 bits for each colour, and a shared exponent.

pub mod write;
