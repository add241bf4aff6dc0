//! Arcs of a circle, as intersections of intervals of its angle.

use std::f64::consts::TAU;

/// Disjoint arcs of one circle, each with its first angle and its length, in radians.
#[derive(Clone, Debug)]
pub struct Arcs(Vec<(f64, f64)>);

impl Arcs {
    /// The whole circle.
    pub fn whole() -> Self {
        Self(vec![(0.0, TAU)])
    }

    /// Remove everything.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// First angle and length of each arc.
    pub fn iter(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.0.iter().copied()
    }

    /// Keep the parts in the arc from `start` over `length`, which is at most a whole turn.
    pub fn intersect(&mut self, start: f64, length: f64) {
        if let [(_, TAU)] = self.0[..] {
            self.0[0] = (start, length);
            return;
        }
        let parts = self.0.iter().flat_map(|&(first, extent)| {
            // Angles are counted from `start`; the arc lies in the first turn, and may reach the second.
            let from = (first - start).rem_euclid(TAU);
            let to = from + extent;
            [(from, to.min(length)), (TAU, to.min(TAU + length))].map(|(low, high)| (start + low, high - low))
        });
        self.0 = parts.filter(|&(_, extent)| extent > 0.0).collect();
    }
}
