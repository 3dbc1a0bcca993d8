//! Names whose meanings end with the scope that gave them.

use std::collections::HashMap;

/// Meanings of names. Opening a scope costs nothing, and closing it what was defined in it: copies of all names, once a scope,
/// would take the square of the time.
#[derive(Debug)]
pub(super) struct Scopes<V> {
    meanings: HashMap<String, V>,
    /// What names meant before the definitions since each scope was opened.
    before: Vec<(String, Option<V>)>,
    opened: Vec<usize>,
}

impl<V> Default for Scopes<V> {
    fn default() -> Self {
        Self {
            meanings: HashMap::new(),
            before: Vec::new(),
            opened: Vec::new(),
        }
    }
}

impl<V> Scopes<V> {
    pub(super) fn open(&mut self) {
        self.opened.push(self.before.len());
    }

    /// Closes the scope opened last, if there is one.
    pub(super) fn close(&mut self) {
        let Some(mark) = self.opened.pop() else {
            return;
        };
        while self.before.len() > mark {
            let Some((name, meaning)) = self.before.pop() else {
                return;
            };
            match meaning {
                Some(meaning) => self.meanings.insert(name, meaning),
                None => self.meanings.remove(&name),
            };
        }
    }

    pub(super) fn define(&mut self, name: &str, meaning: V) {
        let old = self.meanings.insert(name.to_owned(), meaning);
        if !self.opened.is_empty() {
            self.before.push((name.to_owned(), old));
        }
    }

    pub(super) fn get(&self, name: &str) -> Option<&V> {
        self.meanings.get(name)
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.meanings.keys().map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meanings_end_with_their_scope() {
        let mut scopes = Scopes::default();
        scopes.define("a", 1);
        scopes.open();
        scopes.define("a", 2);
        scopes.define("a", 3);
        scopes.define("b", 4);
        scopes.open();
        scopes.define("b", 5);
        assert_eq!((scopes.get("a"), scopes.get("b")), (Some(&3), Some(&5)));
        scopes.close();
        assert_eq!((scopes.get("a"), scopes.get("b")), (Some(&3), Some(&4)));
        scopes.close();
        assert_eq!((scopes.get("a"), scopes.get("b")), (Some(&1), None));
        scopes.close();
        assert_eq!(scopes.names().collect::<Vec<_>>(), ["a"]);
    }
}
