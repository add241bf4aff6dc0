//! Bounding volume hierarchy of triangles: for rays in a shader, and for rays here.
//!
//! | step                                          | file             |
//! |-----------------------------------------------|------------------|
//! | boxes on the grid of the model                | `grid_box.rs`    |
//! | split of a set of triangles by surface area   | `surface_area.rs`|
//! | nodes in depth-first order, with skip links   | `nodes.rs`       |
//! | nearest triangle of each of many rays         | `nearest_hit.rs` |
//!
//! Vertices are whole steps of a grid, so boxes and costs are exact integers: the same tree for any number of threads.

mod grid_box;
mod nearest_hit;
mod nodes;
mod surface_area;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

pub use nearest_hit::{TriangleHit, TriangleTree};
pub use nodes::{Hierarchy, bounding_volume_hierarchy};
