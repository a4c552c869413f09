//! Mines with known truth, a lidar, flights.
