//! Partition to walls, openings, place and the results line.
