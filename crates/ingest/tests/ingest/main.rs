//! Ingest from outside: recordings built in memory, whole and damaged, and real ones where they are at hand.

mod damaged;
mod flight;
mod messages;
mod parts;
mod real;
mod recording;
mod sensor;
mod truths;
mod turns;
