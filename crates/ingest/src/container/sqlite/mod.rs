//! Tables of an SQLite file, read only.
//!
//! SQLite itself refuses a file that was cut off, and gives up at the first damaged page; of a damaged recording, every
//! whole row must be read. What rosbag2 uses of the format is small: tables by row number, rows that overflow onto
//! other pages, and the write-ahead log that a recorder leaves beside the file when it is killed.

mod pages;
mod rows;
mod tree;
mod wal;

pub(super) use self::pages::{MAGIC, Pages};
pub(super) use self::rows::{Cell, Record, cells_of, is_table_leaf};
pub(super) use self::tree::Leaves;
