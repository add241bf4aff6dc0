//! The transportation problem by the network simplex (Ahuja, Magnanti and Orlin 1993, chapter 11).
//!
//! Each pivot moves flow around the cycle that one arc of negative reduced cost closes in the tree. The tree stays
//! strongly feasible (Cunningham 1976), which rules out cycling: pivots without flow lower the potentials.

use ndarray::{Array2, ArrayView2};

use super::spanning_tree::{ArcFlow, SpanningTree};
use crate::interrupt;

/// Reduced cost in radians below which an arc enters the tree; the mean angle gets that close to the optimum.
/// It exceeds the rounding of potentials, so that no arc enters without a gain.
const TOLERANCE: f64 = 1e-12;

/// Reduced cost in radians up to which an arc belongs to an optimum. Ties differ by rounding, far less than this.
const SLACK: f64 = 1e-11;

/// Flows of least total cost from `supplies` to `demands`, which are above 0 and have the same sum.
///
/// `costs` are finite, from 0 to pi. Of several optima, it is one with the least sum of squared costs: if all lights of
/// a great circle move along it, each of them moves, not one past all others.
pub(super) fn cheapest_flows(costs: ArrayView2<'_, f64>, supplies: &[i64], demands: &[i64]) -> Vec<ArcFlow> {
    let mut tree = SpanningTree::star(supplies, demands);
    descend(&mut tree, costs);
    let squares = squares_of_optimal_arcs(costs, tree.potentials());
    tree.replace_costs(squares.view());
    descend(&mut tree, squares.view());
    tree.flows()
}

/// Pivot until no arc has a negative reduced cost.
fn descend(tree: &mut SpanningTree, costs: ArrayView2<'_, f64>) {
    let mut row = 0;
    while let Some((source, sink)) = entering_arc(costs, tree.potentials(), &mut row) {
        interrupt::check();
        tree.pivot(source, sink, costs[[source, sink]]);
    }
}

/// Squared costs of the arcs that an optimum may use, by complementary slackness; infinity for all others.
fn squares_of_optimal_arcs(costs: ArrayView2<'_, f64>, (sources, sinks): (&[f64], &[f64])) -> Array2<f64> {
    Array2::from_shape_fn(costs.dim(), |(source, sink)| {
        let cost = costs[[source, sink]];
        let reduced = cost + sources[source] - sinks[sink];
        if reduced <= SLACK { cost * cost } else { f64::INFINITY }
    })
}

/// Arc of the most negative reduced cost in the next row that has one, from `row` on; `None` at the optimum.
fn entering_arc(
    costs: ArrayView2<'_, f64>,
    (sources, sinks): (&[f64], &[f64]),
    row: &mut usize,
) -> Option<(usize, usize)> {
    for _ in 0..sources.len() {
        let source = *row;
        *row = (source + 1) % sources.len();
        let (mut least, mut sink) = (-TOLERANCE - sources[source], None);
        for (column, (cost, potential)) in costs.row(source).iter().zip(sinks).enumerate() {
            if cost - potential < least {
                (least, sink) = (cost - potential, Some(column));
            }
        }
        if let Some(sink) = sink {
            return Some((source, sink));
        }
    }
    None
}
