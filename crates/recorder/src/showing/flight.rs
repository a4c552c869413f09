//! The recordings of one flight, message by message.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crosscut_rrd::messages::{ENTITY_PATH, Messages, chunk_of};
use crosscut_rrd::parts::{Marks, files_named_like_parts};
use crosscut_rrd::{Damage, ReadError, Recording};
use rerun::external::re_log_types::{ArrowMsg, EntityPath, StoreId};
use rerun::log::{Chunk, LogMsg};
use rerun::{CoordinateFrame, StoreKind, TextDocument, Transform3D, components};

use super::error::ShowError;
use super::made::{self, Made, numbers};
use super::recolored::{Colors, recolored};
use crate::below::moved;
use crate::layout::Extent;
use crate::schema;
use crate::why::source_in;

/// What is read of a flight on the way, for what is shown beside it.
#[derive(Debug, Default)]
pub(super) struct Facts {
    /// Stamp and number of each revolution, ascending in the order of the file.
    pub(super) revolutions: Vec<[i64; 2]>,
    /// How far its views have to reach.
    pub(super) extent: Extent,
    /// The sensor's frame.
    pub(super) frame: Option<components::TransformFrameId>,
    /// How the sensor is turned in the body frame.
    pub(super) mounting: Option<components::RotationQuat>,
    /// The file and the preset that it was made of, as "tee.mcap, preset paper".
    pub(super) source: Option<String>,
    /// The settings, as TOML.
    pub(super) config_toml: String,
    /// Number of walls, confidence and true number by revolution.
    pub(super) walls: BTreeMap<i64, f64>,
    pub(super) confidence: BTreeMap<i64, f64>,
    pub(super) truth: BTreeMap<i64, f64>,
    /// What the stages before the report made, by revolution; only of flights that are shown side by side.
    pub(super) made: BTreeMap<i64, Made>,
    /// What its parts say of themselves.
    pub(super) marks: Marks,
}

/// Under which name, and where in the tree of entities, a flight is shown.
pub(super) struct Destination {
    pub(super) store: StoreId,
    /// The entity that everything is put below, if it is not the root.
    pub(super) below: Option<EntityPath>,
    /// Whether the layout of the recording is sent with it.
    pub(super) own_layout: bool,
    /// Other colours of its walls.
    pub(super) colors: Colors,
}

/// The files of one flight, in order.
pub(super) struct Flight {
    parts: Vec<PathBuf>,
    store: StoreId,
}

impl Flight {
    /// Looks at the files; parts that lie beside a single one are added.
    ///
    /// # Errors
    /// When one of them is no recording.
    pub(super) fn open(paths: &[PathBuf]) -> Result<Self, ShowError> {
        let mut parts = paths.to_vec();
        let store = store_of(&parts[0])?;
        for path in &parts[1..] {
            store_of(path)?;
        }
        if let [first] = paths {
            let others = files_named_like_parts(first).into_iter();
            parts.extend(others.filter(|path| store_of(path).is_ok_and(|other| other == store)));
        }
        Ok(Self { parts, store })
    }

    /// The recording's own name.
    pub(super) fn store(&self) -> &StoreId {
        &self.store
    }

    /// Hands over all messages; `take` says whether more are wanted. Gives what could not be read.
    pub(super) fn send(
        &self,
        destination: &Destination,
        facts: &mut Facts,
        take: &mut dyn FnMut(LogMsg) -> bool,
    ) -> Result<Vec<String>, ShowError> {
        let mut damages = Vec::new();
        for path in &self.parts {
            for message in Messages::open(path)? {
                let message = message.map_err(|damage| self.in_words(&damage));
                match message.and_then(|(_, message)| destination.put(message, facts)) {
                    Ok(Some(message)) => {
                        if !take(message) {
                            return Ok(damages);
                        }
                    }
                    Ok(None) => {}
                    Err(damage) => damages.push(damage),
                }
            }
        }
        damages.extend(facts.marks.missing(&self.parts[0]).iter().map(ToString::to_string));
        Ok(damages)
    }
}

impl Flight {
    /// A damage in words. How far a file that was cut off is whole, only all of its entities together tell.
    fn in_words(&self, damage: &Damage) -> String {
        let whole = damage.is_cut().then(|| Recording::open(&self.parts[0]).ok()).flatten();
        let is_it = |known: &&Damage| known.is_cut() && known.path() == damage.path();
        whole.as_ref().and_then(|of| of.damages().iter().find(is_it)).unwrap_or(damage).to_string()
    }
}

impl Destination {
    /// The message as it is shown; nothing if it is not.
    fn put(&self, mut message: LogMsg, facts: &mut Facts) -> Result<Option<LogMsg>, String> {
        if message.store_id().kind() == StoreKind::Blueprint {
            return Ok(self.own_layout.then_some(message));
        }
        message.set_store_id(self.store.clone());
        let LogMsg::ArrowMsg(_, arrow) = &message else { return Ok(Some(message)) };
        let entity = entity_of(arrow);
        facts.learn(&entity, arrow)?;
        let Some(below) = &self.below else { return Ok(Some(message)) };
        made::learn(&mut facts.made, &entity, &chunk_of(arrow)?);
        if self.colors.is_empty() {
            return Ok(Some(LogMsg::ArrowMsg(self.store.clone(), moved(arrow, below)?)));
        }
        let mut arrow = arrow.clone();
        arrow.batch = recolored(&arrow.batch, &self.colors);
        Ok(Some(LogMsg::ArrowMsg(self.store.clone(), moved(&arrow, below)?)))
    }
}

impl Facts {
    fn learn(&mut self, entity: &str, arrow: &ArrowMsg) -> Result<(), String> {
        const REPORT_JUNCTIONS: &str = schema::REPORT_JUNCTIONS.path;
        const REPORT_CONFIDENCE: &str = schema::REPORT_CONFIDENCE.path;
        const REPORT_WHY: &str = schema::REPORT_WHY.path;
        const TRUTH_WALLS: &str = schema::TRUTH_WALLS.path;
        const CONFIG: &str = schema::CONFIG.path;
        const PART: &str = schema::PART.path;
        const EXTENT: &str = schema::EXTENT.path;
        const SCAN_MOUNTING: &str = schema::SCAN_MOUNTING.path;
        match entity {
            REPORT_JUNCTIONS => {
                let chunk = chunk_of(arrow)?;
                let times = |name: &'static str| {
                    chunk.timelines().get(&name.into()).map_or(&[][..], |column| column.times_raw())
                };
                let pairs = times("stamp").iter().zip(times("revolution"));
                self.revolutions.extend(pairs.map(|(&stamp_ns, &seq)| [stamp_ns, seq]));
                self.walls.extend(numbers(&chunk));
            }
            REPORT_CONFIDENCE => self.confidence.extend(numbers(&chunk_of(arrow)?)),
            TRUTH_WALLS => self.truth.extend(numbers(&chunk_of(arrow)?)),
            REPORT_WHY if self.source.is_none() => {
                let text: Option<components::Text> = first(&chunk_of(arrow)?, &TextDocument::descriptor_text());
                self.source = text.and_then(|text| source_in(&text).map(str::to_owned));
            }
            CONFIG => {
                let text: Option<components::Text> = first(&chunk_of(arrow)?, &TextDocument::descriptor_text());
                self.config_toml = text.map(|text| text.to_string()).unwrap_or_default();
            }
            PART => self.marks.read(&chunk_of(arrow)?),
            EXTENT => self.extent = Extent::read(&chunk_of(arrow)?).unwrap_or(self.extent),
            SCAN_MOUNTING => {
                let chunk = chunk_of(arrow)?;
                self.frame = first(&chunk, &CoordinateFrame::descriptor_frame()).or(self.frame.take());
                self.mounting = first(&chunk, &Transform3D::descriptor_quaternion()).or(self.mounting.take());
            }
            _ => {}
        }
        Ok(())
    }

    /// Gives the walls of each revolution the colours of those of the other flight that share the most beams: by revolution the new
    /// class of each old one.
    pub(super) fn color_as(&mut self, other: &Self) -> Colors {
        let made = self.made.iter_mut();
        made.filter_map(|(seq, made)| Some((*seq, made.grouping.color_as(&other.made.get(seq)?.grouping)))).collect()
    }

    /// The revolution that was the latest at this time; before the first one, the first.
    pub(super) fn revolution_at(&self, stamp_ns: i64) -> i64 {
        let after = self.revolutions.partition_point(|[stamp, _]| *stamp <= stamp_ns);
        self.revolutions.get(after.saturating_sub(1)).map_or(0, |[_, seq]| *seq)
    }
}

/// The entity that a message is about; empty if it does not say.
pub(super) fn entity_of(arrow: &ArrowMsg) -> String {
    arrow.batch.schema_ref().metadata().get(ENTITY_PATH).cloned().unwrap_or_default()
}

/// The first value of a component, where there is one.
fn first<C: rerun::Component>(chunk: &Chunk, component: &rerun::ComponentDescriptor) -> Option<C> {
    chunk.component_batch(component.component, 0)?.ok()?.into_iter().next()
}

/// The recording that a file belongs to.
fn store_of(path: &Path) -> Result<StoreId, ShowError> {
    let cause = "it does not start with the name of a recording".to_owned();
    let mut recordings = Messages::recordings_in(path)?;
    match recordings.as_slice() {
        [] => Err(ReadError::Open { path: path.to_owned(), cause }.into()),
        [_] => Ok(recordings.remove(0)),
        several => {
            let ids = several.iter().map(|store| store.recording_id().to_string()).collect();
            Err(ReadError::Several { path: path.to_owned(), ids }.into())
        }
    }
}
