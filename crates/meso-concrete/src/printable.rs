//! Text that a terminal prints as it is, whatever names a file brings in.

use std::borrow::Cow;

/// Escapes characters that a terminal obeys instead of printing: control characters, and marks that reverse a line.
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(is_obeyed) {
        return Cow::Borrowed(text);
    }
    let escape = |character: char| match is_obeyed(character) {
        true => character.escape_default().to_string(),
        false => character.to_string(),
    };
    Cow::Owned(text.chars().map(escape).collect())
}

/// Whether a terminal obeys the character: C0 and C1 controls, line separators, and the marks of bidirectional text.
fn is_obeyed(character: char) -> bool {
    character.is_control()
        || matches!(character, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped_and_letters_of_all_scripts_are_not() {
        assert_eq!(printable("\u{1b}[2J\u{1b}]0;title\u{7}"), "\\u{1b}[2J\\u{1b}]0;title\\u{7}");
        assert_eq!(printable("a\nb\r\u{9b}31m\u{202e}x"), "a\\nb\\r\\u{9b}31m\\u{202e}x");
        assert!(matches!(printable("Körnung 碎石 µm \\ \"x\""), Cow::Borrowed(_)));
    }
}
