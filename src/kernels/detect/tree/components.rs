//! Which bright pixels hang together: the component tree, from the brightest pixel down.
//!
//! Flood the map with darkness from above: pixel after pixel appears, brightest first, each joins
//! the islands beside it. Where two islands meet, the level of that pixel is their *saddle*:
//! the darkest place on the brightest path between the two peaks. The dimmer stays a light of its
//! own only if
//!
//! ```text
//!   peak / saddle >= prominence
//! ```
//!
//! else the brighter absorbs it. The article's line check is one straight guess at that path.
//!
//! An island is known by the rank of its brightest pixel, which is also the root of its tree in the
//! union-find forest, for roots are always the brighter ones.

use rayon::prelude::*;

use super::summary::{Summary, TILE};

/// A light rises this far above the threshold; down to the threshold it extends (hysteresis).
const HYSTERESIS: f32 = 2.5;
/// A light that is clipped rises this far, at least.
const CLIPPED_HYSTERESIS: f32 = 1.2;
/// As many pixels as this, so much alike, at the map's maximum are a ceiling where a camera saturates.
const CEILING_PIXELS: usize = 3;
const CEILING: f32 = 1.0 - 1e-5;

/// Pixels above the threshold.
pub struct BrightPixels {
    /// Flat indices into the working image, brightest first, then in order.
    pub order: Vec<u32>,
    /// Tiles that were opened to find them.
    pub opened_tiles: usize,
}

/// Pixels brighter than `threshold`, from the tiles that hold any.
pub fn bright_pixels(summary: &Summary, threshold: f64) -> BrightPixels {
    let threshold = threshold as f32;
    let is_open = |&(_, &maximum): &((usize, usize), &f32)| maximum > threshold;
    let tiles: Vec<(usize, usize)> =
        summary.tile_maxima.indexed_iter().filter(is_open).map(|(tile, _)| tile).collect();
    let (height, width) = summary.luminance.dim();
    let luminance = summary.luminance.as_slice().expect("an owned array");
    let mut found: Vec<u64> = Vec::new();
    for &(tile_row, tile_column) in &tiles {
        for row in tile_row * TILE..((tile_row + 1) * TILE).min(height) {
            let start = row * width + tile_column * TILE;
            let end = row * width + ((tile_column + 1) * TILE).min(width);
            for (index, &value) in (start..end).zip(&luminance[start..end]) {
                if value > threshold {
                    // The bits of floats that are not negative are in the order of the floats.
                    found.push((u64::from(!value.to_bits()) << 32) | index as u64);
                }
            }
        }
    }
    found.par_sort_unstable();
    let order = found.into_iter().map(|key| key as u32).collect();
    BrightPixels { order, opened_tiles: tiles.len() }
}

/// The pixels of each light, before anything is measured.
pub struct Regions {
    /// Flat indices into the working image, brightest first; one list for each light.
    pub pixels: Vec<Vec<u32>>,
    /// Light of each pixel of the working image plus 1; 0 where there is none.
    pub label: Vec<u32>,
}

/// The lights among the bright pixels.
pub fn regions(summary: &Summary, bright: &BrightPixels, threshold: f64, prominence: f64) -> Regions {
    let luminance = summary.luminance.as_slice().expect("an owned array");
    let level: Vec<f32> = bright.order.iter().map(|&index| luminance[index as usize]).collect();
    let mut tree = Tree::of(level.len());
    let mut label = tree.flood(summary.luminance.dim(), &bright.order, &level, prominence as f32);
    let lowest_peak = lowest_peak(&level, threshold as f32);
    let mut light_of_peak: Vec<u32> = vec![0; level.len()];
    let mut pixels: Vec<Vec<u32>> = Vec::new();
    for (rank, &index) in bright.order.iter().enumerate() {
        let peak = tree.light(rank);
        if light_of_peak[peak] == 0 && level[peak] >= lowest_peak {
            pixels.push(Vec::new());
            light_of_peak[peak] = pixels.len() as u32;
        }
        label[index as usize] = light_of_peak[peak];
        if let Some(light) = light_of_peak[peak].checked_sub(1) {
            pixels[light as usize].push(index);
        }
    }
    Regions { pixels, label }
}

/// The luminance that a light must reach, among the levels of the bright pixels.
///
/// At the ceiling of a clipped picture nobody knows how bright a light is: it need not rise as far.
fn lowest_peak(level: &[f32], threshold: f32) -> f32 {
    let ceiling = level.first().map_or(0.0, |highest| CEILING * highest);
    let is_clipped = level.partition_point(|&level| level >= ceiling) >= CEILING_PIXELS;
    let enough = HYSTERESIS * threshold;
    if is_clipped { enough.min(ceiling.max(CLIPPED_HYSTERESIS * threshold)) } else { enough }
}

/// Islands and lights, by the rank of pixels.
struct Tree {
    /// Union-find forest of islands: towards the brightest pixel.
    island: Vec<u32>,
    /// The light that a pixel joined: the rank of its peak.
    joined: Vec<u32>,
    /// The light that absorbed the light of this peak; itself if none did.
    absorbed_by: Vec<u32>,
}

impl Tree {
    fn of(pixels: usize) -> Self {
        let own: Vec<u32> = (0..pixels as u32).collect();
        Self { island: own.clone(), joined: own.clone(), absorbed_by: own }
    }

    /// Let the pixels appear, brightest first; the image in which they did.
    fn flood(&mut self, size: (usize, usize), order: &[u32], level: &[f32], prominence: f32) -> Vec<u32> {
        let mut neighbours = Neighbours::new(size);
        for (rank, &index) in order.iter().enumerate() {
            let beside = neighbours.add(index, rank as u32);
            let Some(&brightest) = beside.iter().min() else { continue };
            let mut island = root(&mut self.island, brightest);
            for &other in beside {
                let other = root(&mut self.island, other);
                if other != island {
                    island = self.meet(island, other, level, prominence * level[rank]);
                }
            }
            self.joined[rank] = self.joined[brightest as usize];
            self.island[rank] = island;
        }
        neighbours.rank
    }

    /// Make two islands one; the dimmer light lives on if its peak reaches `enough`.
    fn meet(&mut self, one: u32, other: u32, level: &[f32], enough: f32) -> u32 {
        let (brighter, dimmer) = (one.min(other), one.max(other));
        if level[dimmer as usize] < enough {
            self.absorbed_by[dimmer as usize] = brighter;
        }
        self.island[dimmer as usize] = brighter;
        brighter
    }

    /// The rank of the peak of the light that the pixel belongs to in the end.
    fn light(&mut self, rank: usize) -> usize {
        root(&mut self.absorbed_by, self.joined[rank]) as usize
    }
}

/// Root of a union-find forest, halving the path on the way.
pub fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        let up = parent[parent[i as usize] as usize];
        parent[i as usize] = up;
        i = up;
    }
    i
}

/// Which pixels have appeared, and how they touch on the sphere: eight neighbours, columns that meet
/// again behind the seam, and rows at the poles whose pixels all touch.
struct Neighbours {
    height: u32,
    width: u32,
    /// Rank of each pixel that has appeared, plus 1; else 0.
    rank: Vec<u32>,
    /// First pixel that appeared at each pole.
    poles: [Option<u32>; 2],
    found: Vec<u32>,
}

impl Neighbours {
    fn new((height, width): (usize, usize)) -> Self {
        let rank = vec![0; height * width];
        Self { height: height as u32, width: width as u32, rank, poles: [None; 2], found: Vec::new() }
    }

    /// Let a pixel appear; the ranks of those beside it.
    fn add(&mut self, index: u32, rank: u32) -> &[u32] {
        let (row, column) = (index / self.width, index % self.width);
        let left = if column == 0 { self.width - 1 } else { column - 1 };
        let right = if column + 1 == self.width { 0 } else { column + 1 };
        self.found.clear();
        for near in row.saturating_sub(1)..(row + 2).min(self.height) {
            for column in [left, column, right] {
                if let Some(rank) = self.rank[(near * self.width + column) as usize].checked_sub(1) {
                    self.found.push(rank);
                }
            }
        }
        for (pole, pole_row) in [0, self.height - 1].into_iter().enumerate() {
            if row == pole_row {
                self.found.extend(self.poles[pole]);
                self.poles[pole].get_or_insert(rank);
            }
        }
        self.rank[index as usize] = rank + 1;
        &self.found
    }
}
