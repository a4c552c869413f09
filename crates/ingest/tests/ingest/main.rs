//! Ingest from outside: recordings built in memory, whole and damaged, and real ones where they are at hand.

mod bags;
mod cloud_files;
mod damaged;
mod flight;
mod formats;
mod limits;
mod live;
mod messages;
mod odometry;
mod parts;
mod real;
mod recording;
mod scanners;
mod single_clouds;
mod streams;
mod tables;
mod times;
mod truths;
mod turning;
mod turns;
