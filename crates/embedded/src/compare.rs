//! Comparison of a source with that of a design.

mod tokens;

use crate::error::SourceError;
use crate::real::parse;
use tokens::{Token, tokens};

/// Compares every number of the tables of a source and every other token with those of another source, which was
/// written for the expected design. Comments, spaces and the notation of numbers are ignored.
///
/// # Errors
/// Returns a [`SourceError`] with the first line that differs.
pub fn compare(found: &str, expected: &str) -> Result<(), SourceError> {
    let (found, expected) = (tokens(found)?, tokens(expected)?);
    let unlike = found.iter().zip(&expected).position(|(a, b)| !same(a.text, b.text));
    let longest = found.len().max(expected.len());
    let Some(index) = unlike.or((found.len() != expected.len()).then(|| found.len().min(expected.len())))
    else {
        return Ok(());
    };
    debug_assert!(index < longest);
    let shown = |tokens: &[Token<'_>]| match tokens.get(index).map(|token| token.text) {
        None => "the end of the source".to_owned(),
        Some("\n") => "the end of the line".to_owned(),
        Some(text) => text.to_owned(),
    };
    let line = found.get(index).or(found.last()).map_or(1, |token| token.line);
    let (table, found, expected) = (table(&expected, index), shown(&found), shown(&expected));
    Err(match table {
        Some(table) => SourceError::Number { line, table, found, expected },
        None => SourceError::Other { line, found, expected },
    })
}

/// Returns `true` if two tokens are equivalent: numbers of the same value and type, or the same text.
fn same(a: &str, b: &str) -> bool {
    let number = |text: &str| parse(text).map(|(value, suffix)| (value.to_bits(), suffix.to_owned()));
    a == b || number(a).is_some_and(|a| number(b) == Some(a))
}

/// Returns the name of the table that contains a token: `static const TYPE NAME[..] = {.. token ..};`.
fn table(tokens: &[Token<'_>], index: usize) -> Option<String> {
    let begin =
        tokens[..index.min(tokens.len())].iter().rposition(|token| [";", "\n"].contains(&token.text))? + 1;
    let mut texts = tokens[begin..].iter().map(|token| token.text);
    let is_table = ["static", "const"].iter().all(|word| texts.next() == Some(word));
    texts.nth(1).filter(|_| is_table).map(str::to_owned)
}
