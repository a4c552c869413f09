//! Evaluations by family of scenes and configuration.

use crate::flights::FlightFigures;
use crate::{Evaluation, Score};

/// An evaluation for each family and configuration.
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
    /// The figures of its flights per configuration, if it has any whose mine is known.
    pub flights: Vec<Option<FlightFigures>>,
}

impl Scoreboard {
    /// A scoreboard of these configurations, without families.
    pub fn new(configurations: Vec<String>) -> Self {
        Self { configurations, families: Vec::new() }
    }

    /// Adds a revolution of `family`, scored for the configuration of this index. Families keep the order in which they
    /// are first added.
    ///
    /// # Panics
    /// If there is no such configuration.
    pub fn add(&mut self, family: &str, configuration: usize, score: &Score) {
        self.evaluation(family, configuration).add(score);
    }

    /// Adds an evaluation of `family` for the configuration of this index.
    ///
    /// # Panics
    /// If there is no such configuration.
    pub fn merge(&mut self, family: &str, configuration: usize, evaluation: &Evaluation) {
        self.evaluation(family, configuration).merge(evaluation);
    }

    /// Adds the figures of a flight of `family` for the configuration of this index.
    ///
    /// # Panics
    /// If there is no such configuration.
    pub fn add_flight(&mut self, family: &str, configuration: usize, figures: &FlightFigures) {
        let place = self.place_of(family);
        self.families[place].flights[configuration].get_or_insert_default().merge(figures);
    }

    /// The figures of the flights of all families for each configuration.
    pub fn all_flights(&self) -> Vec<Option<FlightFigures>> {
        let mut all = vec![None; self.configurations.len()];
        for family in &self.families {
            for (sum, part) in all.iter_mut().zip(&family.flights) {
                if let Some(part) = part {
                    sum.get_or_insert_with(FlightFigures::default).merge(part);
                }
            }
        }
        all
    }

    /// Names of the configurations.
    pub fn configurations(&self) -> &[String] {
        &self.configurations
    }

    /// The families.
    pub fn families(&self) -> &[Family] {
        &self.families
    }

    /// The sum over all families for each configuration. Every revolution has the same weight.
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
        let place = self.place_of(family);
        &mut self.families[place].evaluations[configuration]
    }

    fn place_of(&mut self, family: &str) -> usize {
        self.families.iter().position(|known| known.name == family).unwrap_or_else(|| {
            let evaluations = vec![Evaluation::default(); self.configurations.len()];
            let flights = vec![None; self.configurations.len()];
            self.families.push(Family { name: family.to_owned(), evaluations, flights });
            self.families.len() - 1
        })
    }
}
