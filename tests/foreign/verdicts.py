"""What was compared, with figures, and whether it held: a line each, as it comes."""

from collections import Counter


class Verdicts:
    def __init__(self):
        self._counts = Counter()

    def begin(self, check: str):
        print(f"\n{check}", flush=True)

    def end(self, elapsed_s: float):
        print(f"  ({elapsed_s:.0f} s)", flush=True)

    def that(self, holds: bool, what: str, figures: str):
        """One comparison: whether it held, of what, and the figures that it rests on."""
        self._row("ok" if holds else "FAILED", what, figures)

    def failed(self, what: str, why: str):
        self._row("FAILED", what, why)

    def skipped(self, what: str, why: str):
        self._row("skipped", what, why)

    def note(self, what: str, figures: str):
        """Figures that nothing is held against."""
        self._row("note", what, figures)

    def summary(self) -> str:
        passed, failed, skipped = (self._counts[verdict] for verdict in ("ok", "FAILED", "skipped"))
        return f"\n{passed} passed, {failed} failed" + (f", {skipped} skipped" if skipped else "")

    def all_held(self) -> bool:
        return self._counts["FAILED"] == 0 and self._counts["ok"] > 0

    def _row(self, verdict: str, what: str, figures: str):
        self._counts[verdict] += 1
        print(f"  {verdict:<8} {what:<50} {figures}", flush=True)
