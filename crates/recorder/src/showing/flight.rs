//! The recording of one flight, message by message.

use std::path::PathBuf;

use crosscut_rrd::messages::{ENTITY_PATH, Messages};
use crosscut_rrd::{Damage, ReadError, Recording};
use rerun::StoreKind;
use rerun::external::re_log_types::{ArrowMsg, EntityPath, StoreId};
use rerun::log::LogMsg;

use super::error::ShowError;
use crate::below::moved;
use crate::layout::Extent;
use crate::schema::{EXTENT, REPORT_JUNCTIONS};

/// Under which name, and where in the tree of entities, a flight is shown.
pub(super) struct Destination {
    pub(super) store: StoreId,
    /// The entity that everything is put below, if it is not the root.
    pub(super) below: Option<EntityPath>,
    /// Whether the layout of the recording is sent with it.
    pub(super) own_layout: bool,
    /// Which entities are left out.
    pub(super) without: fn(&str) -> bool,
}

/// A recording that is shown.
pub(super) struct Flight {
    pub(super) recording: Recording,
    store: StoreId,
}

impl Flight {
    /// Looks at the files; parts that lie beside a single one are added.
    ///
    /// # Errors
    /// When one of them is no recording.
    pub(super) fn open(paths: &[PathBuf]) -> Result<Self, ShowError> {
        let recording = Recording::open_parts(paths)?;
        let cause = "it does not start with the name of a recording".to_owned();
        let store = recording.store().ok_or_else(|| ReadError::Open { path: paths[0].clone(), cause })?.clone();
        Ok(Self { recording, store })
    }

    /// The recording's own name.
    pub(super) fn store(&self) -> &StoreId {
        &self.store
    }

    /// What could not be read, in words.
    pub(super) fn damages(&self) -> impl Iterator<Item = String> {
        self.recording.damages().iter().map(Damage::to_string)
    }

    /// Stamp and number of each revolution, ascending.
    pub(super) fn revolutions(&self) -> Vec<[i64; 2]> {
        let rows = self.recording.rows(REPORT_JUNCTIONS.path).into_iter().flatten().flatten();
        rows.map(|row| [row.stamp_ns.unwrap_or(0), row.revolution]).collect()
    }

    /// How far its views have to reach.
    pub(super) fn extent(&self) -> Extent {
        let extent = self.recording.value_throughout(EXTENT.path, EXTENT.values).ok().flatten();
        extent.and_then(|values| Extent::of_values(&values.to_f64())).unwrap_or_default()
    }

    /// Hands over all messages; `take` says whether more are wanted.
    pub(super) fn send(&self, to: &Destination, take: &mut dyn FnMut(LogMsg) -> bool) -> Result<(), ShowError> {
        for path in self.recording.paths() {
            let mut messages = Messages::open(path)?.flatten().filter_map(|(_, message)| to.put(message));
            if !messages.all(&mut *take) {
                break;
            }
        }
        Ok(())
    }
}

impl Destination {
    /// The message as it is shown; nothing if it is not.
    fn put(&self, mut message: LogMsg) -> Option<LogMsg> {
        if message.store_id().kind() == StoreKind::Blueprint {
            return self.own_layout.then_some(message);
        }
        message.set_store_id(self.store.clone());
        let LogMsg::ArrowMsg(store, arrow) = &message else { return Some(message) };
        if (self.without)(&entity_of(arrow)) {
            return None;
        }
        let Some(below) = &self.below else { return Some(message) };
        Some(LogMsg::ArrowMsg(store.clone(), moved(arrow, below).ok()?)) // what cannot be read is among the damages
    }
}

/// The entity that a message is about; empty if it does not say.
fn entity_of(arrow: &ArrowMsg) -> String {
    arrow.batch.schema_ref().metadata().get(ENTITY_PATH).cloned().unwrap_or_default()
}
