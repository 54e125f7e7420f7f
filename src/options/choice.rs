//! Enums whose values have names.

/// A choice among a few named values. Implemented by `choices!`.
pub trait Choice: Copy + PartialEq + Send + Sync + 'static {
    /// All values.
    const ALL: &'static [Self];

    /// The name of a value.
    fn name(self) -> &'static str;

    /// The value with this name, in capitals or not.
    fn named(name: &str) -> Option<Self> {
        let is_named = |c: &Self| c.name().eq_ignore_ascii_case(name);
        Self::ALL.iter().copied().find(is_named)
    }

    /// The names of all values.
    fn names() -> Vec<&'static str> {
        Self::ALL.iter().map(|c| c.name()).collect()
    }
}

/// Names the values of an enum: `choices!(Method: Pde "pde", Loop "loop")`.
///
/// The enum implements [`Choice`] and can be the value of an option. Files contain its name.
macro_rules! choices {
    ($type:ident: $($variant:ident $name:literal),+) => {
        impl $crate::options::Choice for $type {
            const ALL: &'static [Self] = &[$(Self::$variant),+];

            fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }

        impl $crate::options::OptionValue for $type {
            fn kind() -> $crate::options::Kind {
                $crate::options::Kind::Choice(<Self as $crate::options::Choice>::names())
            }

            fn text(&self) -> Option<String> {
                Some($crate::options::Choice::name(*self).into())
            }

            fn set(&mut self, text: &str, _: &str) -> Result<(), $crate::options::OptionError> {
                use $crate::options::{Choice, OptionError};
                *self = Self::named(text).ok_or_else(|| {
                    OptionError::new(
                        format!("`{text}` is not one of the choices"),
                        format!("choose {}", Self::names().join(" or ")),
                    )
                })?;
                Ok(())
            }
        }

        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                to.serialize_str($crate::options::Choice::name(*self))
            }
        }

        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                use $crate::options::Choice;
                let name = String::deserialize(from)?;
                Self::named(&name).ok_or_else(|| {
                    serde::de::Error::custom(format!(
                        "`{name}` is not one of {}",
                        Self::names().join(", ")
                    ))
                })
            }
        }
    };
}
pub(crate) use choices;
