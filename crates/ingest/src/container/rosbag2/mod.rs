//! Bags of rosbag2 in SQLite (`.db3`): a row for each message.

mod tables;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::mem;
use std::path::Path;

use self::tables::{Entry, Tables};
use super::contents::TimeSample;
use super::resting_file::RestingFile;
use super::sqlite::{Leaves, Pages, cells_of, is_table_leaf};
use super::{ChannelId, Container, Contents, Message};
use crate::{Damage, Loss, LossKind};

/// A bag in an SQLite file.
pub(super) struct Rosbag2 {
    pages: Pages,
    tables: Tables,
    contents: Contents,
    /// Channels whose messages were not written in the order of their log times.
    unsorted: BTreeSet<ChannelId>,
    /// Whether all messages together were written in the order of their log times.
    is_sorted: bool,
    /// The messages that are whole, by log time, if the table is damaged.
    rescued: Option<Vec<Place>>,
    selected: BTreeSet<ChannelId>,
    plan: Plan,
    /// Buffers: a page onto which a row continues, and a row.
    page: Vec<u8>,
    row: Vec<u8>,
    spare: Vec<Vec<u8>>,
    losses: Vec<Loss>,
}

/// How messages are read, by log time either way.
enum Plan {
    /// Row by row: of a leaf page, the cells that are left, then the next leaf.
    Rows { leaves: Leaves, leaf: Vec<u8>, cells: VecDeque<usize> },
    /// From these places.
    Places { places: VecDeque<Place>, leaf: Vec<u8> },
}

/// Where a message is; places sort by log time, ties in the order of writing.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    log_time_ns: u64,
    row: i64,
    channel: Option<ChannelId>,
    page: u32,
    cell: usize,
}

/// What is wrong with a table, and on which page.
type PageDamage = (u32, Damage);

impl Rosbag2 {
    /// Looks through `file`; `path` names it in losses, and beside `log_beside` its write-ahead log may be. `None` if it
    /// is an SQLite file of another kind.
    ///
    /// # Errors
    /// When the tables cannot be found.
    pub(super) fn open(path: &Path, log_beside: &Path, file: RestingFile) -> Result<Option<Self>, Damage> {
        let bytes = file.length()?;
        let mut pages = Pages::open(log_beside, file)?;
        let Some((tables, channels)) = Tables::read(&mut pages)? else { return Ok(None) };
        let contents =
            Contents { path: path.to_owned(), bytes, format: "rosbag2 in SQLite", channels, ..Contents::default() };
        let mut bag = Self {
            pages,
            tables,
            contents,
            unsorted: BTreeSet::new(),
            is_sorted: true,
            rescued: None,
            selected: BTreeSet::new(),
            plan: Plan::Places { places: VecDeque::new(), leaf: Vec::new() },
            page: Vec::new(),
            row: Vec::new(),
            spare: Vec::new(),
            losses: Vec::new(),
        };
        let cut_at_byte = bag.pages.cut_at_byte();
        let surveyed = if cut_at_byte.is_some() { Ok(()) } else { bag.survey() };
        let loss = match (cut_at_byte, surveyed) {
            (Some(at_byte), _) => Some(LossKind::CutOff { at_byte }),
            (None, Err((page, damage))) => {
                Some(LossKind::Part { at_byte: bag.pages.at_byte(page), scans: None, damage })
            }
            (None, Ok(())) => None,
        };
        if let Some(kind) = loss {
            bag.contents.losses.push(Loss { file: path.to_owned(), kind });
            bag.rescue();
        }
        bag.pages.rest()?;
        Ok(Some(bag))
    }

    /// Counts the messages, and finds out whether they were written by log time.
    fn survey(&mut self) -> Result<(), PageDamage> {
        let (mut counts, mut latest_ns) = (Counts::default(), BTreeMap::new());
        let (mut unsorted, mut is_sorted) = (BTreeSet::new(), true);
        let mut last_ns = 0;
        self.walk(|place| {
            counts.add(place);
            let Some(channel) = place.channel else { return };
            let latest = latest_ns.entry(channel).or_insert(0);
            if place.log_time_ns < mem::replace(latest, place.log_time_ns) {
                unsorted.insert(channel);
            }
            is_sorted &= place.log_time_ns >= mem::replace(&mut last_ns, place.log_time_ns);
        })?;
        (self.unsorted, self.is_sorted) = (unsorted, is_sorted);
        self.state(counts);
        Ok(())
    }

    /// Finds every message that is whole, on whatever page.
    fn rescue(&mut self) {
        let mut places = Vec::new();
        let mut leaf = Vec::new();
        for page in 1..=self.pages.count() {
            if self.pages.read(page, &mut leaf).is_err() || !is_table_leaf(&leaf, page) {
                continue;
            }
            for cell in cells_of(&leaf, page).unwrap_or_default() {
                if let Ok((place, entry)) = self.place(&leaf, page, cell)
                    && self.pages.read_row(&leaf, &entry.cell, &mut self.page, &mut self.row).is_ok()
                {
                    places.push(place);
                }
            }
        }
        places.sort_unstable_by_key(|place| (place.row, place.page));
        places.dedup_by_key(|place| place.row);
        places.sort_unstable();
        let mut counts = Counts::default();
        places.iter().for_each(|place| counts.add(*place));
        self.state(counts);
        self.rescued = Some(places);
    }

    fn state(&mut self, counts: Counts) {
        if counts.of_unknown_topics > 0 {
            let kind = LossKind::UnknownTopic { count: counts.of_unknown_topics };
            self.contents.losses.push(Loss { file: self.contents.path.clone(), kind });
        }
        (self.contents.counts, self.contents.log_times_ns) = (Some(counts.messages), counts.log_times_ns);
    }

    /// Hands the place of every message to `take`, in the order of writing.
    fn walk(&mut self, mut take: impl FnMut(Place)) -> Result<(), PageDamage> {
        let (mut leaves, mut leaf) = (Leaves::of(self.tables.messages), Vec::new());
        while let Some(page) = leaves.next(&mut self.pages, &mut leaf)? {
            for cell in cells_of(&leaf, page).map_err(|damage| (page, damage))? {
                take(self.place(&leaf, page, cell).map_err(|damage| (page, damage))?.0);
            }
        }
        Ok(())
    }

    fn place(&self, leaf: &[u8], page: u32, cell: usize) -> Result<(Place, Entry), Damage> {
        let entry = self.tables.entry(&self.pages, leaf, cell)?;
        let Entry { channel, log_time_ns, .. } = entry;
        Ok((Place { log_time_ns, row: entry.cell.row, channel, page, cell }, entry))
    }

    /// The message at `place`, whose page is `leaf`.
    fn message(&mut self, leaf: &[u8], place: Place, entry: &Entry) -> Result<Message, Damage> {
        self.pages.read_row(leaf, &entry.cell, &mut self.page, &mut self.row)?;
        let bytes = self.row.get(entry.data.clone()).ok_or(Damage::Ended)?;
        let mut data = self.spare.pop().unwrap_or_default();
        data.clear();
        data.extend_from_slice(bytes);
        Ok(Message { channel: place.channel.unwrap_or_default(), log_time_ns: place.log_time_ns, data, damage: None })
    }

    fn is_selected(&self, place: &Place) -> bool {
        place.channel.is_some_and(|channel| self.selected.contains(&channel))
    }

    fn lose_rest(&mut self, (page, damage): PageDamage) {
        let kind = LossKind::Rest { at_byte: self.pages.at_byte(page), damage };
        self.losses.push(Loss { file: self.contents.path.clone(), kind });
    }

    /// Reads the next message as `plan` says.
    fn read(&mut self, plan: &mut Plan) -> Result<Option<Message>, PageDamage> {
        let at = |page: u32| move |damage| (page, damage);
        match plan {
            Plan::Places { places, leaf } => {
                let Some(place) = places.pop_front() else { return Ok(None) };
                let mut read = |bag: &mut Self| {
                    bag.pages.read(place.page, leaf)?;
                    let (_, entry) = bag.place(leaf, place.page, place.cell)?;
                    bag.message(leaf, place, &entry)
                };
                read(self).map(Some).map_err(at(place.page))
            }
            Plan::Rows { leaves, leaf, cells } => loop {
                while let Some(cell) = cells.pop_front() {
                    let (place, entry) = self.place(leaf, 0, cell).map_err(at(0))?;
                    if self.is_selected(&place) {
                        return self.message(leaf, place, &entry).map(Some).map_err(at(0));
                    }
                }
                let Some(page) = leaves.next(&mut self.pages, leaf)? else { return Ok(None) };
                *cells = cells_of(leaf, page).map_err(at(page))?.into();
            },
        }
    }
}

impl Container for Rosbag2 {
    fn contents(&self) -> &Contents {
        &self.contents
    }

    fn contents_mut(&mut self) -> &mut Contents {
        &mut self.contents
    }

    fn select(&mut self, channels: &BTreeSet<ChannelId>) {
        self.selected.clone_from(channels);
        let is_sorted = self.is_sorted || channels.len() == 1 && self.unsorted.is_disjoint(channels);
        let mut places = VecDeque::new();
        if let Some(rescued) = &self.rescued {
            places.extend(rescued.iter().filter(|place| self.is_selected(place)));
        } else if is_sorted {
            let leaves = Leaves::of(self.tables.messages);
            self.plan = Plan::Rows { leaves, leaf: Vec::new(), cells: VecDeque::new() };
            return;
        } else {
            let mut found = Vec::new();
            let selected = channels.clone();
            let walked = self.walk(|place| {
                found.extend(place.channel.filter(|channel| selected.contains(channel)).map(|_| place));
            });
            walked.unwrap_or_else(|damage| self.lose_rest(damage));
            found.sort_unstable();
            places.extend(found);
        }
        self.plan = Plan::Places { places, leaf: Vec::new() };
    }

    fn next(&mut self) -> Option<Message> {
        let mut plan = mem::replace(&mut self.plan, Plan::Places { places: VecDeque::new(), leaf: Vec::new() });
        let message = self.read(&mut plan);
        match message {
            Ok(message) => {
                self.plan = plan;
                message
            }
            // The file was whole when it was looked through: since then it has changed, or it has gone.
            Err(damage) => {
                self.lose_rest(damage);
                None
            }
        }
    }

    fn recycle(&mut self, message: Message) {
        self.spare.push(message.data);
    }

    fn is_by_log_time(&self) -> bool {
        true
    }

    fn take_losses(&mut self) -> Vec<Loss> {
        mem::take(&mut self.losses)
    }
}

/// How many messages there are, and when they were recorded.
#[derive(Default)]
struct Counts {
    messages: BTreeMap<ChannelId, u64>,
    of_unknown_topics: u64,
    log_times_ns: TimeSample,
}

impl Counts {
    fn add(&mut self, Place { log_time_ns, channel, .. }: Place) {
        match channel {
            Some(channel) => *self.messages.entry(channel).or_default() += 1,
            None => self.of_unknown_topics += 1,
        }
        self.log_times_ns.add(log_time_ns);
    }
}
