//! Spanning tree of the network simplex, of sources, sinks and a root.
//!
//! Arcs lead from sources to sinks. Each node stores the arc to its parent, so the arc of a source leads up, and that
//! of a sink leads down. Arcs between the root and all others exist for the start; they cost more than any detour.

use ndarray::ArrayView2;

/// Cost of an arc at the root: two of them cost more than an arc between a source and a sink, at most pi.
const ROOT_COST: f64 = 4.0;

/// Parent of the root.
const NO_NODE: usize = usize::MAX;

/// Arc between a node and its parent.
#[derive(Clone, Copy)]
struct ParentArc {
    parent: usize,
    cost: f64,
    flow: i64,
}

/// Mass that moves along one arc.
#[derive(Debug, PartialEq)]
pub(super) struct ArcFlow {
    /// Row of the costs.
    pub source: usize,
    /// Column of the costs.
    pub sink: usize,
    /// Units of mass, above 0.
    pub units: i64,
}

/// Strongly feasible spanning tree: each arc without flow leads towards the root.
pub(super) struct SpanningTree {
    /// Number of sources, which are the first nodes; sinks follow, and the root is last.
    sources: usize,
    arcs: Vec<ParentArc>,
    children: Vec<Vec<usize>>,
    depth: Vec<usize>,
    potential: Vec<f64>,
}

impl SpanningTree {
    /// Tree in which all mass passes through the root.
    pub fn star(supplies: &[i64], demands: &[i64]) -> Self {
        let nodes = supplies.len() + demands.len();
        let arc = |&flow: &i64| ParentArc { parent: nodes, cost: ROOT_COST, flow };
        let root = ParentArc { parent: NO_NODE, cost: 0.0, flow: 0 };
        let mut children = vec![Vec::new(); nodes];
        children.push((0..nodes).collect());
        let mut potential = vec![-ROOT_COST; supplies.len()];
        potential.resize(nodes, ROOT_COST);
        potential.push(0.0);
        let mut depth = vec![1; nodes];
        depth.push(0);
        let arcs = supplies.iter().chain(demands).map(arc).chain([root]).collect();
        Self { sources: supplies.len(), arcs, children, depth, potential }
    }

    /// Potentials of the sources and of the sinks; an arc of the tree costs their difference.
    pub fn potentials(&self) -> (&[f64], &[f64]) {
        self.potential[..self.root()].split_at(self.sources)
    }

    /// Flows between sources and sinks that are above 0.
    pub fn flows(&self) -> Vec<ArcFlow> {
        let flow = |node: usize| {
            let ([source, sink], units) = (self.ends(node)?, self.arcs[node].flow);
            (units > 0).then_some(ArcFlow { source, sink, units })
        };
        (0..self.root()).filter_map(flow).collect()
    }

    /// Add the arc from `source` to `sink`, with as much flow as the cycle admits, and remove the arc that blocks it.
    pub fn pivot(&mut self, source: usize, sink: usize, cost: f64) {
        let sink = self.sources + sink;
        let apex = self.common_ancestor(source, sink);
        let (flow, last) = self.blocking_arc(source, sink, apex);
        for (end, is_up) in [(source, true), (sink, false)] {
            let mut node = end;
            while node != apex {
                // An arc against the cycle loses flow.
                let change = if self.is_source(node) == is_up { -flow } else { flow };
                self.arcs[node].flow += change;
                node = self.arcs[node].parent;
            }
        }
        let (inner, outer) = if self.is_below(source, last) { (source, sink) } else { (sink, source) };
        self.hang(inner, last, ParentArc { parent: outer, cost, flow });
    }

    /// Give the arcs between sources and sinks other costs, which are finite in the tree.
    ///
    /// Without flow at the root, none gets there: arcs from sources to it have no flow to give back.
    pub fn replace_costs(&mut self, costs: ArrayView2<'_, f64>) {
        for node in 0..self.root() {
            if let Some([source, sink]) = self.ends(node) {
                self.arcs[node].cost = costs[[source, sink]];
            }
        }
        for node in self.children[self.root()].clone() {
            self.update(node);
        }
    }

    /// Source and sink, each by its own number, of the arc to the parent; `None` for an arc at the root.
    fn ends(&self, node: usize) -> Option<[usize; 2]> {
        let parent = self.arcs[node].parent;
        let (source, sink) = if self.is_source(node) { (node, parent) } else { (parent, node) };
        (parent < self.root()).then(|| [source, sink - self.sources])
    }

    fn root(&self) -> usize {
        self.arcs.len() - 1
    }

    fn is_source(&self, node: usize) -> bool {
        node < self.sources
    }

    /// Deepest node above both.
    fn common_ancestor(&self, mut one: usize, mut other: usize) -> usize {
        while one != other {
            if self.depth[one] < self.depth[other] {
                other = self.arcs[other].parent;
            } else {
                one = self.arcs[one].parent;
            }
        }
        one
    }

    /// True if `node` is `ancestor` or below it.
    fn is_below(&self, mut node: usize, ancestor: usize) -> bool {
        while self.depth[node] > self.depth[ancestor] {
            node = self.arcs[node].parent;
        }
        node == ancestor
    }

    /// Largest flow around the cycle, and the lower node of the last arc that blocks it.
    ///
    /// The cycle is traversed from the apex in the direction of its flow. Removal of the last blocking arc keeps the
    /// tree strongly feasible.
    fn blocking_arc(&self, source: usize, sink: usize, apex: usize) -> (i64, usize) {
        let (mut least, mut last) = (i64::MAX, NO_NODE);
        let mut node = source;
        while node != apex {
            if self.is_source(node) && self.arcs[node].flow < least {
                (least, last) = (self.arcs[node].flow, node);
            }
            node = self.arcs[node].parent;
        }
        node = sink;
        while node != apex {
            if !self.is_source(node) && self.arcs[node].flow <= least {
                (least, last) = (self.arcs[node].flow, node);
            }
            node = self.arcs[node].parent;
        }
        (least, last)
    }

    /// Cut off the subtree below `top`, turn it so that `inner` is its top, and attach it by `arc`.
    fn hang(&mut self, inner: usize, top: usize, arc: ParentArc) {
        let (mut node, mut arc) = (inner, arc);
        loop {
            let before = std::mem::replace(&mut self.arcs[node], arc);
            self.children[before.parent].retain(|&child| child != node);
            self.children[arc.parent].push(node);
            if node == top {
                break;
            }
            arc = ParentArc { parent: node, ..before };
            node = before.parent;
        }
        self.update(inner);
    }

    /// Compute depth and potential of `top` and all nodes below it.
    fn update(&mut self, top: usize) {
        let mut stack = vec![top];
        while let Some(node) = stack.pop() {
            let ParentArc { parent, cost, .. } = self.arcs[node];
            self.depth[node] = self.depth[parent] + 1;
            let step = if self.is_source(node) { -cost } else { cost };
            self.potential[node] = self.potential[parent] + step;
            stack.extend(&self.children[node]);
        }
    }
}
