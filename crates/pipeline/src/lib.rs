//! Configuration, registry, engine and the streaming pipeline.
