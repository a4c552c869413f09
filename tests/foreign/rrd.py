"""Values of a recording, read back with Rerun's own Python reader."""

import io
import subprocess
import warnings
from collections import defaultdict
from pathlib import Path

import numpy as np
import rerun
from PIL import Image
from rerun.experimental import RrdReader

# The program itself; the `rerun` command of the package is a shim that outlives a signal.
RERUN = Path(rerun.__file__).parents[1] / "rerun_cli" / "rerun"


def rerun_command(*args) -> subprocess.CompletedProcess:
    return subprocess.run([RERUN, *map(str, args)], stdin=subprocess.DEVNULL, capture_output=True, text=True)


def _chunks(path: Path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it says when there is no footer
        return RrdReader(path).stream()


def timelines(path: Path) -> dict[str, set[str]]:
    """For each entity its timelines; none for one that is static alone."""
    found: dict[str, set[str]] = defaultdict(set)
    for chunk in _chunks(path):
        found[chunk.entity_path].update(chunk.timeline_names)
    return dict(found)


def last_stamp_ns(path: Path) -> dict[str, int]:
    """For each entity that changes, the last stamp at which it was logged; also in a file without its footer."""
    last: dict[str, int] = {}
    for chunk in _chunks(path):
        if "stamp" in chunk.timeline_names:
            stamps = chunk.to_record_batch().column("stamp").cast("int64").to_numpy()
            last[chunk.entity_path] = max(last.get(chunk.entity_path, 0), int(stamps.max()))
    return last


def values(path: Path, entity: str, component: str) -> dict[int, object]:
    """What an entity holds, by revolution: arrays for tensors, charts and pictures, else a list."""
    found = {}
    for chunk in _chunks(path).filter(content=entity):
        batch = chunk.to_record_batch()
        if component in batch.schema.names and "revolution" in chunk.timeline_names:
            for revolution, cell in zip(batch.column("revolution").to_pylist(), batch.column(component)):
                if cell.values is not None:
                    found[revolution] = _decoded(component, cell.values)
    return found


def _decoded(component: str, cell):
    if component in ("Tensor:data", "BarChart:values"):
        shape = cell.field("shape")[0].as_py()
        return cell.field("buffer")[0].value.values.to_numpy(zero_copy_only=False).reshape(shape)
    if component == "EncodedDepthImage:blob":
        return np.array(Image.open(io.BytesIO(cell[0].values.to_numpy().tobytes())))
    return cell.to_pylist()
