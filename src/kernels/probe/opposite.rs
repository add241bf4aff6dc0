//! One sum for two opposite normals.
//!
//! The half of the sphere behind `n` is in front of `-n`. So their irradiances differ by the vector flux of the map,
//!
//! ```text
//!   E(n) - E(-n) = integral of L n.w dw = n.F,   F = integral of L w dw
//! ```
//!
//! and the faces of an icosphere, which are opposite each other, need half of the look-ups.

use glam::DVec3;
use rustc_hash::FxHashMap;

/// The vector flux `F`: for each axis of the frame, RGB.
pub type VectorFlux = [DVec3; 3];

/// Normals without those opposite to another one, and the origin of each normal.
pub struct Pairs {
    /// One normal of each pair, and those without an opposite.
    pub distinct: Vec<DVec3>,
    /// For each normal, the index of its distinct one, and true if that is its opposite.
    origins: Vec<(usize, bool)>,
}

/// Find pairs of normals that are opposite up to rounding; a missed pair costs time, not accuracy.
pub fn pairs(normals: &[DVec3]) -> Pairs {
    let cells = (1_u64 << 40) as f64;
    let cell = |n: DVec3| (n * cells).round().to_array().map(|x| x as i64);
    let mut distinct = Vec::new();
    let mut indices = FxHashMap::default();
    let mut find = |&normal: &DVec3| {
        if let Some(&index) = indices.get(&cell(-normal)) {
            return (index, true);
        }
        indices.insert(cell(normal), distinct.len());
        distinct.push(normal);
        (distinct.len() - 1, false)
    };
    let origins = normals.iter().map(&mut find).collect();
    Pairs { distinct, origins }
}

impl Pairs {
    /// Irradiance at all normals, from that at the distinct ones and the vector flux of the map.
    pub fn restore(&self, irradiance: &[DVec3], flux: &VectorFlux) -> Vec<DVec3> {
        let restore = |&(index, is_opposite): &(usize, bool)| {
            let difference = if is_opposite { dot(self.distinct[index], flux) } else { DVec3::ZERO };
            // Rounding must not make darkness negative.
            (irradiance[index] - difference).max(DVec3::ZERO)
        };
        self.origins.iter().map(restore).collect()
    }
}

/// Indices of the normals with an irradiance of less than 1e-8 of the vector flux: a difference is mostly rounding.
///
/// Normals with a sum of their own may be among them.
pub fn rounding_only(restored: &[DVec3], flux: &VectorFlux) -> Vec<usize> {
    let least = 1e-8 * (flux[0].abs() + flux[1].abs() + flux[2].abs());
    (0..restored.len()).filter(|&i| restored[i].cmplt(least).any()).collect()
}

/// `n.F` of each channel, rounded once for each term.
pub fn dot(n: DVec3, flux: &VectorFlux) -> DVec3 {
    let [x, y, z] = *flux;
    z.mul_add(DVec3::splat(n.z), y.mul_add(DVec3::splat(n.y), x * n.x))
}

/// The three axes of the frame, then their opposites: the normals of [`flux_of_axes`].
pub const AXES: [DVec3; 6] = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];

/// The vector flux of a map from its irradiance at [`AXES`].
pub fn flux_of_axes(irradiance: &[DVec3]) -> VectorFlux {
    std::array::from_fn(|axis| irradiance[axis] - irradiance[axis + 3])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A source of the flux 1 in the direction d has `E(n) = max(0, n.d)` and `F = d`.
    #[test]
    fn opposites_come_back_from_the_flux() {
        let source = DVec3::new(0.48, 0.6, -0.64);
        let irradiance = |n: &DVec3| DVec3::new(1.0, 2.0, 0.0) * n.dot(source).max(0.0);
        let one = DVec3::new(0.6, -0.8, 0.0);
        let normals = [one, DVec3::Y, -one, DVec3::NEG_Y, DVec3::X, one];
        let pairs = pairs(&normals);
        assert_eq!(pairs.distinct, [one, DVec3::Y, DVec3::X, one]);
        let distinct: Vec<DVec3> = pairs.distinct.iter().map(irradiance).collect();
        let flux = flux_of_axes(&AXES.map(|axis| irradiance(&axis)));
        for (normal, restored) in normals.iter().zip(pairs.restore(&distinct, &flux)) {
            assert!((restored - irradiance(normal)).length() < 1e-15, "{normal}: {restored}");
        }
    }
}
