//! Opposite normals share one sum.
//!
//! What `n` does not see, `-n` sees. So their irradiances differ by the vector flux of the whole map,
//!
//! ```text
//!   E(n) - E(-n) = integral of L n.w dw = n.F,   F = integral of L w dw
//! ```
//!
//! and the faces of an icosphere, which lie opposite each other, need half of the look-ups.

use std::collections::HashMap;

use glam::DVec3;

/// Normals without those that lie opposite another, and how to get those back.
pub struct Pairs {
    pub kept: Vec<DVec3>,
    /// For each normal the index of its kept one, and whether that is its opposite.
    sources: Vec<(usize, bool)>,
}

/// Opposite up to the rounding of a unit vector; a pair that is missed costs time, not accuracy.
pub fn pairs(normals: &[DVec3]) -> Pairs {
    const CELLS: f64 = (1_u64 << 40) as f64;
    let cell = |n: DVec3| (n * CELLS).round().to_array().map(|x| x as i64);
    let mut kept = Vec::new();
    let mut indices = HashMap::new();
    let mut find = |&normal: &DVec3| {
        if let Some(&index) = indices.get(&cell(-normal)) {
            return (index, true);
        }
        indices.insert(cell(normal), kept.len());
        kept.push(normal);
        (kept.len() - 1, false)
    };
    let sources = normals.iter().map(&mut find).collect();
    Pairs { kept, sources }
}

impl Pairs {
    /// Irradiance at all normals from that at the kept ones and from the vector flux, `whole`.
    pub fn restore(&self, seen: &[DVec3], whole: [DVec3; 3]) -> Vec<DVec3> {
        let restore = |&(index, is_opposite): &(usize, bool)| {
            let n = self.kept[index];
            let behind = whole[0] * n.x + whole[1] * n.y + whole[2] * n.z;
            // Rounding must not make darkness negative.
            (if is_opposite { seen[index] - behind } else { seen[index] }).max(DVec3::ZERO)
        };
        self.sources.iter().map(restore).collect()
    }
}
