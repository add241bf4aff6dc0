//! Selection of lights: the dimmest are dropped, then neighbours are merged down to the largest number of lights.
//!
//! Mergers follow Ward's linkage (1963) with the flux as weight. Each step merges the two lights of the lowest cost
//!
//! ```text
//!   cost = F_1 F_2 / (F_1 + F_2) * |d_1 - d_2|^2
//! ```
//!
//! which is the growth of the flux-weighted sum of squared distances.

use super::light_moments::LightMoments;

/// Number of lights from which on each is merged into the nearest brighter one. Without it, time grows with the square
/// of the number of lights.
const MOST_IN_PAIRS: usize = 2048;

/// The selected lights, and the light that each measured one became part of.
pub struct Selection {
    /// Most flux first.
    pub lights: Vec<LightMoments>,
    /// For each measured light, the selected one that it is part of, if any.
    pub part_of: Vec<Option<usize>>,
    /// Lights that were dropped.
    pub dropped: usize,
    /// Lights that became part of another.
    pub merged: usize,
}

impl Selection {
    /// For each selected light, true if any of its `parts` is; all are false if `parts` is empty.
    pub fn any_of_parts(&self, parts: &[bool]) -> Vec<bool> {
        let mut any = vec![false; self.lights.len()];
        let chosen = self.part_of.iter().zip(parts).filter(|(_, part)| **part);
        for light in chosen.filter_map(|(light, _)| *light) {
            any[light] = true;
        }
        any
    }
}

/// Select at most `most` lights from those of `measured` that are `listed`.
pub fn select(measured: Vec<LightMoments>, listed: &[bool], most: usize) -> Selection {
    // Drop the others and rank these.
    let mut ranked: Vec<usize> = (0..measured.len()).filter(|&i| listed[i]).collect();
    ranked.sort_by(|&i, &j| LightMoments::most_flux_first(&measured[i], &measured[j]));
    // Merge neighbours.
    let brightest: Vec<LightMoments> = ranked.iter().map(|&i| measured[i].clone()).collect();
    let (lights, merged_into) = merge(brightest, most);
    // Note for each measured light the one that it became part of.
    let mut part_of = vec![None; measured.len()];
    for (&i, light) in ranked.iter().zip(merged_into) {
        part_of[i] = Some(light);
    }
    let (dropped, merged) = (measured.len() - ranked.len(), ranked.len() - lights.len());
    Selection { lights, part_of, dropped, merged }
}

/// Merge `lights`, most flux first, down to `most`; also return for each of them the one that it became part of.
fn merge(lights: Vec<LightMoments>, most: usize) -> (Vec<LightMoments>, Vec<usize>) {
    let mut linkage = Linkage::new(lights);
    if linkage.alive > most {
        linkage.merge_from(MOST_IN_PAIRS.max(most));
        linkage.find_nearest();
    }
    while linkage.alive > most {
        linkage.merge_nearest();
    }
    linkage.finish()
}

struct Linkage {
    /// Lights that are not part of another yet; `None` for the others.
    lights: Vec<Option<LightMoments>>,
    alive: usize,
    part_of: Vec<usize>,
    /// For each light, the cost of the cheapest merger with a later one, and its index.
    nearest: Vec<(f64, usize)>,
}

impl Linkage {
    fn new(lights: Vec<LightMoments>) -> Self {
        let alive = lights.len();
        let lights: Vec<Option<LightMoments>> = lights.into_iter().map(Some).collect();
        Self { lights, alive, part_of: (0..alive).collect(), nearest: vec![(f64::INFINITY, 0); alive] }
    }

    /// Merge the lights from `first` on into the nearest of those before it.
    fn merge_from(&mut self, first: usize) {
        for i in first..self.lights.len() {
            let distance = |j: &usize| self.distance_squared(i, *j);
            if let Some(nearest) = (0..first).min_by(|i, j| distance(i).total_cmp(&distance(j))) {
                self.merge(nearest, i);
            }
        }
    }

    /// Find the cheapest merger of each light with a later one.
    fn find_nearest(&mut self) {
        for i in 0..self.lights.len() {
            self.nearest[i] = self.nearest_after(i);
        }
    }

    fn nearest_after(&self, i: usize) -> (f64, usize) {
        let later = (i + 1..self.lights.len()).map(|j| (self.cost(i, j), j));
        later.min_by(|one, other| one.0.total_cmp(&other.0)).unwrap_or((f64::INFINITY, i))
    }

    /// Merge the two lights whose merger costs least.
    fn merge_nearest(&mut self) {
        // Find the cheapest merger.
        let cheapest =
            (0..self.lights.len()).min_by(|&i, &j| self.nearest[i].0.total_cmp(&self.nearest[j].0));
        let Some(i) = cheapest else { return };
        let j = self.nearest[i].1;
        self.merge(i, j);
        // Update the cheapest mergers of lights that pointed to one of the two. With Ward's cost, the union is never
        // nearer to a third light than the nearer one of the two was.
        for other in 0..self.lights.len() {
            if other == i || other == j || [i, j].contains(&self.nearest[other].1) {
                self.nearest[other] = self.nearest_after(other);
            }
        }
    }

    /// Merge `other` into `into`.
    fn merge(&mut self, into: usize, other: usize) {
        let (Some(one), Some(two)) = (&self.lights[into], &self.lights[other]) else { return };
        self.lights[into] = Some(one.and(two));
        self.lights[other] = None;
        self.part_of[other] = into;
        self.alive -= 1;
    }

    fn distance_squared(&self, i: usize, j: usize) -> f64 {
        match (&self.lights[i], &self.lights[j]) {
            (Some(one), Some(other)) => one.direction().distance_squared(other.direction()),
            _ => f64::INFINITY,
        }
    }

    fn cost(&self, i: usize, j: usize) -> f64 {
        match (&self.lights[i], &self.lights[j]) {
            (Some(one), Some(other)) => {
                one.flux * other.flux / (one.flux + other.flux) * self.distance_squared(i, j)
            }
            _ => f64::INFINITY,
        }
    }

    /// The remaining lights, most flux first; and for each original light, the index of its light among them.
    fn finish(self) -> (Vec<LightMoments>, Vec<usize>) {
        // Rank the remaining lights.
        let mut remaining: Vec<(usize, LightMoments)> =
            self.lights.into_iter().enumerate().filter_map(|(i, light)| Some((i, light?))).collect();
        remaining.sort_by(|(_, one), (_, other)| LightMoments::most_flux_first(one, other));
        let mut rank_of = vec![0; self.part_of.len()];
        for (rank, (i, _)) in remaining.iter().enumerate() {
            rank_of[*i] = rank;
        }
        // Follow each merger up to a remaining light.
        let root = |mut i: usize| {
            while self.part_of[i] != i {
                i = self.part_of[i];
            }
            rank_of[i]
        };
        let merged_into = (0..self.part_of.len()).map(root).collect();
        (remaining.into_iter().map(|(_, light)| light).collect(), merged_into)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::sphere::direction;

    /// A light whose position depends on its flux.
    fn light(flux: f64) -> LightMoments {
        LightMoments::towards(direction(1.0 + 0.1 * flux.sqrt(), 2.0), flux)
    }

    #[test]
    fn the_dimmer_of_two_pairs_of_neighbours_is_merged_first() {
        let at = |phi, flux| LightMoments::towards(direction(1.0, phi), flux);
        let far_and_near = vec![at(0.0, 3.0), at(3.0, 5.0), at(3.1, 2.0), at(0.1, 1.0)];
        let three = select(far_and_near.clone(), &[true; 4], 3);
        assert_eq!(three.part_of, [Some(1), Some(0), Some(2), Some(1)]);
        let two = select(far_and_near, &[true; 4], 2);
        assert_eq!(two.part_of, [Some(1), Some(0), Some(0), Some(1)]);
        assert!((two.lights[0].flux - 7.0).abs() < 1e-12);
    }

    #[test]
    fn few_lights_are_not_merged() {
        let selection = select(vec![LightMoments::default(); 3], &[true; 3], 3);
        assert_eq!(selection.lights.len(), 3);
        assert_eq!(selection.part_of, [Some(0), Some(1), Some(2)]);
        assert_eq!((selection.dropped, selection.merged), (0, 0));
    }

    #[test]
    fn lights_that_are_not_listed_are_dropped_before_the_others_are_merged() {
        let lights = vec![light(1.0), light(5.0), light(0.1), light(2.0)];
        let selection = select(lights, &[true, true, false, true], 2);
        assert_eq!((selection.dropped, selection.merged), (1, 1));
        assert_eq!(selection.part_of[2], None);
        assert_eq!(selection.lights.len(), 2);
        let flux: f64 = selection.lights.iter().map(|light| light.flux).sum();
        assert!((flux - 8.0).abs() < 1e-12, "{flux}");
    }

    #[test]
    fn too_many_lights_to_compare_all_pairs_are_merged_too() {
        let lights: Vec<LightMoments> = (1..=MOST_IN_PAIRS + 500).map(|i| light(i as f64)).collect();
        let listed = vec![true; lights.len()];
        let selection = select(lights, &listed, 7);
        assert_eq!(selection.lights.len(), 7);
        let flux: f64 = selection.lights.iter().map(|light| light.flux).sum();
        let expected = (MOST_IN_PAIRS + 500) * (MOST_IN_PAIRS + 501) / 2;
        assert!((flux - expected as f64).abs() < 1e-3, "{flux} {expected}");
    }
}
