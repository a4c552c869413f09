"""A stage of dora that knows nothing of crosscut but the columns: scikit-learn's embedding takes the place of `spectral`."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
from dora import Node
from numpy.typing import NDArray
from scipy.sparse import csr_array
from sklearn.manifold import spectral_embedding

Matrix = NDArray[np.float64]

ZERO = 1e-6


def embed(w: Matrix) -> tuple[Matrix, Matrix]:
    """Eigenvalues, and an orthonormal basis of the eigenvectors of those that are zero."""
    scale = 1.0 / np.sqrt(w.sum(axis=1))
    eigenvalues = np.linalg.eigvalsh(np.eye(len(w)) - scale[:, None] * w * scale)
    k = max(1, int((eigenvalues < ZERO).sum()))
    maps = spectral_embedding(w, n_components=k, drop_first=False, random_state=0, eigen_solver="arpack")
    return eigenvalues[: k + 1], np.linalg.qr(maps / scale[:, None])[0]


def main() -> None:
    node = Node()
    for event in node:
        if event["type"] == "STOP":
            return
        if event["type"] != "INPUT":
            continue
        frames = event["value"]
        if pa.types.is_struct(frames.type):
            arrays = {field.name: frames.field(at) for at, field in enumerate(frames.type)}
            made: dict[str, list[object]] = {name: [] for name in ("eigenvalues", "k", "u_value")}
            for starts, columns, values in zip(*(arrays.pop(f"w_{name}") for name in ("row_start", "column", "value"))):
                n = len(starts) - 1
                eigenvalues, u = embed(csr_array((values.values, columns.values, starts.values), shape=(n, n)).toarray())
                made["eigenvalues"].append(eigenvalues)
                made["k"].append(u.shape[1])
                made["u_value"].append(u.ravel())
            arrays |= {name: pa.array(column) for name, column in made.items()}
            none = pa.array([[]] * len(frames))
            arrays |= {"zero_tolerance": pa.array([ZERO] * len(frames)), "margin_decades": pa.array([np.nan] * len(frames))}
            arrays |= {"u_row_start": none, "u_column": none}
            frames = pa.StructArray.from_arrays(list(arrays.values()), list(arrays))
        node.send_output("frames", frames, event["metadata"])


if __name__ == "__main__":
    main()
