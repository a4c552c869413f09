//! Embedding U to a partition of the returns.
