//! Arrays of directions, and lines of places in a picture.

use glam::DVec3;

/// Directions, component by component.
#[derive(Default)]
pub struct DirectionArrays([Vec<f64>; 3]);

impl DirectionArrays {
    /// Space for a number of directions.
    pub fn new(count: usize) -> Self {
        Self(std::array::from_fn(|_| vec![f64::NAN; count]))
    }

    /// Slices of x, y and z.
    pub fn components(&self) -> [&[f64]; 3] {
        self.0.each_ref().map(Vec::as_slice)
    }

    /// Slices of x, y and z that can be changed.
    pub fn components_mut(&mut self) -> [&mut [f64]; 3] {
        self.0.each_mut().map(Vec::as_mut_slice)
    }

    /// Set one direction.
    pub fn set(&mut self, index: usize, direction: DVec3) {
        for (component, value) in self.0.iter_mut().zip(direction.to_array()) {
            component[index] = value;
        }
    }
}

/// One line of places in some columns of a row.
#[derive(Clone, Debug)]
pub struct Line {
    /// Row of the picture.
    pub row: usize,
    /// Number of the line in the row.
    pub line: usize,
    /// First column.
    pub first: usize,
    /// Number of columns.
    pub columns: usize,
}

/// Grid of places in all pixels of a picture, as directions.
pub trait Places: Sync {
    /// Write the directions of a line, which stand for equal solid angles or nearly so; NaN outside of the picture.
    fn directions(&self, line: &Line, out: &mut DirectionArrays);
}
