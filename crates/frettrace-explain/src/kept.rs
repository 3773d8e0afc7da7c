//! What was found once and is asked for again, by what it is told by.

use std::sync::{Arc, Mutex, PoisonError};

/// Values by their keys. Copies share them.
pub(crate) struct Kept<K, V>(Arc<Mutex<Vec<(K, V)>>>);

impl<K, V> Clone for Kept<K, V> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<K, V> Default for Kept<K, V> {
    fn default() -> Self {
        Self(Arc::default())
    }
}

impl<K: PartialEq, V: Clone> Kept<K, V> {
    /// What is known by a key; `None` where nothing is.
    pub fn of(&self, key: &K) -> Option<V> {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.iter().find(|(by, _)| by == key).map(|(_, value)| value.clone())
    }

    /// Keeps what was found.
    pub fn keep(&self, key: K, value: V) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push((key, value));
    }
}

#[cfg(test)]
mod tests {
    use super::Kept;

    /// What one copy keeps another knows, by its own key alone, and the first that was found stays.
    #[test]
    fn copies_share_what_is_known() {
        let kept = Kept::default();
        kept.clone().keep((1, "a"), 3);
        kept.keep((1, "a"), 4);
        assert_eq!(kept.of(&(1, "a")), Some(3));
        assert_eq!(kept.of(&(2, "a")), None);
    }
}
