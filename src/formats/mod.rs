//! File formats that the package reads or writes itself.

pub mod radiance;
