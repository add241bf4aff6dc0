//! Arcs of a circle, as intersections of intervals of its angle.

use std::f64::consts::TAU;

/// Disjoint arcs of one circle, each with its first angle and its length, in radians.
#[derive(Clone, Debug, Default)]
pub struct Arcs(Vec<(f64, f64)>);

impl Arcs {
    /// Replace all arcs by one.
    #[inline]
    pub fn reset(&mut self, arc: (f64, f64)) {
        self.0.clear();
        self.0.push(arc);
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
    #[inline]
    pub fn intersect(&mut self, start: f64, length: f64) {
        if let [(_, TAU)] = self.0[..] {
            self.0[0] = (start, length);
            return;
        }
        for index in (0..self.0.len()).rev() {
            let (first, extent) = self.0.swap_remove(index);
            // Angles are counted from `start`; the arc lies in the first turn, and may reach the second.
            let turns = (first - start) / TAU;
            let from = TAU * (turns - turns.floor());
            let to = from + extent;
            for (low, high) in [(from, to.min(length)), (TAU, to.min(TAU + length))] {
                if high > low {
                    self.0.push((start + low, high - low));
                }
            }
        }
    }
}
