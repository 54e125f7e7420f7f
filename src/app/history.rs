//! Undo and redo of whole states. Cloning a state is cheap because meshes are shared.

/// States before and after the current one.
#[derive(Clone, Debug)]
pub struct History<T> {
    past: Vec<(T, String)>,
    future: Vec<(T, String)>,
    merge: Option<&'static str>,
}

impl<T> Default for History<T> {
    fn default() -> Self {
        Self {
            past: Vec::new(),
            future: Vec::new(),
            merge: None,
        }
    }
}

/// Maximum number of stored states.
const LIMIT: usize = 256;

impl<T: Clone> History<T> {
    /// Stores `before`, the state that the action named `label` is about to change.
    ///
    /// Consecutive records with the same `merge` key, such as those of one slider drag, are one
    /// entry.
    pub fn record(&mut self, before: &T, label: impl Into<String>, merge: Option<&'static str>) {
        self.future.clear();
        if merge.is_some() && merge == self.merge && !self.past.is_empty() {
            return;
        }
        self.merge = merge;
        if self.past.len() == LIMIT {
            self.past.remove(0);
        }
        self.past.push((before.clone(), label.into()));
    }

    /// Ends a series of merged records.
    pub fn seal(&mut self) {
        self.merge = None;
    }

    /// Swaps `current` with the state before it; returns the label of the undone action.
    pub fn undo(&mut self, current: &mut T) -> Option<String> {
        let (state, label) = self.past.pop()?;
        self.future
            .push((std::mem::replace(current, state), label.clone()));
        self.merge = None;
        Some(label)
    }

    /// Swaps `current` with the state after it; returns the label of the redone action.
    pub fn redo(&mut self, current: &mut T) -> Option<String> {
        let (state, label) = self.future.pop()?;
        self.past
            .push((std::mem::replace(current, state), label.clone()));
        self.merge = None;
        Some(label)
    }

    /// Label of the action that an undo reverts.
    pub fn next_undo(&self) -> Option<&str> {
        self.past.last().map(|(_, label)| label.as_str())
    }

    /// Label of the action that a redo repeats.
    pub fn next_redo(&self) -> Option<&str> {
        self.future.last().map(|(_, label)| label.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undo_and_redo_are_inverse() {
        let mut history = History::default();
        let mut state = 0;
        for next in 1..=3 {
            history.record(&state, format!("to {next}"), None);
            state = next;
        }
        assert_eq!(history.undo(&mut state).as_deref(), Some("to 3"));
        assert_eq!(state, 2);
        assert_eq!(history.undo(&mut state).as_deref(), Some("to 2"));
        assert_eq!(history.redo(&mut state).as_deref(), Some("to 2"));
        assert_eq!((state, history.next_redo()), (2, Some("to 3")));
        history.record(&state, "elsewhere", None);
        state = 9;
        assert_eq!(history.redo(&mut state), None);
        assert_eq!(history.undo(&mut state).as_deref(), Some("elsewhere"));
        assert_eq!(state, 2);
    }

    #[test]
    fn a_dragged_slider_is_one_entry() {
        let mut history = History::default();
        let mut state = 0;
        for next in 1..=5 {
            history.record(&state, "density", Some("density"));
            state = next;
        }
        history.seal();
        history.record(&state, "density", Some("density"));
        state = 6;
        history.undo(&mut state);
        assert_eq!(state, 5);
        history.undo(&mut state);
        assert_eq!(state, 0);
        assert_eq!(history.undo(&mut state), None);
    }
}
