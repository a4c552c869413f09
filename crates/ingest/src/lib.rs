//! Recordings to revolutions.

mod container;
mod describe;
mod error;
mod found;
mod inputs;
mod loss;
mod recording;
mod sensor;
mod topics;

pub use describe::{Description, ScanDescription, TopicDescription, describe};
pub use error::IngestError;
pub use found::Found;
pub use inputs::recordings_in;
pub use loss::{Damage, Loss, LossKind};
pub use recording::{ReadOptions, Recording};
pub use sensor::{PARAMS, Sensor};
pub use topics::{TopicInfo, TopicList};
