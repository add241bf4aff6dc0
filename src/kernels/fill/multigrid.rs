//! Multigrid for Laplace's equation in wide holes (Trottenberg, Oosterlee and Schüller 2001, "Multigrid", chapter 2).
//!
//! The cascade of `harmonic_fill.rs` corrects an image only near the rims of its holes. That is enough behind a lamp. In
//! half a sphere its radiance is off by up to a factor, so V-cycles solve the equation there. Near the poles pixels
//! are narrow, so whole rows are relaxed at once.

use glam::{DVec3, Vec3A};
use rayon::prelude::*;

use super::row_relaxation::RowRelaxation;
use crate::interrupt;
use crate::kernels::image::Grid;

/// Settings of the V-cycles.
struct CycleSettings {
    /// Pairs of sweeps, down and up, before and after each correction.
    sweeps: usize,
    /// Pairs of sweeps of the coarsest stage.
    coarsest_sweeps: usize,
    /// Least number of rows of the coarsest stage.
    least_rows: usize,
    /// Relative change of the fill in one cycle at which it is solved. Errors of the probe are a hundredth of it.
    tolerance: f64,
    /// Largest number of cycles.
    most: usize,
}

const CYCLES: CycleSettings =
    CycleSettings { sweeps: 1, coarsest_sweeps: 16, least_rows: 4, tolerance: 1e-4, most: 40 };

/// Solve Laplace's equation in the holes of an image, from the values in them; the others are known.
pub fn solve(grid: Grid, is_hole: Vec<bool>, values: &mut [Vec3A]) {
    let stages = stages(grid, is_hole);
    let channels: Vec<Vec<f64>> = (0..3_usize)
        .into_par_iter()
        .map(|channel| {
            let mut image: Vec<f64> = values.iter().map(|value| f64::from(value[channel])).collect();
            solve_channel(&stages, &mut image);
            image
        })
        .collect();
    for run in &stages[0].runs {
        for at in stages[0].pixels(run) {
            values[at] = DVec3::from_array([0, 1, 2].map(|c| channels[c][at])).max(DVec3::ZERO).as_vec3a();
        }
    }
}

/// The image and coarser ones, down to the coarsest that has holes.
fn stages(grid: Grid, is_hole: Vec<bool>) -> Vec<RowRelaxation> {
    let mut stages = vec![RowRelaxation::new(grid, is_hole)];
    while stages[stages.len() - 1].size.0 > CYCLES.least_rows {
        let coarser = stages[stages.len() - 1].coarser();
        if coarser.runs.is_empty() {
            break;
        }
        stages.push(coarser);
    }
    stages
}

/// Repeat V-cycles until the fill no longer changes.
fn solve_channel(stages: &[RowRelaxation], image: &mut [f64]) {
    let source = vec![0.0; image.len()];
    for _ in 0..CYCLES.most {
        let before = image.to_vec();
        cycle(stages, image, &source);
        let (mut change, mut whole) = (0.0, 0.0);
        for (before, after) in before.iter().zip(&*image) {
            change += (after - before).abs();
            whole += after.abs();
        }
        if change <= CYCLES.tolerance * whole {
            return;
        }
    }
}

/// One V-cycle: relax, correct by the coarser stages, relax.
fn cycle(stages: &[RowRelaxation], image: &mut [f64], source: &[f64]) {
    interrupt::check();
    let Some((stage, coarser)) = stages.split_first() else { return };
    let Some(next) = coarser.first() else {
        return (0..CYCLES.coarsest_sweeps).for_each(|_| stage.relax(image, source));
    };
    (0..CYCLES.sweeps).for_each(|_| stage.relax(image, source));
    let residual = stage.restrict_residual(next, image, source);
    let mut correction = vec![0.0; residual.len()];
    cycle(coarser, &mut correction, &residual);
    stage.add_correction(next, &correction, image);
    (0..CYCLES.sweeps).for_each(|_| stage.relax(image, source));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::sphere::Registration;
    use std::f64::consts::PI;

    const SIZE: (usize, usize) = (64, 128);

    /// Largest error of a harmonic function of the polar angle and the azimuth in the holes of an image.
    fn largest_error(
        harmonic: impl Fn(f64, f64) -> f64,
        registration: Registration,
        is_hole: impl Fn(usize, usize) -> bool,
    ) -> f64 {
        let grid = Grid::of_pixels(SIZE.0, SIZE.1, registration);
        let middle = |edges: &[f64], at: usize| 0.5 * (edges[at] + edges[at + 1]);
        let expected: Vec<f64> = (0..SIZE.0 * SIZE.1)
            .map(|at| harmonic(middle(&grid.theta_edges, at / SIZE.1), middle(&grid.phi_edges, at % SIZE.1)))
            .collect();
        let holes: Vec<bool> = (0..expected.len()).map(|at| is_hole(at / SIZE.1, at % SIZE.1)).collect();
        let start =
            |(&value, &hole): (&f64, &bool)| if hole { Vec3A::ZERO } else { Vec3A::splat(value as f32) };
        let mut values: Vec<Vec3A> = expected.iter().zip(&holes).map(start).collect();
        solve(grid, holes, &mut values);
        let error = |(value, expected): (&Vec3A, &f64)| (f64::from(value.x) - expected).abs();
        values.iter().zip(&expected).map(error).fold(0.0, f64::max)
    }

    /// The wave `tan(theta / 2) cos phi` solves Laplace's equation on the sphere.
    fn wave(theta: f64, phi: f64) -> f64 {
        2.0 + (0.5 * theta).tan() * phi.cos()
    }

    #[test]
    fn a_harmonic_wave_is_continued_over_a_pole() {
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            let error = largest_error(wave, registration, |row, _| row < 32);
            assert!(error < 2e-3, "{error}");
        }
    }

    #[test]
    fn half_a_sphere_that_is_cut_by_the_seam_is_solved() {
        // Sources beyond the horizon of the hole: the logarithm of the tangent, without its poles.
        let fall = |theta: f64, phi: f64| 3.0 + wave(theta, phi) - (0.5 * theta).tan().ln() / PI;
        let error = largest_error(fall, Registration::CellCentred, |row, column| {
            (8..56).contains(&row) && !(32..96).contains(&column) && theta_of(row) < 0.7 * PI
        });
        assert!(error < 2e-3, "{error}");
    }

    fn theta_of(row: usize) -> f64 {
        PI * (row as f64 + 0.5) / SIZE.0 as f64
    }

    #[test]
    fn all_but_a_ring_is_filled_with_what_the_ring_has() {
        let error = largest_error(|_, _| 0.3, Registration::CellCentred, |row, _| row != 20);
        assert!(error < 1e-4, "{error}");
        let error =
            largest_error(|_, _| 0.3, Registration::BorderSampled, |row, column| row != 20 || column != 77);
        assert!(error < 1e-2, "{error}");
    }
}
