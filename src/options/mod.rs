//! Options as data: one struct per set of options, from which everything else is derived.
//!
//! `options!` defines a struct of options: name, type, default and help text of each. The fields
//! (`serde`, kebab-case names), the defaults, the arguments of the command line (`cli::options`),
//! the entries of a schedule and the project file are derived from it. All of them use the same
//! names.
//!
//! ```text
//! options! {
//!     /// What a user may choose about a fill.
//!     pub struct Controls {
//!         /// Maximum number of steps.
//!         steps("N"): usize = 200,
//!     }
//! }
//! ```
//!
//! Such a struct implements [`Options`]: [`difference`](Options::difference) returns the difference
//! of two sets as names and texts, [`set`](Options::set) sets one option from its name and text,
//! and [`to_arguments`](Options::to_arguments) returns command-line arguments. The type of an
//! option implements [`OptionValue`]; `choices!` implements it for an enum.

mod choice;
mod value;

#[cfg(test)]
mod tests;

pub use choice::Choice;
pub(crate) use choice::choices;
pub(crate) use value::text_keys;
pub use value::{Kind, OptionError, OptionValue};

/// One option of the struct `T`.
pub struct OptionEntry<T> {
    /// Name, as on the command line but without the dashes.
    pub name: String,
    /// Help text.
    pub help: &'static str,
    /// The placeholder for the value in help texts and errors.
    pub value_name: Option<&'static str>,
    /// The form of the value.
    pub kind: Kind,
    /// The text of the default, if there is one.
    pub default: Option<String>,
    pub(crate) set: fn(&mut T, &str, &str) -> Result<(), OptionError>,
    pub(crate) changes: fn(&T, &T) -> Vec<String>,
}

/// A struct made by `options!`.
pub trait Options: Clone + Default + PartialEq + Send + Sync + 'static {
    /// All options, in the order of the struct.
    fn entries() -> Vec<OptionEntry<Self>>;

    /// The changes from `self` to `to`, as names and texts for [`Self::set`]. A removed entry of a
    /// map has an empty value (`a=`); an unset optional value is `auto`.
    fn difference(&self, to: &Self) -> Vec<(String, String)> {
        let entries = Self::entries().into_iter();
        let named = |e: OptionEntry<Self>| {
            let texts = (e.changes)(self, to).into_iter();
            texts.map(move |text| (e.name.clone(), text))
        };
        entries.flat_map(named).collect()
    }

    /// Sets one option from its text.
    ///
    /// # Errors
    /// No option has this name, or the text is not a value of the option. Ranges are not checked.
    fn set(&mut self, name: &str, text: &str) -> Result<(), OptionError> {
        let entries = Self::entries();
        let Some(entry) = entries.iter().find(|e| e.name == name) else {
            let names: Vec<&str> = entries.iter().map(|e| e.name.as_str()).collect();
            return Err(OptionError::new(
                format!("unknown option `{name}`"),
                format!("options are {}", names.join(", ")),
            ));
        };
        (entry.set)(self, text, entry.value_name.unwrap_or("NAME=VALUE"))
    }

    /// The command-line arguments for the options that differ from the defaults. Each flag and each
    /// value is one argument, not quoted for a shell.
    fn to_arguments(&self) -> Vec<String> {
        let entries = Self::entries();
        let is_flag = |name: &str| {
            let mut flags = entries.iter().filter(|e| e.kind == Kind::Flag);
            flags.any(|e| e.name == name)
        };
        let differing = Self::default().difference(self).into_iter();
        differing
            .flat_map(|(name, text)| {
                let value = (!is_flag(&name)).then_some(text);
                std::iter::once(format!("--{name}")).chain(value)
            })
            .collect()
    }
}

/// Defines a struct of options; see the [module](self).
///
/// `serde` attributes go between the help text and the name.
macro_rules! options {
    (
        $(#[$meta:meta])*
        $vis:vis struct $name:ident {
            $(
                $(#[doc = $help:literal])+
                $(#[serde($($serde:tt)*)])?
                $field:ident $(($value_name:literal))?: $type:ty = $default:expr,
            )+
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, rename_all = "kebab-case")]
        $vis struct $name {
            $($(#[doc = $help])+ $(#[serde($($serde)*)])? pub $field: $type,)+
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default),+ }
            }
        }

        impl $crate::options::Options for $name {
            fn entries() -> Vec<$crate::options::OptionEntry<Self>> {
                use $crate::options::OptionValue;
                let default = Self::default();
                vec![$($crate::options::OptionEntry {
                    name: stringify!($field).replace('_', "-"),
                    help: concat!($($help),+),
                    value_name: [$(Some($value_name),)? None][0],
                    kind: <$type>::kind(),
                    default: default.$field.text(),
                    set: |options, text, form| options.$field.set(text, form),
                    changes: |from, to| from.$field.changes(&to.$field),
                }),+]
            }
        }
    };
}
pub(crate) use options;
