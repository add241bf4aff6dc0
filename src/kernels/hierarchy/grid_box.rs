//! Boxes along the axes, in steps of a grid.

/// Smallest box around some points of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridBox {
    /// Smallest coordinates.
    pub lower: [u16; 3],
    /// Largest coordinates.
    pub upper: [u16; 3],
}

impl GridBox {
    /// Box around nothing: the neutral element of [`Self::union`].
    pub const EMPTY: Self = Self { lower: [u16::MAX; 3], upper: [0; 3] };

    /// Smallest box around the corners of a triangle.
    pub fn around(corners: [[u16; 3]; 3]) -> Self {
        corners.into_iter().fold(Self::EMPTY, |sum, corner| sum.union(Self { lower: corner, upper: corner }))
    }

    /// Smallest box around two boxes.
    pub fn union(self, other: Self) -> Self {
        Self {
            lower: [0, 1, 2].map(|axis| self.lower[axis].min(other.lower[axis])),
            upper: [0, 1, 2].map(|axis| self.upper[axis].max(other.upper[axis])),
        }
    }

    /// Half the surface area; 0 if empty. At most 1.3e10, so its product with a count of triangles fits.
    pub fn half_area(self) -> u64 {
        let [x, y, z] = [0, 1, 2].map(|axis| u64::from(self.upper[axis].saturating_sub(self.lower[axis])));
        x * y + y * z + z * x
    }

    /// Twice the centre along an axis.
    pub fn twice_centre(self, axis: usize) -> u32 {
        u32::from(self.lower[axis]) + u32::from(self.upper[axis])
    }
}
