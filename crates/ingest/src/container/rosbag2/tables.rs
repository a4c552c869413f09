//! The tables of a bag: topics, and where the columns of a message are.

use std::collections::BTreeMap;
use std::ops::Range;

use crosscut_messages::CDR_ENCODING;

use crate::container::sqlite::{Cell, Leaves, Pages, Record, cells_of};
use crate::container::{ChannelId, Topic};
use crate::{Damage, limits};

/// The page on which SQLite lists the tables of a file.
const LIST_OF_TABLES: u32 = 1;

/// Where the messages of a bag are, and the topics that they may have.
pub(super) struct Tables {
    /// Root page of the table of messages.
    pub(super) messages: u32,
    /// Number of columns of a message.
    columns: usize,
    topic_column: usize,
    time_column: usize,
    data_column: usize,
    /// Channel of each topic, by its row.
    channels: BTreeMap<i64, ChannelId>,
}

/// What the row of a message says.
pub(super) struct Entry {
    pub(super) cell: Cell,
    /// `None` if the topic is not defined.
    pub(super) channel: Option<ChannelId>,
    pub(super) log_time_ns: u64,
    /// Where the message is in the row.
    pub(super) data: Range<usize>,
}

/// What each channel carries.
type Carried = BTreeMap<ChannelId, Topic>;

/// A table, as the list of tables describes it.
struct Table {
    root: u32,
    columns: Vec<String>,
}

impl Table {
    fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.eq_ignore_ascii_case(name))
    }
}

impl Tables {
    /// Finds the tables, and what each channel carries; `None` if they are not those of a bag.
    pub(super) fn read(pages: &mut Pages) -> Result<Option<(Self, Carried)>, Damage> {
        let mut tables = BTreeMap::new();
        each_row(pages, LIST_OF_TABLES, |_, row, record| {
            let text = |column| record.text(row, column).unwrap_or_default();
            if text(0) == "table"
                && let Some(root) = record.integer(row, 3).and_then(|root| u32::try_from(root).ok())
            {
                tables.insert(text(1), Table { root, columns: columns_in(&text(4)) });
            }
        })?;
        let (Some(messages), Some(topics)) = (tables.get("messages"), tables.get("topics")) else { return Ok(None) };
        let [topic, time, data] = ["topic_id", "timestamp", "data"].map(|name| messages.column(name));
        let (Some(topic_column), Some(time_column), Some(data_column)) = (topic, time, data) else { return Ok(None) };
        let (mut channels, mut carried) = (BTreeMap::new(), BTreeMap::new());
        let read = each_row(pages, topics.root, |row_number, row, record| {
            let text = |name| topics.column(name).and_then(|column| record.text(row, column)).unwrap_or_default();
            let encoding = text("serialization_format");
            let schema_encoding = if encoding == CDR_ENCODING { "ros2msg" } else { "" }.to_owned();
            let topic = Topic { name: text("name"), type_name: text("type"), encoding, schema_encoding };
            if channels.len() < limits::CHANNELS {
                let channel = channels.len() as ChannelId;
                channels.insert(row_number, channel);
                carried.insert(channel, topic);
            }
        });
        // Messages of topics that are lost are counted as such.
        read.or_else(|damage| if carried.is_empty() { Err(damage) } else { Ok(()) })?;
        let (root, columns) = (messages.root, messages.columns.len());
        let found = Self { messages: root, columns, topic_column, time_column, data_column, channels };
        Ok(Some((found, carried)))
    }

    /// What the row of a message says that begins at `cell` of a leaf page.
    pub(super) fn entry(&self, pages: &Pages, leaf: &[u8], cell: usize) -> Result<Entry, Damage> {
        let cell = pages.cell(leaf, cell)?;
        let record = pages.start_of_row(leaf, &cell)?;
        let row = cell.local_part(leaf);
        let parsed = (|| {
            let topic = record.integer(row, self.topic_column)?;
            let time_ns = record.integer(row, self.time_column)?;
            Some((topic, time_ns, record.blob(self.data_column)?))
        })();
        match parsed {
            Some((topic, time_ns, data)) if record.len() == self.columns && data.end as u64 <= cell.bytes => {
                let channel = self.channels.get(&topic).copied();
                Ok(Entry { cell, channel, log_time_ns: time_ns.max(0) as u64, data })
            }
            _ => Err(Damage::Record(format!("row {} is no message", cell.row))),
        }
    }
}

/// Hands every row of a table to `take`: its number, its bytes and its columns.
fn each_row(pages: &mut Pages, root: u32, mut take: impl FnMut(i64, &[u8], &Record)) -> Result<(), Damage> {
    let (mut leaves, mut leaf, mut page, mut row) = (Leaves::of(root), Vec::new(), Vec::new(), Vec::new());
    while let Some(number) = leaves.next(pages, &mut leaf).map_err(|(_, damage)| damage)? {
        for cell in cells_of(&leaf, number)? {
            let cell = pages.cell(&leaf, cell)?;
            pages.read_row(&leaf, &cell, &mut page, &mut row)?;
            take(cell.row, &row, &Record::parse(&row)?);
        }
    }
    Ok(())
}

/// The names of the columns in the definition of a table.
fn columns_in(definition: &str) -> Vec<String> {
    let inside =
        definition.split_once('(').and_then(|(_, rest)| rest.rsplit_once(')')).map_or("", |(inside, _)| inside);
    let first_word = |column: &str| column.split_whitespace().next().map(str::to_owned);
    let is_constraint = |word: &String| {
        ["CONSTRAINT", "PRIMARY", "UNIQUE", "CHECK", "FOREIGN"].iter().any(|name| word.eq_ignore_ascii_case(name))
    };
    let unquoted = |word: String| word.trim_matches(['"', '`', '[', ']', '\'']).to_owned();
    inside.split(',').filter_map(first_word).filter(|word| !is_constraint(word)).map(unquoted).collect()
}

#[cfg(test)]
mod tests {
    use super::columns_in;

    #[test]
    fn columns_are_named_as_in_the_definition() {
        let definition = "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,\n \"timestamp\" INTEGER \
                          NOT NULL, data BLOB NOT NULL, FOREIGN KEY(topic_id) REFERENCES topics(id))";
        assert_eq!(columns_in(definition), ["id", "topic_id", "timestamp", "data"]);
        assert_eq!(columns_in("CREATE TABLE"), [""; 0]);
    }
}
