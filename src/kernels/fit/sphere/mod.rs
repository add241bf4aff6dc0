//! The whole sphere of normals: the objective in closed form.
//!
//! The inner product of two lights is `kernel.rs`. That of a light with the probe under the map,
//!
//! ```text
//!   F(l) = <E, max(0, n.l)> = integral over the sphere of L(w) k(w.l) dw
//! ```
//!
//! is the map blurred by the same kernel: pi / 3 times `l.(integral of L w dw)`, plus an even function. The even
//! function is smooth where the map has no bright sources. These become exact points; a table holds all the rest.
//!
//! | step                                     | file                 |
//! |------------------------------------------|----------------------|
//! | the kernel between two lights            | `kernel.rs`          |
//! | inner products of lights                 | `lights.rs`          |
//! | bright sources as points                 | `points.rs`          |
//! | a table of a smooth even function        | `field.rs`           |
//! | inner products of the ambient term       | `ambient_columns.rs` |
//! | the objective of a descent               | `closed_form.rs`     |
//! | inner products for the search            | `point_search.rs`    |
//! | the probe at evaluation normals          | `evaluation_probe.rs` |

mod ambient_columns;
mod closed_form;
mod evaluation_probe;
mod field;
mod kernel;
#[cfg(test)]
mod kernel_digits;
mod lights;
mod point_search;
mod points;

pub use closed_form::Sphere;
pub use evaluation_probe::evaluation_probe;
pub use kernel::spectrum;
