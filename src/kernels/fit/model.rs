//! What a rig looks like on a probe: equations 4 to 6 of Madsen et al. 2003, in physical scale.

use glam::DVec3;

use super::Rig;
use super::ambient::Ambient;

/// Irradiance of `rig` at `normal`.
pub fn irradiance(rig: &Rig, normal: DVec3) -> DVec3 {
    let columns = Ambient::with(rig.ambient.len()).unwrap_or(Ambient::None).irradiance(normal);
    let ambient = rig.ambient.iter().zip(columns).fold(DVec3::ZERO, |sum, (c, column)| sum + c * column);
    let lights = rig.directions.iter().zip(&rig.irradiance);
    lights.fold(ambient, |sum, (direction, irradiance)| sum + irradiance * normal.dot(*direction).max(0.0))
}
