//! Entities put below another one, so that two recordings are one in the viewer.

use std::time::Duration;

use crosscut_rrd::messages::{ENTITY_PATH, chunk_of};
use rerun::StoreKind;
use rerun::external::re_log_types::{ArrowMsg, EntityPath};
use rerun::log::LogMsg;
use rerun::sink::{LogSink, SinkFlushError};

/// The message with its entity below another one.
///
/// # Errors
/// When it holds no chunk.
pub(crate) fn moved(arrow: &ArrowMsg, below: &EntityPath) -> Result<ArrowMsg, String> {
    let chunk = chunk_of(arrow)?;
    let path = below.join(chunk.entity_path());
    chunk.clone_with_new_entity_path(path).to_arrow_msg().map_err(|e| e.to_string())
}

/// A sink whose entities come out below another one. Layouts and the name of the recording pass unchanged.
pub(crate) struct Below {
    pub(crate) path: EntityPath,
    pub(crate) sink: Box<dyn LogSink>,
}

impl LogSink for Below {
    fn send(&self, message: LogMsg) {
        let message = match message {
            LogMsg::ArrowMsg(store, arrow) if store.kind() == StoreKind::Recording && !is_property(&arrow) => {
                let arrow = moved(&arrow, &self.path).unwrap_or(arrow);
                LogMsg::ArrowMsg(store, arrow)
            }
            other => other,
        };
        self.sink.send(message);
    }

    fn flush_blocking(&self, timeout: Duration) -> Result<(), SinkFlushError> {
        self.sink.flush_blocking(timeout)
    }
}

/// Whether the message is about the recording as a whole.
fn is_property(arrow: &ArrowMsg) -> bool {
    let entity = arrow.batch.schema_ref().metadata().get(ENTITY_PATH);
    entity.is_some_and(|entity| entity.starts_with("/__"))
}
