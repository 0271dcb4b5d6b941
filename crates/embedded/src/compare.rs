//! Whether a source is that of a design.

mod tokens;

use crate::error::SourceError;
use crate::real::parse;
use tokens::{Token, tokens};

/// Reads a source back, and compares every number of its tables and every other token with those of another, which was
/// written for the design that it should be of. Comments, spaces and the way in which a number is written do not count.
///
/// # Errors
/// [`SourceError`] with the first line that differs.
pub fn compare(found: &str, expected: &str) -> Result<(), SourceError> {
    let (found, expected) = (tokens(found)?, tokens(expected)?);
    let unlike = found.iter().zip(&expected).position(|(a, b)| !same(a.text, b.text));
    let longest = found.len().max(expected.len());
    let Some(at) = unlike.or((found.len() != expected.len()).then(|| found.len().min(expected.len()))) else {
        return Ok(());
    };
    debug_assert!(at < longest);
    let shown = |tokens: &[Token<'_>]| match tokens.get(at).map(|token| token.text) {
        None => "its end".to_owned(),
        Some("\n") => "the end of the line".to_owned(),
        Some(text) => text.to_owned(),
    };
    let line = found.get(at).or(found.last()).map_or(1, |token| token.line);
    let (table, found, expected) = (table(&expected, at), shown(&found), shown(&expected));
    Err(match table {
        Some(table) => SourceError::Number { line, table, found, expected },
        None => SourceError::Other { line, found, expected },
    })
}

/// Whether two tokens mean the same: numbers of the same value and the same type, or the same text.
fn same(a: &str, b: &str) -> bool {
    let number = |text: &str| parse(text).map(|(value, suffix)| (value.to_bits(), suffix.to_owned()));
    a == b || number(a).is_some_and(|a| number(b) == Some(a))
}

/// The name of the table that a token is part of: `static const TYPE NAME[..] = {.. token ..};`.
fn table(tokens: &[Token<'_>], at: usize) -> Option<String> {
    let begin =
        tokens[..at.min(tokens.len())].iter().rposition(|token| [";", "\n"].contains(&token.text))? + 1;
    let mut texts = tokens[begin..].iter().map(|token| token.text);
    let is_table = ["static", "const"].iter().all(|word| texts.next() == Some(word));
    texts.nth(1).filter(|_| is_table).map(str::to_owned)
}
