//! The answer of a preset to a scene, as a panel of a figure.

use crosscut_detector::{Detector, Preset};
use crosscut_evaluate::Score;
use crosscut_evaluate::panel::Panel;
use crosscut_report::ResultsLine;
use crosscut_sensor::Sensor;
use crosscut_simulator::Scene;
use crosscut_stage::Frame;

/// A preset that answers scenes.
pub(crate) struct Answers(Detector);

impl Answers {
    pub(crate) fn of(preset: Preset) -> anyhow::Result<Self> {
        Ok(Self(Detector::builder().preset(preset).build()?))
    }

    /// Draws the answer, with the count above it.
    pub(crate) fn panel(&mut self, scene: &Scene) -> anyhow::Result<Panel> {
        self.0.detect(&scene.scan)?;
        let frame = self.0.frame();
        let score = Score::of(&scene.truth, &ResultsLine::of(frame))?;
        let count = score.reported_walls;
        let title = match (score.right, score.right_count()) {
            (true, _) => count.to_string(),
            (false, true) => format!("{count}, other walls"),
            (false, false) => format!("{count}, true: {}", score.true_walls),
        };
        Ok(Panel::of_answer(title, frame))
    }
}

/// Draws the truth of a scene under a title.
pub(crate) fn truth_panel(title: String, scene: &Scene) -> Panel {
    let sensor = Sensor::default();
    let mut frame = Frame::default();
    sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
    Panel::of_truth(title, &frame.revolution, &scene.truth)
}
