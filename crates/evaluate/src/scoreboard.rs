//! Families of scenes against configurations.

use crate::{Evaluation, Score};

/// An evaluation per family and configuration, and per configuration in all.
#[derive(Clone, Debug)]
pub struct Scoreboard {
    configurations: Vec<String>,
    families: Vec<Family>,
}

/// One family of scenes.
#[derive(Clone, Debug)]
pub struct Family {
    /// Its name.
    pub name: String,
    /// One evaluation per configuration, in their order.
    pub evaluations: Vec<Evaluation>,
}

impl Scoreboard {
    /// Of these configurations, with no family yet.
    pub fn new(configurations: Vec<String>) -> Self {
        Self { configurations, families: Vec::new() }
    }

    /// Takes in one more revolution of `family` as the configuration of this index answered it. Families keep the order
    /// in which they first come.
    ///
    /// # Panics
    /// When there is no such configuration.
    pub fn add(&mut self, family: &str, configuration: usize, score: &Score) {
        self.evaluation(family, configuration).add(score);
    }

    /// Takes in a whole evaluation of `family` by the configuration of this index.
    ///
    /// # Panics
    /// When there is no such configuration.
    pub fn merge(&mut self, family: &str, configuration: usize, evaluation: &Evaluation) {
        self.evaluation(family, configuration).merge(evaluation);
    }

    /// Names of the configurations.
    pub fn configurations(&self) -> &[String] {
        &self.configurations
    }

    /// The families.
    pub fn families(&self) -> &[Family] {
        &self.families
    }

    /// All families together, revolution by revolution: a family counts by its size.
    pub fn all(&self) -> Vec<Evaluation> {
        let mut all = vec![Evaluation::default(); self.configurations.len()];
        for family in &self.families {
            for (sum, part) in all.iter_mut().zip(&family.evaluations) {
                sum.merge(part);
            }
        }
        all
    }

    fn evaluation(&mut self, family: &str, configuration: usize) -> &mut Evaluation {
        let place = self.families.iter().position(|known| known.name == family).unwrap_or_else(|| {
            let evaluations = vec![Evaluation::default(); self.configurations.len()];
            self.families.push(Family { name: family.to_owned(), evaluations });
            self.families.len() - 1
        });
        &mut self.families[place].evaluations[configuration]
    }
}
