//! The topics of a recording, as people see them.

use std::fmt;

use crosscut_stage::counted;

/// A topic of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TopicInfo {
    /// Its name.
    pub name: String,
    /// Type of its messages; empty if the recording does not say.
    pub type_name: String,
    /// Encoding of its messages.
    pub encoding: String,
    /// Encoding of the definition of its type; empty if the recording does not say.
    pub schema_encoding: String,
    /// How many messages it has, if they are counted.
    pub messages: Option<u64>,
}

/// This many topics are listed; people look no further.
const MOST_LISTED: usize = 100;

/// Topics, one a line when displayed; of very many, the first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TopicList(pub Vec<TopicInfo>);

impl fmt::Display for TopicList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, topic) in self.0.iter().take(MOST_LISTED).enumerate() {
            let TopicInfo { name, type_name, encoding, messages, .. } = topic;
            let count = messages.map(|count| counted(count, "message")).unwrap_or_default();
            let type_name = if type_name.is_empty() { "(no schema)" } else { type_name };
            let line = format!("  {name}  {type_name}  {encoding}  {count}");
            write!(f, "{}{}", if i == 0 { "" } else { "\n" }, line.trim_end())?;
        }
        match self.0.len().saturating_sub(MOST_LISTED) {
            0 => Ok(()),
            more => write!(f, "\n  and {more} more"),
        }
    }
}
