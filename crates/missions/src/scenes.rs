//! The journal of a mission, read again: the scenes that the vehicle sensed.

use std::path::Path;

use crosscut_ingest::Stored;
use crosscut_messages::{
    LaserScan, Message as _, ODOMETRY_TOPIC, Odometry, SCAN_TOPIC, TRUTH_MAP_TOPIC, TRUTH_TOPIC, Truth, TruthMap,
};
use crosscut_simulator::Scene;

use crate::ResumeError;

/// Reads the scenes that [`SceneRecorder`](crosscut_simulator::SceneRecorder) wrote, as far as the file is whole.
///
/// # Errors
/// If the file cannot be read, or has no scene with odometry and a true pose.
pub fn read_journal(path: &Path) -> Result<Vec<Scene>, ResumeError> {
    let mut scenes: Vec<Scene> = Vec::new();
    for message in Stored::open(path, &[SCAN_TOPIC, TRUTH_TOPIC, TRUTH_MAP_TOPIC, ODOMETRY_TOPIC])? {
        if message.topic == SCAN_TOPIC {
            let Ok(scan) = LaserScan::decode(&message.data) else { break };
            scenes.push(Scene::of_scan(message.log_time_ns, scan));
            continue;
        }
        // What belongs to a scan follows it, with its time.
        let Some(scene) = scenes.last_mut().filter(|scene| scene.stamp_ns == message.log_time_ns) else { continue };
        match message.topic.as_str() {
            TRUTH_TOPIC => scene.truth = Truth::from_json(&message.data).unwrap_or_default(),
            TRUTH_MAP_TOPIC => scene.map = TruthMap::from_json(&message.data).ok(),
            _ => scene.odometry = Odometry::decode(&message.data).ok(),
        }
    }
    let is_whole = |scene: &Scene| scene.odometry.is_some() && scene.truth.pose.is_some();
    scenes.truncate(scenes.iter().take_while(|scene| is_whole(scene)).count());
    if scenes.is_empty() { Err(ResumeError::NoFlight { journal: path.to_owned() }) } else { Ok(scenes) }
}
