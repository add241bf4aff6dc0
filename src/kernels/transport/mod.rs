//! Optimal transport between two sets of weighted directions, at the cost of the angle between them.
//!
//! | step                                            | file               |
//! |-------------------------------------------------|--------------------|
//! | weights as whole units of mass, angles as costs | `plan.rs`          |
//! | flows of least cost                             | `spanning_tree.rs` |
//!
//! Mass is counted in whole units, so flows are exact and leave no remainders of rounding in the plan.

mod plan;
mod spanning_tree;

pub use plan::{TransportPlan, assignment, transport_plan};
