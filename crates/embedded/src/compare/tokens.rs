//! Tokens of the C that squid writes; comments and white space are ignored.

use crate::error::SourceError;

/// A token and its line number; the end of a preprocessor directive is a token, too.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Token<'a> {
    pub(crate) text: &'a str,
    pub(crate) line: usize,
}

/// Splits a source into tokens.
///
/// # Errors
/// Returns [`SourceError::Hides`] for characters that could change what a compiler reads.
pub(crate) fn tokens(text: &str) -> Result<Vec<Token<'_>>, SourceError> {
    for (index, line) in text.lines().enumerate() {
        if let Some(found) = ["\\", "??", "//"].into_iter().find(|hides| line.contains(hides)) {
            return Err(SourceError::Hides { line: index + 1, found });
        }
    }
    let (mut found, mut rest, mut line, mut directive) = (vec![], text, 1, false);
    while let Some(first) = rest.chars().next() {
        let length = length_of(first, rest);
        let (token, after) = rest.split_at(length);
        let ends = directive && first == '\n';
        directive = (directive || first == '#') && !ends;
        if ends || !(token.starts_with("/*") || first.is_whitespace()) {
            found.push(Token { text: token, line });
        }
        line += token.matches('\n').count();
        rest = after;
    }
    Ok(found)
}

/// Returns the length in bytes of the token that begins with a character.
fn length_of(first: char, rest: &str) -> usize {
    let while_ = |goes_on: &dyn Fn(char) -> bool| rest.find(|c| !goes_on(c)).unwrap_or(rest.len());
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    match first {
        '/' if rest.starts_with("/*") => rest.find("*/").map_or(rest.len(), |end| end + 2),
        '"' => rest[1..].find('"').map_or(rest.len(), |end| end + 2),
        c if c.is_ascii_digit() => {
            let mut last = ' ';
            let number = |(_, c): &(usize, char)| {
                let signed = "+-".contains(*c) && "eEpP".contains(last);
                last = *c;
                is_word(*c) || *c == '.' || signed
            };
            rest.char_indices().take_while(number).last().map_or(1, |(at, c)| at + c.len_utf8())
        }
        c if is_word(c) => while_(&is_word),
        c => c.len_utf8(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(text: &str) -> Vec<&str> {
        tokens(text).unwrap().iter().map(|token| token.text).collect()
    }

    #[test]
    fn ignores_space_and_comments_except_the_end_of_a_directive() {
        let plain = "#define A 1\nreal x = -0x1.8p+1f + 1e-3;";
        let other = "# define  A /* one */ 1\n\n  real x=-0x1.8p+1f\n + /* \n */ 1e-3 ;";
        assert_eq!(texts(plain), texts(other));
        let expected = ["#", "define", "A", "1", "\n", "real", "x", "=", "-", "0x1.8p+1f", "+", "1e-3", ";"];
        assert_eq!(texts(plain), expected);
        assert_ne!(texts(plain), texts("#define A 1 real x = -0x1.8p+1f + 1e-3;"));
        assert_eq!(tokens(other).unwrap().last().map(|token| token.line), Some(5));
    }

    #[test]
    fn refuses_characters_that_hide_code() {
        for (text, found) in [("a\nb // c", "//"), ("a\n\\\nb", "\\"), ("a\n??/", "??")] {
            assert_eq!(tokens(text), Err(SourceError::Hides { line: 2, found }));
        }
    }
}
