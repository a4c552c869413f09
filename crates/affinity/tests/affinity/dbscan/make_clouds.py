"""Writes random clouds with scikit-learn's DBSCAN labels, to compare with: python make_clouds.py [SEED] > clouds.csv

A line is cloud,eps_m,min_points,x,y,z,label. Half of the clouds lie on a lattice of whole metres with an eps of 1 m, so
that distances equal to eps, coinciding points, and border points between two clusters are frequent.
"""

import sys

import numpy as np
from sklearn.cluster import DBSCAN

rng = np.random.default_rng(int(sys.argv[1]) if len(sys.argv) > 1 else 0)
for cloud in range(24):
    count = int(rng.integers(10, 60))
    if cloud % 2:
        points = rng.integers(0, 8, (count, 3)) * [1.0, 1.0, 0.0]
        eps = 1.0
    else:
        centres = rng.uniform(-5.0, 5.0, (4, 3))
        points = (centres[rng.integers(0, 4, count)] + rng.normal(0.0, 0.7, (count, 3))).round(6)
        eps = round(float(rng.uniform(0.4, 1.2)), 6)
    min_points = int(rng.integers(1, 7))
    labels = DBSCAN(eps=eps, min_samples=min_points).fit_predict(points)
    for (x, y, z), label in zip(points, labels):
        print(f"{cloud},{eps!r},{min_points},{float(x)!r},{float(y)!r},{float(z)!r},{label}")
