//! What depends on the pixels of a map alone, not on what is in them, is made once for all maps of the same pixels.

use std::sync::{Arc, Mutex};

/// The last value that was made, and what it was made for.
///
/// A lock that another thread holds is not waited for: a process that was forked meanwhile would wait for ever.
pub struct Kept<K, V>(Mutex<Option<(K, Arc<V>)>>);

impl<K: Clone + PartialEq, V> Kept<K, V> {
    /// Of nothing yet.
    pub const fn new() -> Self {
        Self(Mutex::new(None))
    }

    /// What was made for `key`: the last value, or a new one where that was made for another.
    pub fn of(&self, key: &K, make: impl FnOnce() -> V) -> Arc<V> {
        if let Ok(last) = self.0.try_lock()
            && let Some((made_for, value)) = &*last
            && made_for == key
        {
            return value.clone();
        }
        let value = Arc::new(make());
        if let Ok(mut last) = self.0.try_lock() {
            *last = Some((key.clone(), value.clone()));
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_value_is_made_once() {
        let kept = Kept::new();
        let mut made = Vec::new();
        for key in [1, 1, 2, 2, 1] {
            let value = kept.of(&key, || {
                made.push(key);
                10 * key
            });
            assert_eq!(*value, 10 * key);
        }
        assert_eq!(made, [1, 2, 1]);
    }

    /// As in a process that was forked while another thread was here.
    #[test]
    fn a_lock_that_is_held_is_not_waited_for() {
        let kept = Kept::new();
        let held = kept.0.lock();
        assert_eq!(*kept.of(&1, || 2), 2);
        drop(held);
        assert_eq!(*kept.of(&1, || 3), 3);
        assert_eq!(*kept.of(&1, || 4), 3);
    }
}
