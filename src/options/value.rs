//! The types of options, and their texts.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::str::FromStr;

use serde::{Deserialize, Deserializer};

/// Why a text is not a value of an option.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{problem}; {remedy}")]
pub struct OptionError {
    /// What is wrong.
    pub problem: String,
    /// The remedy.
    pub remedy: String,
}

impl OptionError {
    /// An error with this problem and remedy.
    pub fn new(problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self {
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }
}

/// The form of an option.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A flag without a value.
    Flag,
    /// A number or a word.
    Word,
    /// A text that may begin with a hyphen.
    Text,
    /// One of these names.
    Choice(Vec<&'static str>),
    /// Any number of pairs `NAME=VALUE`.
    Pairs,
}

/// The type of an option.
pub trait OptionValue: PartialEq + Sized {
    /// The form of the option.
    fn kind() -> Kind {
        Kind::Word
    }

    /// The text of the value; `None` for an unset optional value, a flag or a map.
    fn text(&self) -> Option<String>;

    /// Sets the value from a text. `form` is the form of a pair for the error message.
    ///
    /// # Errors
    /// The text is not a value of this type.
    fn set(&mut self, text: &str, form: &str) -> Result<(), OptionError>;

    /// The texts that change this value into another one if set in this order.
    fn changes(&self, to: &Self) -> Vec<String> {
        if self == to {
            return Vec::new();
        }
        vec![to.text().unwrap_or_else(|| AUTO.into())]
    }
}

/// The text of an unset optional value.
const AUTO: &str = "auto";

/// The shortest decimal that parses to the same number.
pub(super) fn number(value: f64) -> String {
    if value == 0.0 || (1e-4..1e9).contains(&value.abs()) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

fn parsed<T: FromStr>(text: &str) -> Result<T, OptionError> {
    let text = text.trim();
    let error = |_| OptionError::new(format!("`{text}` is not a valid number"), "write a number");
    text.parse().map_err(error)
}

impl OptionValue for f64 {
    fn text(&self) -> Option<String> {
        Some(number(*self))
    }

    fn set(&mut self, text: &str, _: &str) -> Result<(), OptionError> {
        *self = parsed(text)?;
        Ok(())
    }
}

impl OptionValue for usize {
    fn text(&self) -> Option<String> {
        Some(self.to_string())
    }

    fn set(&mut self, text: &str, _: &str) -> Result<(), OptionError> {
        *self = parsed(text)?;
        Ok(())
    }
}

impl OptionValue for String {
    fn kind() -> Kind {
        Kind::Text
    }

    fn text(&self) -> Option<String> {
        Some(self.clone())
    }

    fn set(&mut self, text: &str, _: &str) -> Result<(), OptionError> {
        text.clone_into(self);
        Ok(())
    }
}

impl OptionValue for bool {
    fn kind() -> Kind {
        Kind::Flag
    }

    fn text(&self) -> Option<String> {
        None
    }

    fn set(&mut self, text: &str, _: &str) -> Result<(), OptionError> {
        let error = |_| {
            OptionError::new(
                format!("`{text}` is not true or false"),
                "write true or \
                                                  false",
            )
        };
        *self = text.parse().map_err(error)?;
        Ok(())
    }

    fn changes(&self, to: &Self) -> Vec<String> {
        let changed = self != to;
        changed.then(|| to.to_string()).into_iter().collect()
    }
}

impl<T: OptionValue + Default> OptionValue for Option<T> {
    fn kind() -> Kind {
        T::kind()
    }

    fn text(&self) -> Option<String> {
        self.as_ref().and_then(T::text)
    }

    fn set(&mut self, text: &str, form: &str) -> Result<(), OptionError> {
        *self = None;
        if text != AUTO {
            self.insert(T::default()).set(text, form)?;
        }
        Ok(())
    }
}

/// Deserializes a map whose keys are texts in every file format.
pub(crate) fn text_keys<'de, D, K, V>(from: D) -> Result<BTreeMap<K, V>, D::Error>
where
    D: Deserializer<'de>,
    K: Ord + FromStr,
    V: Deserialize<'de>,
{
    let map = BTreeMap::<String, V>::deserialize(from)?;
    let entry = |(key, value): (String, V)| Ok((parsed(&key)?, value));
    let entries = map.into_iter().map(entry);
    entries
        .collect::<Result<_, OptionError>>()
        .map_err(serde::de::Error::custom)
}

/// Entries `NAME=VALUE`. An empty value removes the entry.
impl<K, V> OptionValue for BTreeMap<K, V>
where
    K: Ord + FromStr + Display,
    V: OptionValue + Default,
{
    fn kind() -> Kind {
        Kind::Pairs
    }

    fn text(&self) -> Option<String> {
        None
    }

    fn set(&mut self, text: &str, form: &str) -> Result<(), OptionError> {
        let Some((key, value)) = text.split_once('=') else {
            let problem = format!("`{text}` has no `=`");
            return Err(OptionError::new(problem, format!("write {form}")));
        };
        let key = parsed(key)?;
        if value.trim().is_empty() {
            self.remove(&key);
        } else {
            let mut read = V::default();
            read.set(value.trim(), form)?;
            self.insert(key, read);
        }
        Ok(())
    }

    fn changes(&self, to: &Self) -> Vec<String> {
        let removed = self.keys().filter(|k| !to.contains_key(k));
        let removed = removed.map(|k| format!("{k}="));
        let set = to.iter().filter(|(k, v)| self.get(k) != Some(v));
        let set = set.map(|(k, v)| format!("{k}={}", v.text().unwrap_or_default()));
        removed.chain(set).collect()
    }
}
