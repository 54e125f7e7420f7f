//! Values that are recomputed only when their key changes.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::energy::{Energy, ExprError};
use crate::fill::Controls;

/// A value with the key it was computed for.
#[derive(Clone)]
pub(crate) struct Cached<K, V>(Option<(K, V)>);

impl<K, V> Default for Cached<K, V> {
    fn default() -> Self {
        Self(None)
    }
}

impl<K, V> Cached<K, V> {
    /// The value of the last call of [`Self::get`].
    pub(crate) fn latest(&self) -> Option<&V> {
        self.0.as_ref().map(|(_, value)| value)
    }
}

impl<K: PartialEq, V: Clone> Cached<K, V> {
    /// The value for a key. Calls `compute` if the key has changed since the last call.
    pub(crate) fn get(&mut self, key: K, compute: impl FnOnce() -> V) -> V {
        match &self.0 {
            Some((known, value)) if *known == key => value.clone(),
            _ => self.0.insert((key, compute())).1.clone(),
        }
    }
}

/// A shared value as a key. Two keys are equal if they share one allocation, which the key keeps
/// alive.
pub(crate) struct SharedKey<T>(Arc<T>);

impl<T> SharedKey<T> {
    /// The key of a value.
    pub(crate) fn of(value: &Arc<T>) -> Self {
        Self(Arc::clone(value))
    }
}

impl<T> PartialEq for SharedKey<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// An energy as typed.
#[derive(Clone, PartialEq)]
struct TypedEnergy {
    text: String,
    params: BTreeMap<String, f64>,
}

/// A parsed energy, parsed again only when its text or a parameter changes.
#[derive(Clone, Default)]
pub(crate) struct ParsedEnergy(Cached<TypedEnergy, Arc<Result<Energy, ExprError>>>);

impl ParsedEnergy {
    /// The energy of a text.
    pub(crate) fn parse(
        &mut self,
        text: &str,
        params: &BTreeMap<String, f64>,
    ) -> Arc<Result<Energy, ExprError>> {
        let key = TypedEnergy {
            text: text.to_owned(),
            params: params.clone(),
        };
        self.0.get(key, || Arc::new(Energy::parse(text, params)))
    }

    /// The energy of the controls; `None` if its text is invalid.
    pub(crate) fn of(&mut self, controls: &Controls) -> Option<Energy> {
        let parsed = self.parse(&controls.energy, &controls.param);
        Result::as_ref(&parsed).ok().cloned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_computed_once_for_each_change_of_its_key() {
        let mut calls = 0;
        let mut cached = Cached::default();
        for (key, expected) in [(1, 1), (1, 1), (2, 2), (1, 3)] {
            let value = cached.get(key, || {
                calls += 1;
                calls
            });
            assert_eq!(value, expected);
        }
    }

    #[test]
    fn shared_values_are_compared_by_address() {
        let (a, b) = (Arc::new(1), Arc::new(1));
        assert!(SharedKey::of(&a) == SharedKey::of(&Arc::clone(&a)));
        assert!(SharedKey::of(&a) != SharedKey::of(&b));
    }

    #[test]
    fn an_energy_is_parsed_again_when_a_parameter_changes() {
        let mut parsed = ParsedEnergy::default();
        let mut controls = Controls {
            energy: "a*H^2".into(),
            ..Controls::default()
        };
        assert!(parsed.of(&controls).is_none());
        for a in [1.0, 2.0] {
            controls.param.insert("a".into(), a);
            let energy = parsed.of(&controls).expect("valid");
            assert_eq!(energy.params()["a"], a);
        }
    }
}
