//! Tags and attributes of XML, as far as the headers of images need them.

/// The text of the first tag of a name, with or without a prefix, up to its end.
pub(super) fn tag<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    tags(text, name).next()
}

/// The texts of all tags of a name.
pub(super) fn tags<'a>(text: &'a str, name: &str) -> impl Iterator<Item = &'a str> {
    let is_it = move |tag: &str| {
        let word = tag.split(|letter: char| letter.is_ascii_whitespace() || letter == '/').next().unwrap_or_default();
        word.rsplit(':').next() == Some(name)
    };
    text.split('<').skip(1).filter_map(|tag| tag.split('>').next()).filter(move |tag| is_it(tag))
}

/// The value of an attribute.
pub(super) fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let starts = tag.match_indices(name).filter(|(at, _)| tag[..*at].ends_with(|c: char| c.is_ascii_whitespace()));
    let value = |(at, _): (usize, &str)| {
        let rest = tag[at + name.len()..].trim_start().strip_prefix('=')?.trim_start();
        let quote = rest.chars().next().filter(|first| ['"', '\''].contains(first))?;
        rest[1..].split(quote).next()
    };
    starts.filter_map(value).next()
}
