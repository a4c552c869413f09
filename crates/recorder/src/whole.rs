//! What holds for the whole recording. Each file of it begins with that, so that it can be opened alone.

use rerun::{MediaType, RecordingStream, RecordingStreamResult, TextDocument};

use crate::colors::annotation_context;
use crate::mine::Mine;
use crate::options::{RecorderError, RecorderOptions};
use crate::schema::{ABOUT, COLORS, CONFIG};
use crate::scope::Detail;
use crate::{
    eigenvectors, flight_map, gaps, matrices, numbers, partition, profile, report, scan, schema, spectrum, timing,
    truth, ways, why,
};

/// Logs what holds for the whole recording: colours, look, configuration, the text of `/about`, and the mine of a mission.
pub(crate) fn log(rec: &RecordingStream, options: &RecorderOptions, mine: Option<&Mine>) -> Result<(), RecorderError> {
    mine.map_or(Ok(()), |mine| mine.log_static(rec))?;
    rec.log_static(COLORS.path, &annotation_context())?;
    log_config(rec, &options.config_toml)?;
    rec.log_static(ABOUT.path, &TextDocument::from_markdown(about()))?;
    scan::log_static(rec)?;
    ways::log_static(rec)?;
    if options.scope.detail != Detail::Light {
        matrices::log_static(rec)?;
        eigenvectors::log_static(rec)?;
    }
    spectrum::log_static(rec)?;
    partition::log_static(rec)?;
    profile::log_static(rec)?;
    flight_map::log_static(rec)?;
    report::log_static(rec)?;
    timing::log_static(rec)?;
    truth::log_static(rec)?;
    gaps::log_static(rec)?;
    why::log_static(rec)?;
    numbers::log_static(rec)?;
    Ok(())
}

/// Logs the configuration.
pub(crate) fn log_config(rec: &RecordingStream, toml: &str) -> RecordingStreamResult<()> {
    rec.log_static(CONFIG.path, &TextDocument::new(toml).with_media_type(MediaType::TEXT))
}

/// The text of `/about`, with a row for each entity.
fn about() -> String {
    format!("{}\n{}", include_str!("about.md"), schema::markdown_table())
}
