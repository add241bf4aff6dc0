//! Bounding volume hierarchy of triangles: for rays in a shader, and for rays here.
//!
//! | step                                          | file             |
//! |-----------------------------------------------|------------------|
//! | nodes in depth-first order, with skip links   | `nodes.rs`       |
//! | the nodes as texels of a shader               | `shader_nodes.rs` |
//! | nearest triangle of each of many rays         | `nearest_hit.rs` |

mod nearest_hit;
mod nodes;
mod shader_nodes;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

pub use nearest_hit::{TriangleHit, TriangleTree};
pub use shader_nodes::{Hierarchy, bounding_volume_hierarchy};
