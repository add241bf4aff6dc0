//! How many lights there may be: the dimmest are dropped, neighbours are merged.
//!
//! Ward's linkage (1963) with the flux as weight: merge the two lights that move least light,
//!
//! ```text
//!   cost = F_1 F_2 / (F_1 + F_2) * |d_1 - d_2|^2
//! ```
//!
//! which is what the merger adds to the flux-weighted sum of squared distances.

use super::light::Light;

/// Lights beyond this many are merged into the nearest brighter one: pairs are quadratic.
const MOST_IN_PAIRS: usize = 2048;

/// Lights, most flux first, and what became of those that were measured.
pub struct Choice {
    /// Most flux first.
    pub lights: Vec<Light>,
    /// For each light that was measured, the one that it is part of, if any.
    pub part_of: Vec<Option<usize>>,
    /// Lights that were dropped.
    pub dropped: usize,
}

/// At most `most` of `measured`, none with less flux than `least_flux`.
pub fn choose(measured: Vec<Light>, least_flux: f64, most: usize) -> Choice {
    let mut ranked: Vec<usize> = (0..measured.len()).filter(|&i| measured[i].flux >= least_flux).collect();
    ranked.sort_by(|&i, &j| measured[j].flux.total_cmp(&measured[i].flux));
    let kept: Vec<Light> = ranked.iter().map(|&i| measured[i].clone()).collect();
    let (lights, merged_into) = merge(kept, most);
    let mut part_of = vec![None; measured.len()];
    for (&i, light) in ranked.iter().zip(merged_into) {
        part_of[i] = Some(light);
    }
    Choice { lights, part_of, dropped: measured.len() - ranked.len() }
}

/// `lights`, most flux first, as at most `most`, and for each the one that it became part of.
fn merge(lights: Vec<Light>, most: usize) -> (Vec<Light>, Vec<usize>) {
    let mut linkage = Linkage::new(lights);
    if linkage.alive > most {
        linkage.merge_the_rest(MOST_IN_PAIRS.max(most));
        linkage.find_nearest();
    }
    while linkage.alive > most {
        linkage.merge_nearest();
    }
    linkage.finish()
}

struct Linkage {
    /// `None` once it is part of another.
    lights: Vec<Option<Light>>,
    alive: usize,
    part_of: Vec<usize>,
    /// For each light the cost of the cheapest merger with a later one, and which.
    nearest: Vec<(f64, usize)>,
}

impl Linkage {
    fn new(lights: Vec<Light>) -> Self {
        let alive = lights.len();
        let lights: Vec<Option<Light>> = lights.into_iter().map(Some).collect();
        Self { lights, alive, part_of: (0..alive).collect(), nearest: vec![(f64::INFINITY, 0); alive] }
    }

    /// Merge the lights from `first` on into the nearest of those before it.
    fn merge_the_rest(&mut self, first: usize) {
        for i in first..self.lights.len() {
            let distance = |j: &usize| self.distance_squared(i, *j);
            if let Some(nearest) = (0..first).min_by(|i, j| distance(i).total_cmp(&distance(j))) {
                self.merge(nearest, i);
            }
        }
    }

    fn find_nearest(&mut self) {
        for i in 0..self.lights.len() {
            self.nearest[i] = self.nearest_after(i);
        }
    }

    fn nearest_after(&self, i: usize) -> (f64, usize) {
        let later = (i + 1..self.lights.len()).map(|j| (self.cost(i, j), j));
        later.min_by(|one, other| one.0.total_cmp(&other.0)).unwrap_or((f64::INFINITY, i))
    }

    fn merge_nearest(&mut self) {
        let cheapest =
            (0..self.lights.len()).min_by(|&i, &j| self.nearest[i].0.total_cmp(&self.nearest[j].0));
        let Some(i) = cheapest else { return };
        let j = self.nearest[i].1;
        self.merge(i, j);
        // A merger of Ward's never comes nearer to a third light than the nearer of the two was:
        // only those that pointed to one of them look again.
        for other in 0..self.lights.len() {
            if other == i || other == j || [i, j].contains(&self.nearest[other].1) {
                self.nearest[other] = self.nearest_after(other);
            }
        }
    }

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

    /// The lights that are left, most flux first.
    fn finish(self) -> (Vec<Light>, Vec<usize>) {
        let mut left: Vec<(usize, Light)> =
            self.lights.into_iter().enumerate().filter_map(|(i, light)| Some((i, light?))).collect();
        left.sort_by(|(_, one), (_, other)| other.flux.total_cmp(&one.flux));
        let mut place = vec![0; self.part_of.len()];
        for (rank, (i, _)) in left.iter().enumerate() {
            place[*i] = rank;
        }
        let whole = |mut i: usize| {
            while self.part_of[i] != i {
                i = self.part_of[i];
            }
            place[i]
        };
        let merged_into = (0..self.part_of.len()).map(whole).collect();
        (left.into_iter().map(|(_, light)| light).collect(), merged_into)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::sphere::direction;

    /// Further along a quarter of a circle for each of its fluxes.
    fn light(flux: f64) -> Light {
        Light::towards(direction(1.0 + 0.1 * flux.sqrt(), 2.0), flux)
    }

    #[test]
    fn neighbours_are_merged_and_the_dimmer_of_two_pairs_first() {
        let at = |phi, flux| Light::towards(direction(1.0, phi), flux);
        let far_and_near = vec![at(0.0, 3.0), at(3.0, 5.0), at(3.1, 2.0), at(0.1, 1.0)];
        let three = choose(far_and_near.clone(), 0.0, 3);
        assert_eq!(three.part_of, [Some(1), Some(0), Some(2), Some(1)]);
        let two = choose(far_and_near, 0.0, 2);
        assert_eq!(two.part_of, [Some(1), Some(0), Some(0), Some(1)]);
        assert!((two.lights[0].flux - 7.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_merged_within_the_budget() {
        let choice = choose(vec![Light::default(); 3], 0.0, 3);
        assert_eq!(choice.lights.len(), 3);
        assert_eq!(choice.part_of, [Some(0), Some(1), Some(2)]);
    }

    #[test]
    fn what_is_too_dim_is_dropped_before_the_rest_is_merged() {
        let choice = choose(vec![light(1.0), light(5.0), light(0.1), light(2.0)], 0.5, 2);
        assert_eq!(choice.dropped, 1);
        assert_eq!(choice.part_of[2], None);
        assert_eq!(choice.lights.len(), 2);
        let flux: f64 = choice.lights.iter().map(|light| light.flux).sum();
        assert!((flux - 8.0).abs() < 1e-12, "{flux}");
    }

    #[test]
    fn more_lights_than_pairs_can_be_compared_are_merged_all_the_same() {
        let choice = choose((1..=MOST_IN_PAIRS + 500).map(|i| light(i as f64)).collect(), 0.0, 7);
        assert_eq!(choice.lights.len(), 7);
        let flux: f64 = choice.lights.iter().map(|light| light.flux).sum();
        let wanted = (MOST_IN_PAIRS + 500) * (MOST_IN_PAIRS + 501) / 2;
        assert!((flux - wanted as f64).abs() < 1e-3, "{flux} {wanted}");
    }
}
