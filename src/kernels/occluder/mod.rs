//! Light that balls and convex polyhedra hide from points of a scene, in closed form.
//!
//! | step                                                          | file          |
//! |---------------------------------------------------------------|---------------|
//! | arcs of a circle that lie within other cones                  | `arcs.rs`     |
//! | cosine-weighted solid angle of the directions in all of a set of cones | `cone.rs` |
//! | cones of the directions from a point to a solid               | `solid.rs`    |
//! | union of the solids, by inclusion and exclusion               | `hidden.rs`   |
//! | irradiance with shadows and one model of all reflections      | `reflected.rs` |

mod arcs;
mod cone;
mod hidden;
mod reflected;
mod solid;
#[cfg(test)]
mod tests;

pub use hidden::{Receivers, Sources, hidden_shares};
pub use reflected::{Surroundings, form_factors, received};
pub use solid::{Ball, Polyhedron, Solid};
