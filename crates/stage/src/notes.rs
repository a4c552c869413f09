//! What happened to one revolution, in words, each sentence with the code of its kind.

/// The page that explains the codes: a row of a Markdown table for each, in their order.
pub const NOTES_PAGE: &str = include_str!("notes.md");

macro_rules! note_codes {
    ($($code:ident)*) => {
        /// The kind of a note. [`NOTES_PAGE`] says of each what was seen, what was done and what to do.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        #[expect(missing_docs, reason = "the page of notes documents each")]
        pub enum NoteCode { $($code),* }

        impl NoteCode {
            #[cfg(test)]
            const NAMES: &[&str] = &[$(stringify!($code)),*];

            /// The code of this name, such as `N012`.
            pub fn named(name: &str) -> Option<Self> {
                match name {
                    $(stringify!($code) => Some(Self::$code),)*
                    _ => None,
                }
            }
        }
    };
}

note_codes! {
    N001 N002 N003 N004 N005 N006 N007 N008 N009 N010 N011 N012 N013 N014 N015 N016 N017 N018 N019 N020 N021 N022 N023 N024
    N025 N026 N027 N028 N029 N030 N031 N032 N040 N041 N042 N043 N044 N045 N046 N047 N048 N049 N050 N051 N052 N053 N054 N055
    N056 N057 N058 N059 N060 N061 N062 N063 N070 N071 N072 N073 N074 N075 N076 N077 N080 N081 N082 N083 N090 N091 N092 N093
    N094 N095 N096 N097 N098 N099 N100 N101 N102 N103 N104 N105 N106
}

/// A count and its noun, `1 scan` or `2 scans`; for nouns with a plural in s.
pub fn counted(count: u64, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Sentences about one revolution: every drop, repair and fallback is reported in the results.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Notes {
    sentences: Vec<(NoteCode, String)>,
    /// How many are of the revolution itself, once stages have begun to work on it.
    of_revolution: Option<usize>,
}

impl<S: Into<String>> Extend<(NoteCode, S)> for Notes {
    fn extend<I: IntoIterator<Item = (NoteCode, S)>>(&mut self, notes: I) {
        notes.into_iter().for_each(|(code, note)| self.add(code, note));
    }
}

impl Notes {
    /// Adds a sentence of the kind `code`. A stage of your own takes [`NoteCode::N101`].
    pub fn add(&mut self, code: NoteCode, note: impl Into<String>) {
        self.sentences.push((code, note.into()));
    }

    /// All sentences, in the order in which they were added.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &str> {
        self.sentences.iter().map(|(_, note)| note.as_str())
    }

    /// All sentences with their codes, in the order in which they were added.
    pub fn coded(&self) -> &[(NoteCode, String)] {
        &self.sentences
    }

    /// The sentences on the revolution itself, before stages began to work on it, with their codes.
    pub fn of_revolution(&self) -> &[(NoteCode, String)] {
        &self.sentences[..self.of_revolution.unwrap_or(self.sentences.len()).min(self.sentences.len())]
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
    fn every_code_has_its_row_on_the_page() {
        let rows = NOTES_PAGE.lines().filter_map(|line| line.strip_prefix("| N"));
        let names: Vec<String> = rows.map(|row| format!("N{}", row.split(" |").next().unwrap_or_default())).collect();
        assert_eq!(names, NoteCode::NAMES);
        assert!(names.iter().all(|name| NoteCode::named(name).is_some_and(|code| format!("{code:?}") == *name)));
    }
}
