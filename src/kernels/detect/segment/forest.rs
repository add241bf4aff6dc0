//! Union-find: sets of joined elements, as trees of parents.

/// A forest of this many elements, each a tree of its own.
pub fn singletons(count: usize) -> Vec<u32> {
    (0..count as u32).collect()
}

/// Root of the tree of `i`, with path halving.
pub fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        let up = parent[parent[i as usize] as usize];
        parent[i as usize] = up;
        i = up;
    }
    i
}

/// Join the trees of two elements; the smaller one of both roots stays a root.
pub fn join(parent: &mut [u32], one: u32, other: u32) {
    let (one, other) = (root(parent, one), root(parent, other));
    parent[one.max(other) as usize] = one.min(other);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_elements_have_one_root() {
        let mut parent = singletons(6);
        for (one, other) in [(4, 2), (5, 4), (1, 3)] {
            join(&mut parent, one, other);
        }
        let roots: Vec<u32> = (0..6).map(|i| root(&mut parent, i)).collect();
        assert_eq!(roots, [0, 1, 2, 1, 2, 2]);
    }
}
