"""Errors are exceptions with the program's words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import crosscut


@pytest.mark.parametrize(
    ("make", "error", "text"),
    [
        (lambda: crosscut.Engine("papr"), crosscut.SettingsError, "did you mean paper"),
        (lambda: crosscut.Engine(affinity={"kind": "rbv"}), crosscut.SettingsError, "did you mean rbf"),
        (lambda: crosscut.Engine("paper", affinity={"sigma": 1}), crosscut.SettingsError, "did you mean sigma_per_m2"),
        (lambda: crosscut.Engine(settings={"affinity": 1}), crosscut.SettingsError, "not of the form section.key=value"),
        (lambda: crosscut.Engine(vehicle={"width_m": -1}), crosscut.SettingsError, "width_m = -1.0 is not allowed"),
        (lambda: crosscut.Engine(afinity="rbf"), TypeError, "there is no argument or section 'afinity'"),
        (lambda: crosscut.read("absent.mcap"), crosscut.ReadError, "there is no file or folder absent.mcap"),
        (lambda: crosscut.count([[1.0]], 0, 0.1), TypeError, "not an array of one dimension"),
        (lambda: crosscut.Engine().process(np.zeros(3)), TypeError, "not an array of two dimensions"),
        (lambda: crosscut.Engine().process(np.zeros((3, 4))), ValueError, "2 or 3 columns, not 4"),
        (lambda: crosscut.Engine().process([[0, np.nan]]), ValueError, "point 0 is not finite"),
        (lambda: crosscut.Engine().process_many([], workers=0), ValueError, "workers is 1 to 256, not 0"),
        (lambda: crosscut.Engine().process_many([], workers=1 << 40), ValueError, "workers is 1 to 256"),
        (lambda: crosscut.Flight("x"), TypeError, "engine is a crosscut.Engine"),  # type: ignore[arg-type]
        (lambda: crosscut.Navigator("x"), TypeError, "engine is a crosscut.Engine"),  # type: ignore[arg-type]
        (lambda: crosscut.Engine(settings=1), TypeError, "settings is a mapping"),  # type: ignore[arg-type]
        (lambda: crosscut.results("absent.jsonl"), crosscut.ReadError, "there is no file absent.jsonl"),
        (lambda: crosscut.results(__file__), crosscut.ReadError, "has no lines of results"),
        (lambda: crosscut.results("."), crosscut.ReadError, "cannot be read"),
        (lambda: crosscut.compare("x", "paper"), TypeError, "configurations are texts"),
        (lambda: crosscut.read("x", every=-1), ValueError, "every is 1 or more, not -1"),
        (lambda: crosscut.read("x", from_s="1"), TypeError, "from_s is a number of seconds, not '1'"),  # type: ignore[arg-type]
        (lambda: crosscut.compare("x", grid="x"), TypeError, "grid is a mapping"),  # type: ignore[arg-type]
        (lambda: crosscut.Scan([1.0], 0, 0.1, stamp_ns=-1), ValueError, "-1 is not from 0"),
        (lambda: crosscut.Flight().process([[1, 1]], pose=(0, 0, np.nan)), ValueError, "a pose is finite"),
        (lambda: crosscut.Flight().process([[1, 1]], pose=(0, 0)), TypeError, "a pose is three numbers"),  # type: ignore[arg-type]
    ],
)
def test_wrong_use_is_an_exception_that_says_what_is_wrong(make, error, text) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(error, match=text):
        make()


def test_every_error_is_one_of_the_package() -> None:
    for error in (crosscut.SettingsError, crosscut.ReadError, crosscut.StageError, crosscut.MissingPackageError):
        assert issubclass(error, crosscut.Error)
    assert not issubclass(crosscut.Error, ValueError)


def test_a_topic_that_is_not_there_is_named(tee: Path) -> None:
    with pytest.raises(crosscut.ReadError, match="there is no topic /lidar"):
        crosscut.read(tee, "/lidar")


def test_a_damaged_recording_gives_its_scans_and_a_warning(tee: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(tee.read_bytes()[: tee.stat().st_size * 2 // 3])
    scans = crosscut.read(cut)
    with pytest.warns(crosscut.LossWarning):
        assert 10 < len(list(scans)) < 141
    assert scans.losses


def test_a_second_loop_reads_a_recording_again(tee: Path) -> None:
    scans = crosscut.read(tee, every=20)
    first, second = ([scan.stamp_ns for scan in scans] for _ in range(2))
    assert first == second and len(first) > 5


def test_an_error_of_the_source_comes_after_the_results_before_it(tee: Path) -> None:
    def source():  # type: ignore[no-untyped-def]
        yield from list(crosscut.read(tee, to_s=4))
        raise OSError("the sensor is gone")

    for workers in (1, 2):
        results = []
        with pytest.raises(OSError, match="the sensor is gone"):
            for result in crosscut.Engine().process_many(source(), workers=workers):
                results.append(result)
        assert len(results) == 41
