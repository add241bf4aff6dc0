//! The surface of the probe: how it reflects ambient and diffuse light.

use glam::DVec3;

/// Coefficients and colour of the probe's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Coefficient of ambient reflection: pi makes `L_a` the radiance of an environment, 0 leaves it out.
    pub k_a: f64,
    /// Coefficient of diffuse reflection.
    pub k_d: f64,
    /// Colour C, RGB.
    pub colour: DVec3,
}
