//! What happened to one revolution, in words.

/// A count and its noun, `1 scan` or `2 scans`; for nouns with a plural in s.
pub fn counted(count: u64, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Sentences about one revolution: every drop, repair and fallback is reported in the results.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Notes {
    sentences: Vec<String>,
    /// How many are of the revolution itself, once stages have begun to work on it.
    of_revolution: Option<usize>,
}

impl<S: Into<String>> Extend<S> for Notes {
    fn extend<I: IntoIterator<Item = S>>(&mut self, notes: I) {
        self.sentences.extend(notes.into_iter().map(Into::into));
    }
}

impl Notes {
    /// Adds a sentence.
    pub fn add(&mut self, note: impl Into<String>) {
        self.sentences.push(note.into());
    }

    /// All sentences, in the order in which they were added.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &str> {
        self.sentences.iter().map(String::as_str)
    }

    /// The sentences on the revolution itself, before stages began to work on it.
    pub fn of_revolution(&self) -> impl ExactSizeIterator<Item = &str> {
        let end = self.of_revolution.unwrap_or(self.sentences.len()).min(self.sentences.len());
        self.sentences[..end].iter().map(String::as_str)
    }

    /// `note` without its numbers and the s of plurals: "3 beams masked" is of the same kind as "1 beam masked".
    pub fn kind_of(note: &str) -> String {
        note.chars().filter(|c| !matches!(c, '0'..='9' | '.' | 's')).collect()
    }

    /// Whether there is no sentence.
    pub fn is_empty(&self) -> bool {
        self.sentences.is_empty()
    }

    /// Removes all sentences.
    pub fn clear(&mut self) {
        self.sentences.clear();
        self.of_revolution = None;
    }

    /// Removes what stages added when they worked on this revolution before; what was noted of the revolution itself stays.
    pub fn begin_stages(&mut self) {
        let of_revolution = *self.of_revolution.get_or_insert(self.sentences.len());
        self.sentences.truncate(of_revolution);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_of_one_and_of_several_are_of_one_kind() {
        assert_eq!(Notes::kind_of("1 beam masked"), Notes::kind_of("23 beams masked"));
        assert_eq!(Notes::kind_of("nearer than 2 m"), Notes::kind_of("nearer than 2.5 m"));
        assert_ne!(Notes::kind_of("1 beam masked"), Notes::kind_of("1 beam left out"));
    }
}
