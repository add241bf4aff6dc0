//! Bounding volume hierarchy of the triangles of a model, for rays in a shader.
//!
//! | step                                          | file             |
//! |-----------------------------------------------|------------------|
//! | boxes on the grid of the model                | `grid_box.rs`    |
//! | split of a set of triangles by surface area   | `surface_area.rs`|
//! | nodes in depth-first order, with skip links   | `nodes.rs`       |
//!
//! Vertices are whole steps of a grid, so boxes and costs are exact integers: the same tree for any number of threads.

mod grid_box;
mod nodes;
mod surface_area;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

pub use nodes::{Hierarchy, bounding_volume_hierarchy};
