//! The properties that the rest of the program relies on in an affinity: one body of tests for every kind.
//!
//! An affinity of your own runs them in a test of its own; random inputs are the same in every run:
//!
//! ```
//! use crosscut_stage::{Affinity, AffinityStage, Kind, Notes, Revolution, StageError};
//!
//! /// Every return on its own: W = I.
//! struct Alone;
//!
//! const KIND: Kind<dyn AffinityStage> =
//!     Kind::affinity("alone", "every return on its own", |_| Box::new(Alone));
//!
//! impl AffinityStage for Alone {
//!     fn weigh(&mut self, revolution: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
//!         let w = out.weights.make_sparse();
//!         (0..revolution.len() as u32).for_each(|i| w.push_row(&[i], &[1.0]));
//!         Ok(())
//!     }
//! }
//!
//! crosscut_conformance::affinity::all(&KIND);
//! ```

pub mod affinity;
pub mod revolutions;

use std::fmt::Debug;

use proptest::prelude::Strategy;
use proptest::test_runner::{Config, RngSeed, TestRunner};

/// Runs `body`, which asserts, on this many inputs, the same ones in every run.
///
/// # Panics
/// When `body` does; with the smallest input found for which it does, under the name of what is tested.
pub fn for_many<T: Debug>(tested: &str, cases: u32, inputs: &impl Strategy<Value = T>, body: impl Fn(T)) {
    let config = Config { cases, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..Config::default() };
    let ran = TestRunner::new(config).run(inputs, |input| {
        body(input);
        Ok(())
    });
    ran.unwrap_or_else(|error| panic!("{tested}: {error}"));
}
