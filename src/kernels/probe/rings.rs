//! The probe at normals that are cheap to look at: rings of one height, whole columns apart.
//!
//! All normals of a ring cut a row at the same width, at the same place within a column. So the horizon is
//! found once for each ring and row, and all look-ups of a ring read the sums of the row in their order.
//! The rings lie at the nodes of a Gauss-Legendre rule, the normals of a ring at even azimuths: judged at
//! 5120 of them the error of a rig is as near to that at all normals as at 5120 Hammersley points, where
//! even heights double its scatter. From ring to ring the normals are turned by the golden section of a
//! step, which spreads them evenly. Half of the rings are looked at; the others are opposite (`opposite.rs`).

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use ndarray::Axis;
use pulp::Arch;
use rayon::prelude::*;

use super::even::EvenColumns;
use super::opposite;
use super::runs::{Run, Sums};
use super::sources::under_sources;
use super::strips::{Ring, View};
use crate::error::{Error, Result};
use crate::kernels::image::{Grid, WorkingMap};
use crate::kernels::kept::Kept;

/// Rows of the map that one task sums.
const ROWS_OF_A_RUN: usize = 16;
/// `(sqrt 5 - 1) / 2`.
const GOLDEN_SECTION: f64 = 0.618_033_988_749_894_9;

/// Irradiance at normals that judge a rig.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Unit normals; the second half mirrors the first, whose normals face up.
    pub normals: Vec<DVec3>,
    /// Solid angle that each stands for.
    pub weights: Vec<f64>,
    /// RGB irradiance at each.
    pub irradiance: Vec<DVec3>,
}

/// The rings, and what they see of the rows of a map: the same under all maps of one grid.
struct Rings {
    columns: EvenColumns,
    views: Vec<View>,
    /// The normals of all rings, ring after ring, and then their opposites.
    normals: Vec<DVec3>,
    weights: Vec<f64>,
}

/// Irradiance under a reduced map at `fewest` normals, or some more: their azimuths follow its columns.
///
/// # Errors
///
/// [`Error::TooBright`].
pub fn judge(map: &WorkingMap, fewest: usize) -> Result<Judged> {
    static RINGS: Kept<(Grid, usize), Rings> = Kept::new();
    let rings = RINGS.of(&(map.grid.clone(), fewest), || Rings::new(&map.grid, fewest));
    let normals = &rings.normals[..rings.normals.len() / 2];
    // Add up cells and sources.
    let cells = under_cells(map, &rings.columns, normals, &rings.views);
    let sources = under_sources(&map.sources, normals);
    let flux = std::array::from_fn(|axis| cells.flux[axis] + flux_of_sources(map, axis));
    // Get the opposites back.
    let front: Vec<DVec3> =
        cells.irradiance.iter().zip(sources).map(|(cells, source)| cells + source).collect();
    let behind = front.iter().zip(normals).map(|(front, &normal)| front - opposite::dot(normal, &flux));
    let irradiance: Vec<DVec3> = front.iter().copied().chain(behind).collect();
    if !irradiance.iter().all(|sum| sum.is_finite()) {
        return Err(Error::TooBright);
    }
    Ok(Judged {
        normals: rings.normals.clone(),
        weights: rings.weights.clone(),
        // Rounding must not make darkness negative.
        irradiance: irradiance.into_iter().map(|sum| sum.max(DVec3::ZERO)).collect(),
    })
}

impl Rings {
    /// `fewest` normals, or some more, and what they see of the rows of a grid.
    fn new(grid: &Grid, fewest: usize) -> Self {
        let columns = EvenColumns::new(grid);
        let rings = upper_rings(&columns, fewest.div_ceil(2 * columns.azimuths));
        let views = rings.par_iter().map(|ring| ring.view(&grid.theta_edges, &columns)).collect();
        let upper = normals_of(&rings, &columns);
        let normals = upper.iter().copied().chain(upper.iter().map(|&normal| -normal)).collect();
        let solid_angles = rings.iter().chain(&rings).map(|ring| ring.solid_angle);
        let weights = solid_angles.flat_map(|one| std::iter::repeat_n(one, columns.azimuths)).collect();
        Self { columns, views, normals, weights }
    }
}

/// That many rings of normals that face up.
fn upper_rings(columns: &EvenColumns, rings: usize) -> Vec<Ring> {
    let step = columns.count / columns.azimuths;
    let ring = |i: usize| {
        let (height, weight) = gauss_legendre(2 * rings, i);
        Ring {
            height,
            radius: ((1.0 - height) * (1.0 + height)).sqrt(),
            start: ((i as f64 + 0.5) * GOLDEN_SECTION).fract() * step as f64,
            solid_angle: weight * TAU / columns.azimuths as f64,
        }
    };
    (0..rings).map(ring).collect()
}

/// Node `i`, from 1 down, and weight of the Gauss-Legendre rule of `count` nodes on -1 .. 1.
///
/// Newton's method on the Legendre polynomial P, with `P' = n (x P_n - P_(n-1)) / (x^2 - 1)`; the weight is
/// `2 / ((1 - x^2) P'^2)`.
fn gauss_legendre(count: usize, i: usize) -> (f64, f64) {
    /// From the starting value on, Newton's method doubles the digits: 4 steps are enough.
    const STEPS: usize = 6;
    let mut x = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
    let mut slope = 1.0;
    for _ in 0..STEPS {
        let (mut before, mut value) = (1.0, x);
        for k in 2..=count {
            let k = k as f64;
            (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
        }
        slope = count as f64 * (x * value - before) / (x * x - 1.0);
        x -= value / slope;
    }
    (x, 2.0 / ((1.0 - x * x) * slope * slope))
}

/// The normals of all rings, ring after ring.
fn normals_of(rings: &[Ring], columns: &EvenColumns) -> Vec<DVec3> {
    // Take sines and cosines of the first normal and of the steps from there; their sums follow.
    let step = TAU / columns.azimuths as f64;
    let steps: Vec<(f64, f64)> = (0..columns.azimuths).map(|i| (step * i as f64).sin_cos()).collect();
    let of_ring = |ring: &Ring| {
        let (sin, cos) = (columns.first_edge + ring.start * columns.width).sin_cos();
        let (sin, cos, height) = (ring.radius * sin, ring.radius * cos, ring.height);
        steps.iter().map(move |(sin_step, cos_step)| {
            DVec3::new(sin * cos_step + cos * sin_step, height, sin * sin_step - cos * cos_step)
        })
    };
    rings.iter().flat_map(of_ring).collect()
}

/// Irradiance of the cells at the normals of all rings, and their vector flux.
fn under_cells(map: &WorkingMap, columns: &EvenColumns, normals: &[DVec3], views: &[View]) -> Sums {
    let rows: Vec<_> = map.radiance.axis_iter(Axis(0)).collect();
    let runs: Vec<Sums> = rows
        .par_chunks(ROWS_OF_A_RUN)
        .enumerate()
        .map(|(i, rows)| {
            let (rows, first_row) = (rows.to_vec(), i * ROWS_OF_A_RUN);
            Arch::new().dispatch(Run { rows, first_row, grid: &map.grid, columns, normals, views })
        })
        .collect();
    // Add up the runs in their order.
    let zero = Sums { irradiance: vec![DVec3::ZERO; normals.len()], flux: [DVec3::ZERO; 3] };
    runs.into_iter().fold(zero, |mut sums, run| {
        let theirs = run.irradiance.into_iter().chain(run.flux);
        for (sum, term) in sums.irradiance.iter_mut().chain(&mut sums.flux).zip(theirs) {
            *sum += term;
        }
        sums
    })
}

/// Sum of the vector fluxes of the sources along an axis.
fn flux_of_sources(map: &WorkingMap, axis: usize) -> DVec3 {
    let along = map.sources.index_axis(Axis(1), axis);
    along.outer_iter().fold(DVec3::ZERO, |sum, flux| sum + DVec3::new(flux[0], flux[1], flux[2]))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::{Steps, irradiance, under_cells as exact_under_cells};
    use super::*;
    use crate::kernels::sphere::Registration::{self, BorderSampled, CellCentred};
    use crate::kernels::{fit, image, sphere};
    use ndarray::{Array1, Array2, Array3, ArrayView1, ArrayView2};
    use rayon::ThreadPoolBuilder;

    /// Heights, registrations and columns of the working map: cells kept, split, in blocks, with a rest.
    const MAPS: [(usize, Registration, usize); 9] = [
        (128, CellCentred, 256),
        (128, BorderSampled, 256),
        (125, CellCentred, 256),
        (32, CellCentred, 256),
        (32, BorderSampled, 256),
        (256, CellCentred, 256),
        (256, BorderSampled, 256),
        (257, CellCentred, 256),
        (9, CellCentred, 256),
    ];

    /// Relative RMS error beside the `exact` irradiance, (n, 3).
    fn error(judged: &Judged, exact: ArrayView2<'_, f64>) -> f64 {
        let found = sphere::from_vectors(judged.irradiance.iter().copied());
        fit::relative_rms(found.view(), exact, ArrayView1::from(&judged.weights)).unwrap()
    }

    fn waves(height: usize) -> Array3<f32> {
        let wave = |y: f64, x: f64| (11.0 * x).sin() + (0.5 * (y - x) * height as f64).cos() + 2.0;
        let unit = |i: usize| i as f64 / height as f64;
        Array3::from_shape_fn((height, 2 * height, 3), |(y, x, c)| {
            (wave(unit(y), unit(x)) * (c + 1) as f64) as f32
        })
    }

    /// Against the exact look-ups on the same cells, each in rows so fine that one horizon serves.
    #[test]
    fn rings_see_what_exact_look_ups_see() {
        for (height, registration, columns) in MAPS {
            let map = image::reduce(waves(height).view(), registration, columns, 1.0, false).unwrap();
            let judged = judge(&map, 5120).unwrap();
            let rows = map.radiance.dim().0;
            let fine = (512 / rows).max(1);
            let split = split_rows(&map, fine);
            let steps = Steps::of(rows);
            let exact =
                exact_under_cells(split.radiance.view(), &split.grid, steps, &judged.normals).unwrap();
            let error = error(&judged, exact.view());

            let bound = if height < 100 { 1e-4 } else { 5e-6 };
            assert!(error < bound, "{height} rows, {registration:?}: {error:e}");
        }
    }

    /// Each row as `parts` rows of the same radiance.
    fn split_rows(map: &WorkingMap, parts: usize) -> WorkingMap {
        let (rows, columns, _) = map.radiance.dim();
        let theta = &map.grid.theta_edges;
        let edge = |i: usize| {
            let (row, part) = (i / parts, (i % parts) as f64 / parts as f64);
            theta[row] + part * (theta[(row + 1).min(rows)] - theta[row])
        };
        let radiance =
            Array3::from_shape_fn((rows * parts, columns, 3), |(y, x, c)| map.radiance[[y / parts, x, c]]);
        let grid = image::Grid { theta_edges: (0..=rows * parts).map(edge).collect(), ..map.grid.clone() };
        WorkingMap {
            radiance,
            grid,
            sources: map.sources.clone(),
            bright: map.bright.clone(),
            parts: map.parts.clone(),
            pixel: map.pixel,
        }
    }

    #[test]
    fn constant_sky_gives_pi() {
        for (height, registration, columns) in MAPS.into_iter().chain([
            (2, CellCentred, 256),
            (3, BorderSampled, 256),
            (1024, CellCentred, 2048),
        ]) {
            let sky = Array3::from_elem((height, 2 * height, 3), 1.0_f32);
            let map = image::reduce(sky.view(), registration, columns, 2.0, false).unwrap();
            let judged = judge(&map, 5120).unwrap();
            let difference = judged
                .irradiance
                .iter()
                .map(|value| (value / PI - 1.0).abs().max_element())
                .fold(0.0, f64::max);

            let bound = if height < 10 {
                1e-3
            } else if height < 100 {
                3e-5
            } else {
                1e-6
            };
            assert!(difference < bound, "{height} rows, {registration:?}: {difference:e} from pi");
        }
    }

    #[test]
    fn normals_lie_opposite_each_other_and_weigh_the_sphere() {
        for (height, registration, columns) in MAPS {
            let map = image::reduce(waves(height).view(), registration, columns, 1.0, false).unwrap();
            let Judged { normals, weights, .. } = judge(&map, 5120).unwrap();
            let (upper, lower) = normals.split_at(normals.len() / 2);
            assert!(normals.len() >= 5120 && upper.len() == lower.len());
            assert!(upper.iter().zip(lower).all(|(&upper, &lower)| upper == -lower));
            assert!((weights.iter().sum::<f64>() / (4.0 * PI) - 1.0).abs() < 1e-12);
            for normal in &normals {
                assert!((normal.dot(*normal) - 1.0).abs() < 1e-14);
            }
            // The mean of n n^T is a third of the identity.
            let (normals, weights) = (sphere::from_vectors(normals.into_iter()), Array1::from(weights));
            let moments = normals.t().dot(&(&normals * &weights.insert_axis(Axis(1)))) / (4.0 * PI);
            let difference = (moments - Array2::<f64>::eye(3) / 3.0).mapv(f64::abs);
            assert!(difference.iter().all(|&x| x < 1e-14), "{difference}");
        }
    }

    #[test]
    fn gauss_legendre_integrates_polynomials() {
        for count in [2, 10, 40, 108] {
            let integral = |power: i32| -> f64 {
                (0..count).map(|i| gauss_legendre(count, i)).map(|(x, weight)| weight * x.powi(power)).sum()
            };
            for power in [0, 1, 2, 3] {
                let wanted = if power % 2 == 0 { 2.0 / f64::from(power + 1) } else { 0.0 };
                assert!((integral(power) - wanted).abs() < 1e-13, "{count} nodes, power {power}");
            }
            let last = 2 * count as i32 - 2;
            assert!((integral(last) - 2.0 / f64::from(last + 1)).abs() < 1e-13, "{count} nodes");
        }
    }

    /// A sun in one cell, as a point beside the others.
    #[test]
    fn sources_are_seen_from_both_sides() {
        let mut map = waves(256);
        map[[100, 300, 0]] = 1e6;
        map[[200, 300, 1]] = 1e5;
        let working = image::reduce(map.view(), CellCentred, 256, 2e-3, false).unwrap();
        assert_eq!(working.sources.dim().0, 2);
        let judged = judge(&working, 5120).unwrap();
        let normals = sphere::from_vectors(judged.normals.iter().copied());
        let exact = irradiance(map.view(), CellCentred, normals.view()).unwrap();
        let error = error(&judged, exact.view());
        assert!(error < 2e-4, "{error:e}");
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bits() {
        let map = image::reduce(waves(257).view(), CellCentred, 256, 1e-4, false).unwrap();
        let on = |threads: usize| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let judged = pool.install(|| judge(&map, 5120).unwrap());
            judged.irradiance.iter().map(|e| e.to_array().map(f64::to_bits)).collect::<Vec<_>>()
        };
        let one = on(1);
        assert_eq!(one, on(2));
        assert_eq!(one, on(5));
    }

    #[test]
    fn what_is_too_bright_is_refused() {
        let mut map = image::reduce(waves(32).view(), CellCentred, 256, 2.0, false).unwrap();
        map.radiance.fill(1e38);
        assert_eq!(judge(&map, 5120).unwrap_err(), Error::TooBright);
    }
}
