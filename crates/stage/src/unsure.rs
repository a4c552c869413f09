//! Whether the answers of a flight are unsure.

/// A confidence below this is low.
const LOW: f64 = 0.5;
/// A low confidence has recovered once it is above this.
const RECOVERED: f64 = 0.8;

/// Whether the answers of a flight are unsure: from a low confidence on, until it has recovered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unsure(bool);

impl Unsure {
    /// Takes the confidence of the next answer, 0 to 1, and returns whether the answers are unsure now. An answer without a
    /// confidence changes nothing.
    pub fn after(&mut self, confidence: Option<f64>) -> bool {
        if let Some(confidence) = confidence {
            self.0 = confidence < LOW || (self.0 && confidence <= RECOVERED);
        }
        self.0
    }

    /// Whether the last answers are unsure.
    pub fn is_unsure(self) -> bool {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_unsure_until_the_confidence_has_recovered() {
        let mut unsure = Unsure::default();
        let confidences = [0.6, 0.49, 0.7, 0.81, 0.6].map(Some);
        let states: Vec<bool> = confidences.into_iter().map(|confidence| unsure.after(confidence)).collect();
        assert_eq!(states, [false, true, true, false, false]);
        assert!(unsure.after(Some(0.1)) && unsure.after(None) && unsure.is_unsure());
    }
}
