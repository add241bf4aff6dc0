//! The transportation problem by the simplex method on a spanning tree (Dantzig 1951).
//!
//! Each pivot moves flow around the cycle that an arc of negative reduced cost closes in the tree of all arcs with
//! flow. Perturbed supplies rule out ties: each pivot moves flow and empties one arc, so the method cannot cycle.

use ndarray::{Array2, ArrayView2};
use rustc_hash::FxHashMap;

use crate::interrupt;

/// Reduced cost below which an arc enters the tree, for costs up to 1; the mean cost gets that close to the optimum.
/// It exceeds the rounding of potentials, so that no arc enters without a gain.
const TOLERANCE: f64 = 1e-12;

/// Reduced cost up to which an arc belongs to an optimum. Ties differ by rounding, far less than this.
const SLACK: f64 = 10.0 * TOLERANCE;

/// Source and sink.
type Arc = (usize, usize);

/// Flows above 0 of least total cost from `supplies` to `demands`, which are above 0 and have the same sum.
///
/// Equal optima are decided by the least sum of squared costs: if all lights of a great circle move along it, each of
/// them moves a little, instead of one light past all others. The number of flows is less than that of nodes; they are
/// in the order of arcs.
pub(super) fn cheapest_flows(
    costs: ArrayView2<'_, f64>,
    supplies: &[i64],
    demands: &[i64],
) -> Vec<(Arc, i64)> {
    let mut tree = SpanningTree::greedy(costs, supplies, demands);
    let scale = costs.iter().fold(1.0_f64, |scale, cost| scale.max(cost.abs()));
    tree.descend(costs, scale * TOLERANCE);
    // Optima use no other arcs, by complementary slackness.
    let squares = Array2::from_shape_fn(costs.dim(), |arc| {
        let is_optimal = costs[arc] - tree.dual_cost(arc) <= scale * SLACK;
        if is_optimal { costs[arc] * costs[arc] } else { f64::INFINITY }
    });
    tree.descend(squares.view(), scale * scale * TOLERANCE);
    tree.flows()
}

/// Tree of sources, the first nodes, and sinks.
struct SpanningTree {
    sources: usize,
    /// Flow on each arc in units of one over [`Self::divisor`].
    flows: FxHashMap<Arc, i128>,
    neighbours: Vec<Vec<usize>>,
    /// Next node on the way to node 0.
    parents: Vec<usize>,
    depths: Vec<usize>,
    /// Dual variables: the cost of an arc of the tree is the sum of those of its ends.
    potentials: Vec<f64>,
}

impl SpanningTree {
    /// Tree of the flows from each source to the nearest sinks that the sources before it left over.
    ///
    /// Each source supplies one such unit more, and the last sink takes them, so that only all sources and all sinks
    /// balance: no arc of a tree is without flow.
    fn greedy(costs: ArrayView2<'_, f64>, supplies: &[i64], demands: &[i64]) -> Self {
        let (sources, nodes) = (supplies.len(), supplies.len() + demands.len());
        let mut tree = Self {
            sources,
            flows: FxHashMap::default(),
            neighbours: vec![vec![]; nodes],
            parents: vec![0; nodes],
            depths: vec![0; nodes],
            potentials: vec![0.0; nodes],
        };
        let divided = |&units: &i64| i128::from(units) * tree.divisor();
        let mut supplies: Vec<_> = supplies.iter().map(|units| divided(units) + 1).collect();
        let mut demands: Vec<_> = demands.iter().map(divided).collect();
        *demands.last_mut().expect("there is a sink") += sources as i128;
        for (source, supply) in supplies.iter_mut().enumerate() {
            interrupt::check();
            while *supply > 0 {
                let open = (0..demands.len()).filter(|&sink| demands[sink] > 0);
                let cost = |sink: usize| costs[[source, sink]];
                let nearest = open.min_by(|&one, &other| cost(one).total_cmp(&cost(other)));
                let sink = nearest.expect("supplies and demands have the same sum");
                let flow = demands[sink].min(*supply);
                (*supply, demands[sink]) = (*supply - flow, demands[sink] - flow);
                tree.insert((source, sink), flow);
            }
        }
        tree
    }

    /// More than twice the perturbation of any flow.
    fn divisor(&self) -> i128 {
        2 * self.sources as i128 + 2
    }

    /// Flows above 0 without perturbation.
    fn flows(&self) -> Vec<(Arc, i64)> {
        let whole = |flow: i128| ((flow + self.divisor() / 2) / self.divisor()) as i64;
        let mut flows: Vec<_> = self.flows.iter().map(|(&arc, &flow)| (arc, whole(flow))).collect();
        flows.retain(|&(_, units)| units > 0);
        flows.sort_unstable();
        flows
    }

    /// Pivot until no arc has a reduced cost below `-tolerance`.
    fn descend(&mut self, costs: ArrayView2<'_, f64>, tolerance: f64) {
        self.potentials[0] = 0.0;
        self.neighbours[0].clone().into_iter().for_each(|node| self.hang(node, 0, costs));
        let mut row = 0;
        while let Some(arc) = self.entering_arc(costs, tolerance, &mut row) {
            interrupt::check();
            self.pivot(arc, costs);
        }
    }

    /// Arc of the most negative reduced cost in the next row that has one, from `row` on; `None` at the optimum.
    fn entering_arc(&self, costs: ArrayView2<'_, f64>, tolerance: f64, row: &mut usize) -> Option<Arc> {
        let (sources, sinks) = self.potentials.split_at(self.sources);
        for _ in 0..self.sources {
            let source = *row;
            *row = (source + 1) % self.sources;
            let (mut least, mut entering) = (sources[source] - tolerance, None);
            for (sink, (cost, potential)) in costs.row(source).iter().zip(sinks).enumerate() {
                if cost - potential < least {
                    (least, entering) = (cost - potential, Some((source, sink)));
                }
            }
            if entering.is_some() {
                return entering;
            }
        }
        None
    }

    /// Add an arc, with as much flow as its cycle admits, and remove the arc that this empties.
    fn pivot(&mut self, arc: Arc, costs: ArrayView2<'_, f64>) {
        let (source, sink) = (arc.0, self.sources + arc.1);
        let paths = self.paths_to_common_ancestor(source, sink);
        // Arcs lose and gain flow in turn.
        let losing = paths.iter().flat_map(|path| path.iter().step_by(2));
        let emptied = *losing.min_by_key(|arc| self.flows[arc]).expect("an arc at one of the ends");
        let flow = self.flows[&emptied];
        for path in &paths {
            for (step, arc) in path.iter().enumerate() {
                *self.flows.entry(*arc).or_default() += if step % 2 == 0 { -flow } else { flow };
            }
        }
        self.remove(emptied);
        self.insert(arc, flow);
        let is_source_cut_off = paths[0].contains(&emptied);
        let (inner, outer) = if is_source_cut_off { (source, sink) } else { (sink, source) };
        self.hang(inner, outer, costs);
    }

    /// Arcs from each of two nodes up to their first common ancestor.
    fn paths_to_common_ancestor(&self, one: usize, other: usize) -> [Vec<Arc>; 2] {
        let (mut ends, mut paths) = ([one, other], [vec![], vec![]]);
        while ends[0] != ends[1] {
            let deeper = usize::from(self.depths[ends[0]] < self.depths[ends[1]]);
            let parent = self.parents[ends[deeper]];
            paths[deeper].push(self.arc(ends[deeper], parent));
            ends[deeper] = parent;
        }
        paths
    }

    /// Set parent, depth and potential of a node and of all that it connects to the tree.
    fn hang(&mut self, node: usize, parent: usize, costs: ArrayView2<'_, f64>) {
        let mut stack = vec![(node, parent)];
        while let Some((node, parent)) = stack.pop() {
            self.parents[node] = parent;
            self.depths[node] = self.depths[parent] + 1;
            self.potentials[node] = costs[self.arc(node, parent)] - self.potentials[parent];
            stack.extend(
                self.neighbours[node].iter().filter(|&&next| next != parent).map(|&next| (next, node)),
            );
        }
    }

    fn insert(&mut self, arc: Arc, flow: i128) {
        self.flows.insert(arc, flow);
        self.neighbours[arc.0].push(self.sources + arc.1);
        self.neighbours[self.sources + arc.1].push(arc.0);
    }

    fn remove(&mut self, arc: Arc) {
        self.flows.remove(&arc);
        self.neighbours[arc.0].retain(|&node| node != self.sources + arc.1);
        self.neighbours[self.sources + arc.1].retain(|&node| node != arc.0);
    }

    /// Arc between two nodes.
    fn arc(&self, one: usize, other: usize) -> Arc {
        (one.min(other), one.max(other) - self.sources)
    }

    /// Sum of the potentials at the ends of an arc.
    fn dual_cost(&self, arc: Arc) -> f64 {
        self.potentials[arc.0] + self.potentials[self.sources + arc.1]
    }
}
