//! Recordings to revolutions.
