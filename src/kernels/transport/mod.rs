//! Optimal transport between two sets of weighted directions, at the cost of the angle between them.
//!
//! | step                                            | file                 |
//! |-------------------------------------------------|----------------------|
//! | weights as whole units of mass, angles as costs | `plan.rs`            |
//! | flows of least cost                             | `network_simplex.rs` |
//! | spanning tree that carries the flows            | `spanning_tree.rs`   |
//!
//! Mass is counted in whole units, so flows are exact: equal masses and coincident directions neither let the simplex
//! cycle nor leave remainders of rounding in the plan.

mod network_simplex;
mod plan;
mod spanning_tree;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

pub use plan::{TransportPlan, transport_plan};
