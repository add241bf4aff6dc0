//! Bright pixels: those above the threshold.

use ndarray::ArrayView1;
use rayon::prelude::*;

use super::working_image::{TILE, WorkingImage};

/// Pixels above the threshold, as flat indices into the working image.
pub struct BrightPixels {
    /// In ascending order.
    pub indices: Vec<u32>,
    /// Tiles with a bright pixel.
    pub opened_tiles: usize,
}

/// Find the pixels brighter than `threshold`. Only tiles that hold any are read.
pub fn bright_pixels(working: &WorkingImage, threshold: f64) -> BrightPixels {
    let threshold = threshold as f32;
    let (height, width) = working.size;
    let is_open = |&&maximum: &&f32| maximum > threshold;
    // Collect the bright pixels of one row of tiles, pixel row by pixel row.
    let bright_in = |(tile_row, maxima): (usize, ArrayView1<'_, f32>)| {
        let open = maxima.iter().enumerate().filter(|(_, maximum)| is_open(maximum));
        let open: Vec<_> = open.map(|(tile, _)| tile * TILE..((tile + 1) * TILE).min(width)).collect();
        let mut bright = Vec::new();
        for row in tile_row * TILE..((tile_row + 1) * TILE).min(height) {
            for columns in &open {
                let pixels = row * width + columns.start..row * width + columns.end;
                let pixels = pixels.filter(|&index| working.luminance[index] > threshold);
                bright.extend(pixels.map(|index| index as u32));
            }
        }
        bright
    };
    // Collect those of all rows of tiles, in order.
    let tile_rows = working.tile_maxima.outer_iter().into_par_iter().enumerate();
    BrightPixels {
        indices: tile_rows.map(bright_in).collect::<Vec<_>>().concat(),
        opened_tiles: working.tile_maxima.iter().filter(is_open).count(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_maps::working_image_of;
    use super::*;

    #[test]
    fn bright_pixels_are_all_above_the_threshold_and_dark_tiles_stay_shut() {
        let rows: Vec<String> = (0..40)
            .map(|y| (0..80).map(|x| if y % 39 == 15 && x % 31 == 15 { '1' } else { '.' }).collect())
            .collect();
        let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        let bright = bright_pixels(&working_image_of(&rows), 0.9); // 1 is only just bright
        let mut indices = bright.indices;
        indices.sort_unstable();
        assert_eq!(indices, [15 * 80 + 15, 15 * 80 + 46, 15 * 80 + 77]);
        assert_eq!(bright.opened_tiles, 3);
    }
}
