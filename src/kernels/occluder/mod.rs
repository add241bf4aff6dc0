//! Light that balls and convex polyhedra hide from points of a scene, in closed form.
//!
//! | step                                                          | file          |
//! |---------------------------------------------------------------|---------------|
//! | arcs of a circle                                              | `arcs.rs`     |
//! | part of a circle of directions that lies within a cone        | `cone.rs`     |
//! | cosine-weighted solid angle of an intersection of convex regions | `convex.rs` |
//! | region of the directions from a point to a solid              | `solid.rs`    |
//! | union of the solids, by inclusion and exclusion               | `occlusion.rs`   |
//! | irradiance with shadows and one model of all reflections      | `reflection.rs` |

mod arcs;
mod cone;
mod convex;
mod occlusion;
mod reflection;
mod solid;
#[cfg(test)]
mod tests;

pub use occlusion::{Receivers, Sources, form_factors, hidden_fractions};
pub use reflection::{Surroundings, received_irradiance};
pub use solid::{Ball, Polyhedron, Solid};
