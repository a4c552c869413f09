//! ROS 2 messages and truth as Rust values, to and from CDR and JSON.
