//! Rough descents from even starts, as in `../descent.rs`, but without second derivatives, and in longer strides.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::{array, mem};

use glam::DVec3;
use nalgebra::DMatrix;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::place::Places;
use super::turn::Turn;
use crate::interrupt;
use crate::kernels::fit::descent::{LEAST_DAMPING, STIFF, STIFFEST};
use crate::kernels::fit::lanes::LANES;
use crate::kernels::fit::objective::Objective;
use crate::kernels::fit::problem::Problem;
use crate::kernels::fit::state::{FIRST_DAMPING, RESOLUTION, State};
use crate::kernels::fit::wide::{Matrix, Wide};

/// Starts that share the lanes, one after the other. The last ones run beside empty lanes, but two threads have work: of
/// twice as many, one thread does .94 of the work for 8 lights, and the other none.
pub const IN_A_QUEUE: usize = 2 * LANES;

/// Where a descent has led.
#[derive(Clone, Debug)]
pub struct Rough {
    pub directions: Vec<DVec3>,
    /// Inner products of the columns; radiances, a column for each channel.
    pub gram: DMatrix<f64>,
    pub x: DMatrix<f64>,
    pub cost: f64,
    pub steps: usize,
}

impl Places {
    /// Where the descent in a lane has led; its directions leave the lane.
    fn end(&mut self, lane: usize, steps: usize) -> Rough {
        let of_lane = |matrix: &Matrix| {
            DMatrix::from_fn(matrix.columns(), matrix.rows(), |column, row| matrix[(row, column)].0[lane])
        };
        let directions = mem::take(&mut self.sets[lane]);
        Rough { directions, gram: of_lane(&self.gram), x: of_lane(&self.x), cost: self.cost.0[lane], steps }
    }
}

impl Rough {
    /// The same place, ready for finer steps.
    pub fn state(&self, objective: &dyn Objective) -> State {
        State::at(objective, objective.moments(self.directions.clone()), self.steps, &[])
    }
}

/// From each of the `starts` downhill, until a step lowers the cost by less than the share `tolerance` of it. None where
/// the objective does not know of lights side by side.
pub fn descents(problem: &Problem<'_>, starts: &[Vec<DVec3>], tolerance: f64) -> Option<Vec<Rough>> {
    let descents = starts.par_chunks(IN_A_QUEUE).map(|starts| Descents { problem, starts, tolerance });
    let ends: Option<Vec<Vec<Rough>>> = descents.map(|descents| Arch::new().dispatch(descents)).collect();
    ends.map(|ends| ends.into_iter().flatten().collect())
}

/// Starts that wait for a lane.
struct Descents<'a> {
    problem: &'a Problem<'a>,
    starts: &'a [Vec<DVec3>],
    tolerance: f64,
}

/// The descent in a lane.
#[derive(Clone)]
struct Lane {
    /// Which start it is; none where no more is left.
    start: Option<usize>,
    damping: f64,
    /// The turn that is tried, or led here; none at the start, and where the last one led uphill.
    turn: Option<Turn>,
    /// Whether the last step led uphill.
    has_failed: bool,
    steps: usize,
    /// Whether the last step gained little.
    is_done: bool,
}

/// All lanes under way.
struct Running {
    lanes: [Lane; LANES],
    places: Places,
    /// The start that waits longest.
    next: usize,
    ends: Vec<Option<Rough>>,
}

/// Where lanes may go on.
struct Tried {
    sets: [Vec<DVec3>; LANES],
    used: Matrix,
    /// Lanes that have a new start.
    is_new: [bool; LANES],
}

impl WithSimd for Descents<'_> {
    type Output = Option<Vec<Rough>>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Problem { objective, fixed, .. } = *self.problem;
        let mut running = self.begun(simd)?;
        loop {
            interrupt::check();
            let tried = self.tried(simd, &mut running);
            if running.lanes.iter().all(|lane| lane.start.is_none()) {
                return running.ends.into_iter().collect();
            }
            let next = Places::at(simd, objective, tried.sets, fixed, tried.used)?;
            let (before, after) = (running.places.cost.0, next.cost.0);
            let goes_on = array::from_fn(|i| {
                tried.is_new[i] || running.lanes[i].steps_down(before[i], after[i], self.tolerance)
            });
            running.places.take(simd, next, goes_on);
        }
    }
}

impl Descents<'_> {
    /// The first starts.
    #[inline(always)]
    fn begun<S: Simd>(&self, simd: S) -> Option<Running> {
        let Problem { objective, fixed, .. } = *self.problem;
        let given = objective.given();
        let lanes: [Lane; LANES] = array::from_fn(|i| Lane::new(i, self.starts.len()));
        let columns = given.ambient.coefficients() + self.starts[0].len();
        let mut used = Matrix::zeros(given.channels.len(), columns);
        (0..LANES).for_each(|i| used.fill_lane(i, lanes[i].uses()));
        let sets = lanes.each_ref().map(|lane| self.directions(lane));
        let places = Places::at(simd, objective, sets, fixed, used)?;
        Some(Running { lanes, places, next: LANES, ends: vec![None; self.starts.len()] })
    }

    /// A step from each place. A lane that has come to its end goes on with the next start.
    #[inline(always)]
    fn tried<S: Simd>(&self, simd: S, running: &mut Running) -> Tried {
        let fixed = self.problem.fixed;
        let Running { lanes, places, next, ends } = running;
        let (step, fall) = places.model.step(simd, Wide(lanes.each_ref().map(|lane| lane.damping)));
        let sets = array::from_fn(|i| lanes[i].turned(places, i, &step, fixed));
        let mut tried = Tried { sets, used: places.used.clone(), is_new: [false; LANES] };
        for (i, lane) in lanes.iter_mut().enumerate() {
            if let Some(start) = lane.start.filter(|_| self.has_ended(lane, places.cost.0[i], fall.0[i])) {
                ends[start] = Some(places.end(i, lane.steps));
                *lane = Lane::new(*next, self.starts.len());
                *next += 1;
                (tried.sets[i], tried.is_new[i]) = (self.directions(lane), true);
                tried.used.fill_lane(i, lane.uses());
            }
        }
        tried
    }

    /// Where a lane starts.
    fn directions(&self, lane: &Lane) -> Vec<DVec3> {
        lane.start.map_or(Vec::new(), |start| self.starts[start].clone())
    }

    /// Whether a step that promises this `fall` of the cost is not worth the try.
    fn has_ended(&self, lane: &Lane, cost: f64, fall: f64) -> bool {
        let Problem { objective, max_steps, .. } = *self.problem;
        let is_worth_it = fall > 0.1 * self.tolerance * cost && cost > RESOLUTION * objective.given().energy;
        lane.is_done || lane.damping >= STIFFEST || lane.steps >= max_steps || !is_worth_it
    }
}

impl Lane {
    /// From a start, unless there are no more.
    fn new(start: usize, starts: usize) -> Self {
        let start = (start < starts).then_some(start);
        Self { start, damping: FIRST_DAMPING, turn: None, has_failed: false, steps: 0, is_done: false }
    }

    /// 1 where its columns are used at first, 0 where it is left out.
    fn uses(&self) -> f64 {
        f64::from(u8::from(self.start.is_some()))
    }

    /// The directions after its next turn.
    fn turned(&mut self, places: &Places, lane: usize, step: &[Wide], fixed: usize) -> Vec<DVec3> {
        let (turn, directions) = Turn::after(self.turn.as_ref(), places, lane, step, fixed);
        self.turn = Some(turn);
        directions
    }

    /// Whether the turn that is tried leads down, and what follows from it.
    fn steps_down(&mut self, cost: f64, next: f64, tolerance: f64) -> bool {
        if next >= cost || next.is_nan() {
            // The step alone may still lead down where a longer stride does not.
            if self.turn.take().is_none_or(|turn| turn.stride <= 1.0) {
                self.damping *= 10.0;
                self.has_failed = true;
            }
            return false;
        }
        // What has just failed will fail again.
        let ease = if self.has_failed { 0.3 } else { 0.1 };
        self.damping = (self.damping * ease).max(LEAST_DAMPING);
        self.has_failed = false;
        self.steps += 1;
        self.is_done = cost - next <= tolerance * cost && self.damping < STIFF;
        true
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::{Ambient, Sphere};
    use crate::kernels::image;
    use crate::kernels::sphere::Registration;
    use ndarray::Array3;

    /// Waves, and hot pixels of several colours.
    fn sphere(ambient: Ambient) -> Sphere {
        let map = Array3::from_shape_fn((32, 64, 3), |(y, x, c)| {
            let hot = if (y, x % 20) == (9 + x / 8, 7 + c) { 400.0 } else { 0.0 };
            (1.0 + (0.2 * x as f64).sin() + hot) as f32
        });
        let working = image::reduce(map.view(), Registration::CellCentred, 256, 3e-3, false).unwrap();
        Sphere::new(&working, ambient, false)
    }

    /// The first light stays.
    fn problem(sphere: &Sphere) -> Problem<'_> {
        Problem { objective: sphere, start: &[], fixed: 1, lights: 4, error: None, max_steps: 100 }
    }

    fn starts(count: usize) -> Vec<Vec<DVec3>> {
        let direction = |i: usize| {
            let [x, y, z] = [1.3, 2.1, 3.7].map(|turn| (turn * (i + 1) as f64).sin());
            DVec3::new(x, y, z).normalize()
        };
        (0..count).map(|start| (0..4).map(|light| direction(4 * start + light)).collect()).collect()
    }

    /// And end where they say, below their start.
    #[test]
    fn strides_lead_lower_than_the_steps_of_a_start_alone() {
        const TOLERANCE: f64 = 4e-2;
        for ambient in [Ambient::None, Ambient::Constant] {
            let sphere = sphere(ambient);
            let (problem, starts) = (problem(&sphere), starts(60));
            let (mut steps, mut gain) = ([0, 0], 0.0);
            for (start, end) in starts.iter().zip(descents(&problem, &starts, TOLERANCE).unwrap()) {
                let first = State::new(&sphere, start);
                assert!(end.steps > 0 && end.cost < first.cost);
                assert_eq!(end.directions[0], start[0]);
                assert!((end.state(&sphere).cost - end.cost).abs() < 1e-9 * sphere.given().energy);
                let alone = first.descend(&problem, TOLERANCE);
                steps[0] += end.steps;
                steps[1] += alone.steps;
                gain += (alone.cost / end.cost).ln();
            }
            assert!(steps[0] < steps[1], "{ambient:?} {steps:?}");
            assert!(gain > 0.0, "{ambient:?} {gain}");
        }
    }

    #[test]
    fn lanes_see_of_each_other_rounding_alone() {
        let sphere = sphere(Ambient::Constant);
        let (problem, starts) = (problem(&sphere), starts(17));
        let together = descents(&problem, &starts, 1e-2).unwrap();
        for (start, together) in starts.chunks(1).zip(together) {
            let alone = descents(&problem, start, 1e-2).unwrap().remove(0);
            assert!((alone.cost - together.cost).abs() < 1e-9 * sphere.given().energy);
            let directions = alone.directions.iter().zip(&together.directions);
            directions.for_each(|(alone, together)| assert!(alone.distance(*together) < 1e-7));
        }
    }

    #[test]
    fn harmonics_and_floors_do_not_go_side_by_side() {
        let sphere = sphere(Ambient::Sh2);
        assert!(descents(&problem(&sphere), &starts(2), 1e-2).is_none());
    }
}
