//! The kernels by which lights with a size are compared with a map.

/// Kernel by which lights are compared with the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Comparison {
    /// Irradiance of a white probe without shadows.
    Probe,
    /// Irradiance of a white probe with shadows, over all blocking planes.
    Shadows,
    /// Weighted mean of both kernels, each divided by its factor of degree 0.
    Mixed,
}
