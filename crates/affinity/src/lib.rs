//! Revolution to affinity W.
