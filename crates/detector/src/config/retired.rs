//! Settings of earlier versions.

/// Settings that are none any more, and what holds in their place.
pub(super) const RETIRED: [(&str, &str); 19] = [
    ("affinity.passage_m", "use vehicle.width_m"),
    ("affinity.island_m", "use report.island_m"),
    ("affinity.height_m", "use vehicle.height_m"),
    ("affinity.stretch_m", "it is 0.85 m, fixed"),
    ("affinity.straight_deg", "it is 36°, fixed"),
    ("affinity.way_deg", "it is 115°, fixed"),
    ("affinity.clear_share", "it is 1.15, fixed"),
    ("affinity.wall_deg", "it is 3°, fixed"),
    ("affinity.neighbours", "it is 2 returns, fixed"),
    ("affinity.eps_m", "kind threshold, which equals dbscan, has affinity.radius_m"),
    ("affinity.min_points", "kind threshold, which equals dbscan, has report.min_returns"),
    ("csv.unit", "use csv.columns with the unit, such as r*_mm, or ingest.range_scale"),
    ("spectral.weak_link", "it is 1e-3, fixed"),
    ("spectral.least_weight", "it is 1e-4, fixed"),
    ("kmeans.tolerance", "clusters are exact: rounds end when no return moves"),
    ("flight.look_ahead", "the steady answer rests on the scans before it"),
    ("flight.odometry_floor_m", "it is 0.005 m, fixed"),
    ("flight.least_look_m", "it is 2.5 times vehicle.width_m, fixed"),
    ("flight.farthest_look_m", "it is 12 m, fixed"),
];
