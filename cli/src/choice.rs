//! Arguments that choose a value of the library by its name.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// A name, what it chooses, and a line of help, which may be empty.
pub(super) type Choice<T> = (&'static str, T, &'static str);

/// Parses the name of one of these values.
pub(super) fn one_of<T: Clone + Send + Sync + 'static>(
    choices: &'static [Choice<T>],
) -> impl TypedValueParser<Value = T> {
    let names = choices.iter().map(|(name, _, help)| match *help {
        "" => PossibleValue::new(*name),
        help => PossibleValue::new(*name).help(help),
    });

    PossibleValuesParser::new(names).map(|chosen| {
        let choice = choices.iter().find(|(name, ..)| *name == chosen);
        choice.expect("clap refuses other names").1.clone()
    })
}
