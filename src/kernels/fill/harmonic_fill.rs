//! The harmonic fill: a smooth continuation of the surrounding radiance into holes.
//!
//! It solves Laplace's equation on the sphere for each channel, so it lies between the darkest and the brightest pixel
//! around its hole. The coarsest image in which no hole is left starts the next finer one, and so on (cascadic multigrid:
//! Bornemann and Deuflhard 1996, "The cascadic multigrid method for elliptic problems"). Each level relaxes no farther
//! from the rim than its sweeps reach; the coarser level provides the inside.

use glam::Vec3A;
use rayon::prelude::*;

use super::level::Level;
use crate::kernels::image::Grid;

/// Sweeps of the finest level; each coarser one, with a quarter of the pixels, has twice as many.
const SWEEPS: usize = 10;
/// Largest number of sweeps of a level.
const MOST_SWEEPS: usize = 256;
/// Least number of rows of the coarsest level.
const LEAST_ROWS: usize = 4;

/// An image with filled holes between `known` pixels. Pixels far from holes stay 0.
pub fn harmonic_fill(grid: Grid, holes: Vec<usize>, known: impl Fn(usize) -> Vec3A + Sync) -> Level {
    // Find the holes of each level, up to one that has none.
    let mut levels = vec![Level::new(grid, holes)];
    while !levels[levels.len() - 1].holes.is_empty() && levels[levels.len() - 1].size.0 > LEAST_ROWS {
        levels.push(levels[levels.len() - 1].coarser());
    }
    // Average the known pixels that a hole needs, from the finest level to the coarsest.
    let required = required_pixels(&levels);
    let pixels = required[0].par_iter().filter(|&&pixel| !levels[0].is_hole(pixel));
    let values: Vec<_> = pixels.map(|&pixel| (pixel, known(pixel))).collect();
    for (pixel, value) in values {
        levels[0].values[pixel] = value;
    }
    for (number, pixels) in required.iter().enumerate().skip(1) {
        let (finer, coarser) = levels.split_at_mut(number);
        coarser[0].average(&finer[number - 1], pixels);
    }
    // Fill the holes, from the coarsest level to the finest.
    let mut solved = levels.pop().expect("one level at least");
    if !solved.holes.is_empty() {
        solved.relax(&solved.holes.clone(), MOST_SWEEPS);
    }
    while let Some(mut finer) = levels.pop() {
        finer.start_from(&solved);
        let sweeps = (SWEEPS << levels.len()).min(MOST_SWEEPS);
        // Relax only as far from the rim as the sweeps carry; farther inside, the coarser level is smooth enough.
        let near = finer.near_rim(&solved, sweeps / 2);
        finer.relax(&near, sweeps);
        solved = finer;
    }
    solved
}

/// Pixels of each level that its holes and those of finer levels depend on.
fn required_pixels(levels: &[Level]) -> Vec<Vec<usize>> {
    let mut required: Vec<Vec<usize>> = Vec::new();
    for (number, level) in levels.iter().enumerate().rev() {
        let mut is_required = vec![false; level.values.len()];
        // A hole depends on the pixels around it, and starts from those around the coarser pixel that it is in.
        level.mark_around(&level.holes, &mut is_required);
        if let Some(finer) = number.checked_sub(1).map(|finer| &levels[finer]) {
            let mut started: Vec<usize> =
                finer.holes.iter().map(|&hole| finer.parent(level.size.1, hole)).collect();
            started.dedup();
            level.mark_around(&started, &mut is_required);
        }
        // A coarser pixel depends on those inside of it.
        if let (Some(coarser), Some(pixels)) = (levels.get(number + 1), required.last()) {
            pixels
                .iter()
                .flat_map(|&pixel| level.children(coarser.size.1, pixel))
                .for_each(|pixel| is_required[pixel] = true);
        }
        // Keep the order of memory.
        required.push((0..is_required.len()).filter(|&pixel| is_required[pixel]).collect());
    }
    required.reverse();
    required
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::sphere::Registration;

    const SIZE: (usize, usize) = (64, 128);

    /// An image with this radiance at each row and column, after its holes are filled.
    fn fill(radiance: impl Fn(usize, usize) -> f32, is_hole: impl Fn(usize, usize) -> bool) -> Vec<[f32; 3]> {
        let pixels = || (0..SIZE.0).flat_map(|row| (0..SIZE.1).map(move |column| (row, column)));
        let mut image: Vec<[f32; 3]> = pixels().map(|(row, column)| [radiance(row, column); 3]).collect();
        let grid = Grid::of_pixels(SIZE.0, SIZE.1, Registration::CellCentred);
        let is_hole: Vec<bool> = pixels().map(|(row, column)| is_hole(row, column)).collect();
        let holes: Vec<usize> = (0..is_hole.len()).filter(|&pixel| is_hole[pixel]).collect();
        // The radiance inside a hole must not matter.
        let known = |pixel: usize| if is_hole[pixel] { Vec3A::splat(1e6) } else { image[pixel].into() };
        let solved = harmonic_fill(grid, holes.clone(), known);
        for hole in holes {
            image[hole] = solved.values[hole].to_array();
        }
        image
    }

    /// Largest difference of two images in red, green and blue.
    fn difference(one: &[[f32; 3]], other: &[[f32; 3]]) -> f32 {
        let pixels = one.iter().zip(other);
        pixels.flat_map(|(a, b)| (0..3).map(|i| (a[i] - b[i]).abs())).fold(0.0, f32::max)
    }

    /// Between 1.2 and 4.8, nowhere even, and not the same in both halves of the sphere.
    fn uneven(row: usize, column: usize) -> f32 {
        let (theta, phi) = (row as f32 / 20.0, column as f32 / SIZE.1 as f32 * std::f32::consts::TAU);
        3.0 + theta.cos() + 0.8 * (phi + theta).sin()
    }

    #[test]
    fn an_even_sky_stays_as_it_is() {
        let wild = |row: usize, column: usize| row < 5 || (row * 31 + column * 17) % 7 < 4 || row > 60;
        let bits = 0.3_f32.to_bits();
        assert!(fill(|_, _| 0.3, wild).as_flattened().iter().all(|value| value.to_bits() == bits));
    }

    /// A linear function of the azimuth solves Laplace's equation on the sphere.
    #[test]
    fn a_ramp_along_the_azimuth_is_continued() {
        let ramp = |_, column| column as f32;
        let hole = |row, column| (16..32).contains(&row) && (48..64).contains(&column);
        let expected = fill(ramp, |_, _| false);
        let error = difference(&fill(ramp, hole), &expected);
        assert!(error < 1e-3, "{error} of a ramp of 16");
    }

    /// The logarithm of the tangent of half the polar angle solves Laplace's equation, too.
    #[test]
    fn a_harmonic_fall_along_the_polar_angle_is_continued() {
        let theta = |row| std::f32::consts::PI * (row as f32 + 0.5) / SIZE.0 as f32;
        let fall = |row, _| 9.0 + (0.5 * theta(row)).tan().ln();
        let hole = |row, column| (16..32).contains(&row) && (48..64).contains(&column);
        let error = difference(&fill(fall, hole), &fill(fall, |_, _| false));
        assert!(error < 1e-2, "{error} of a fall of 1");
    }

    /// Powers of that tangent times waves along the azimuth solve it as well: here three waves around a cap of 45 degrees.
    ///
    /// The inside of such a wide hole comes from the coarser levels alone.
    #[test]
    fn waves_around_a_wide_cap_fade_towards_its_middle() {
        let (height, width) = (256, 512);
        let wave = |pixel: usize| {
            let theta = std::f32::consts::PI * ((pixel / width) as f32 + 0.5) / height as f32;
            let phi = std::f32::consts::TAU * ((pixel % width) as f32 + 0.5) / width as f32;
            ((0.5 * theta).tan() / (std::f32::consts::PI / 8.0).tan()).powi(3) * (3.0 * phi).cos()
        };
        let holes: Vec<usize> = (0..height / 4 * width).collect();
        let grid = Grid::of_pixels(height, width, Registration::CellCentred);
        let solved = harmonic_fill(grid, holes.clone(), |pixel| Vec3A::splat(wave(pixel)));
        let error = |&hole: &usize| (solved.values[hole][0] - wave(hole)).powi(2);
        // The error is 0.0021, as if all of the cap relaxed, and 0.0099 if the relaxed rim is too narrow.
        let rms = (holes.iter().map(error).sum::<f32>() / holes.len() as f32).sqrt();
        assert!(rms < 3e-3, "{rms}");
    }

    #[test]
    fn a_hole_on_the_seam_is_filled_as_elsewhere() {
        let hole = |row, column: usize| (20..37).contains(&row) && (50..75).contains(&column);
        let turn = |column| (column + SIZE.1 / 2) % SIZE.1;
        let there = fill(|row, column| uneven(row, turn(column)), |row, column| hole(row, turn(column)));
        let mut back = there.clone();
        for (index, value) in there.iter().enumerate() {
            back[index / SIZE.1 * SIZE.1 + turn(index % SIZE.1)] = *value;
        }
        let error = difference(&back, &fill(uneven, hole));
        assert!(error < 1e-2, "{error}");
    }

    #[test]
    fn a_hole_at_one_pole_is_filled_as_at_the_other() {
        let hole = |row: usize, _| row < 9;
        let turn = |row| SIZE.0 - 1 - row;
        let mut there = fill(|row, column| uneven(turn(row), column), |row, column| hole(turn(row), column));
        there = there.chunks(SIZE.1).rev().flatten().copied().collect();
        let error = difference(&there, &fill(uneven, hole));
        assert!(error < 1e-2, "{error}");
    }

    #[test]
    fn a_fill_lies_between_the_pixels_around_its_hole() {
        let hole = |row: usize, column: usize| row < 12 || (20..37).contains(&row) && column % 40 < 30;
        let rim = fill(uneven, |_, _| false).into_iter().map(|value| value[0]);
        let (low, high) = rim.fold((f32::MAX, 0.0_f32), |(low, high), y| (low.min(y), high.max(y)));
        assert!(fill(uneven, hole).iter().all(|value| (low..=high).contains(&value[0])));
    }
}
