"""The published figures: docs/results.json, from what `lab/make` left in target/docs, and docs/results.md, from that.

A section whose source is not in target/docs keeps its figures and the commit that they were made at. Started by lab/make."""

import csv
import json
import re
import sys
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).parents[1]
MADE, JSON, PAGE = ROOT / "target/docs", ROOT / "docs/results.json", ROOT / "docs/results.md"
METHODS = ["default", "paper", "clear_width", "threshold", "breakpoint"]
EVALUATE = "--with paper --with default --with clear_width --with threshold --with breakpoint"
OF_EFFECTS = ["paper", "clear_width", "default"]
# The scans that are reported as "a revolution": dense720 has twice as many beams.
OTHER_BEAMS = "dense720"


def percent(share: float | None) -> float | None:
    return None if share is None else round(100 * share, 1)


def evaluation(path: Path) -> dict:
    """Of the JSON of `crosscut compare`: shares in %, by family and configuration."""
    document = json.loads(path.read_text())
    rows = [(family["family"], family["results"]) for family in document["families"]] + [("all", document["all"])]
    measures: dict[str, Callable] = {
        "right": lambda f: percent(f["right"]["share"]),
        "interval": lambda f: [percent(end) for end in f["right"]["interval95"]],
        "right_count": lambda f: percent(f["right_count"]["share"]),
        "returns_right": lambda f: percent(f["labels"]["share"]),
        "missed": lambda f: percent(f["openings"]["missed"]["share"]),
        "false": lambda f: percent(f["openings"]["false"]["share"]),
        "sure": lambda f: percent(f["confidence"]["sure"]["share"]),
        "sure_right": lambda f: percent(f["confidence"]["sure_right"]["share"]),
        "auroc": lambda f: None if f["confidence"]["auroc"] is None else round(f["confidence"]["auroc"], 3),
    }
    of_all = lambda measure: measure not in ("right", "interval")  # noqa: E731
    figures: dict = {"revolutions": document["all"][0]["figures"]["revolutions"]}
    for measure, value in measures.items():
        kept = rows[-1:] if of_all(measure) else rows
        figures[measure] = {
            family: {result["configuration"].split(",")[0]: value(result["figures"]) for result in results} for family, results in kept
        }
    return figures


def mixture(path: Path) -> dict:
    """The last table of the page that the program `robustness` writes, and how many cells the others have."""
    cells = [cell for line in path.read_text().splitlines() if line.startswith("| ") for cell in line.strip("| ").split(" | ")[1:]]
    shares = [int(cell) for cell in cells if cell.isdigit()]
    row = next(line for line in path.read_text().splitlines() if re.fullmatch(r"\|( \d+\.\d \|){6}", line))
    right, sure, sure_right, auroc, missed, false = (float(cell) for cell in row.strip("| ").split(" | "))
    figures = {"right": right, "sure": sure, "sure_right": sure_right, "auroc": round(auroc / 100, 3), "missed": missed}
    return {**figures, "false": false, "cells": len(shares), "weakest_cell": min(shares)}


def corridors(path: Path) -> dict:
    """Of the summary of each report, and of the results beside what a person counted."""
    labels = list(csv.DictReader((path / "labels.csv").open()))
    counted = {page.stem: [json.loads(line)["junctions"] for line in page.open()] for page in path.glob("corridor_*.jsonl")}
    right = [counted[Path(label["file"]).stem][int(label["scan"])] == int(label["walls"]) for label in labels]
    figures: dict = {"labelled": len(right), "labelled_right": sum(right), "revolutions": {}, "differ": {}, "percent": {}}
    for page in sorted(path.glob("corridor_*.html")):
        name, text = page.stem.removeprefix("corridor_"), page.read_text()
        revolutions = int(re.search(r"<p>(\d+) revolutions ", text)[1])
        look = re.search(r"Look at the (\d+) \(", text)
        differ = int(look[1]) if look else 0
        figures["revolutions"][name], figures["differ"][name] = revolutions, differ
        figures["percent"][name] = round(100 * differ / revolutions, 1)
    return figures


def tolerance(path: Path) -> dict:
    """Right answers in all by tolerance: the last table of `paper.md`."""
    lines = [line for line in path.read_text().splitlines() if line.startswith("| ")]
    header = next(line for line in lines if line.startswith("| family"))
    last = [line for line in lines if line.startswith("| all")][-1]
    cells = [[cell.strip(" *") for cell in line.strip("| ").split("|")][1:] for line in (header, last)]
    return {name: int(value) for name, value in zip(*cells)}


def maps(path: Path) -> dict:
    """Of the two tables of the example `maps`: maps by family and drift, then places and counts by family."""
    rows = [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in path.read_text().splitlines() if line.startswith("| ")]
    figures: dict = {"exact": {}, "passages": {}, "loops": {}, "nodes": {}, "f1": {}, "f1_within_8_m": {}, "steady": {}}
    for row in rows:
        match row:
            case [family, drift, "map", exact, f1, nodes, _, _, _, _, passages, loops, *_]:
                figures["exact"].setdefault(family, {})[drift] = exact
                if drift == "5 %":
                    figures["passages"][family], figures["loops"][family] = passages, loops
                    figures["nodes"][family], figures["f1"][family] = float(nodes), round(float(f1), 2)
            case [family, "5 %", "8 m", _, f1, *_]:
                figures["f1_within_8_m"][family] = round(float(f1), 2)
            case [family, "steady", junctions, passages, _, _, count, flicker]:
                shares = {"junctions": junctions, "passages": passages, "count": count, "flicker": flicker}
                figures["steady"][family] = {name: float(share) for name, share in shares.items()}
    return figures


def speed(path: Path) -> dict:
    """Of the table of `lab/run speed`."""
    rows = [line.split() for line in path.read_text().splitlines()[1:]]
    default_ms = {row[0]: float(row[3]) for row in rows}
    ratio = {row[0]: int(row[4]) for row in rows}
    usual = [family for family in ratio if family != OTHER_BEAMS]
    return {
        "default_ms": default_ms,
        "ratio": ratio,
        "least_ms": round(min(default_ms[family] for family in usual), 2),
        "most_ms": round(max(default_ms[family] for family in usual), 2),
        "least_ratio": min(ratio[family] for family in usual),
        "most_ratio": max(ratio[family] for family in usual),
    }


def recording(path: Path) -> dict:
    """Of the lines of the bench `recording`: MB of ten minutes at 10 Hz, and ms of processor time."""
    rows = [{key.strip(): value.strip() for key, value in row.items()} for row in csv.DictReader(path.open())]
    figures: dict = {"mb": {}, "ms": {}}
    for row in rows:
        figures["mb"].setdefault(row["preset"], {})[row["level"]] = round(float(row["MB a 6000"]))
        figures["ms"].setdefault(row["preset"], {})[row["level"]] = round(float(row["recording ms"]), 1)
    return figures


# Name: title, commands, source in target/docs, reader.
SECTIONS: dict[str, tuple[str, list[str], str, Callable]] = {
    "simulated": (
        "Simulated scenes, report seeds",
        ["crosscut simulate --suite all --split report --out target/report", f"crosscut compare target/report {EVALUATE}"],
        "simulated.json",
        evaluation,
    ),
    "places": (
        "Places of another generator",
        ["tests/foreign/run places target/places/report --count 300 --seed 202", f"crosscut compare target/places/report {EVALUATE}"],
        "places.json",
        evaluation,
    ),
    "close": (
        "Close calls let in",
        [
            "tests/foreign/run places target/places/close --count 100 --seed 122 --close",
            "crosscut compare target/places/close --with default",
        ],
        "close.json",
        evaluation,
    ),
    "effects": (
        "What real lidars do",
        [
            "tests/foreign/run places target/places/effects --count 60 --seed 303 --effects",
            "crosscut compare target/places/effects --with paper --with clear_width --with default",
        ],
        "effects.json",
        evaluation,
    ),
    "mixture": (
        "Everything at once",
        ["lab/run robustness target/docs/robustness"],
        "robustness/robustness.md",
        mixture,
    ),
    "corridors": ("Real corridors", ["crosscut report FLIGHT.mcap --out FLIGHT.html"], "corridors", corridors),
    "maps": (
        "Maps of flights",
        ["cargo run --release -p crosscut-flight --example maps -- loops lookalike close chambers pillars 201 10"],
        "maps.md",
        maps,
    ),
    "tolerance": ("The paper's rule by tolerance", ["lab/make paper"], "paper/paper.md", tolerance),
    "speed": ("Speed beside scikit-learn", ["lab/run speed"], "speed.txt", speed),
    "recording": ("Recording", ["cargo bench --workspace --bench recording"], "recording.csv", recording),
}


def main() -> int:
    known = json.loads(JSON.read_text()) if JSON.exists() else {}
    results = {}
    for name, (title, commands, source, read) in SECTIONS.items():
        commit = MADE / f"{name}.commit"
        if commit.exists() and (MADE / source).exists():
            results[name] = {"title": title, "command": commands, "commit": commit.read_text().strip(), **read(MADE / source)}
        elif name in known:
            results[name] = known[name]
            print(f"{name}: kept, of {known[name]['commit']}")
    JSON.write_text(written(results) + "\n")
    PAGE.write_text(page(results))
    return 0


def written(value, indent: str = "") -> str:
    """As JSON, a line for what holds no further object."""
    if not isinstance(value, dict) or not any(isinstance(each, dict) for each in value.values()):
        return json.dumps(value, ensure_ascii=False)
    lines = [f"{indent} {json.dumps(key)}: {written(each, indent + ' ')}" for key, each in value.items()]
    return "{\n" + ",\n".join(lines) + f"\n{indent}}}"


def page(results: dict) -> str:
    """The figures as one page."""
    parts = [
        "# Results\n\n`lab/make` makes this page from [results.json](results.json), which holds every published figure, its command and "
        "the commit\nthat it was made at. What *right* means: [evaluation.md](evaluation.md).\n"
    ]
    for name in ("simulated", "places"):
        section = results[name]
        rows = [
            [family, *(right[method] for method in METHODS), "{} to {}".format(*section["interval"][family]["default"])]
            for family, right in section["right"].items()
        ]
        text = f"Right answers, %, of {section['revolutions']:,} revolutions. The last column is the 95 % interval of `default`."
        parts.append(headed(section, text, table(["family", *METHODS, "interval"], rows)))
    measures = {
        "right_count": "count right",
        "returns_right": "returns right",
        "missed": "openings missed",
        "false": "openings false",
        "sure": "sure",
        "sure_right": "right of the sure",
        "auroc": "AUROC",
    }
    rows = [
        [name, method, *(results[name][measure]["all"][method] for measure in measures)]
        for name in ("simulated", "places", "close")
        for method in results[name]["right"]["all"]
    ]
    text = "In all, %; *sure* are answers with a confidence of 0.9 and above; AUROC: confidence of right against wrong answers."
    parts.append(f"\n## Labels, openings, confidence\n\n{text}\n\n" + table(["scenes", "method", *measures.values()], rows))

    close = results["close"]
    rows = [[kind, right["default"]] for kind, right in close["right"].items()]
    text = "Right answers, %, in places among which niches and ways about as deep as the definition asks for are let in."
    parts.append(headed(close, text, table(["kind", "default"], rows)))
    effects = results["effects"]
    rows = [[effect, *(right[method] for method in OF_EFFECTS)] for effect, right in effects["right"].items()]
    text = f"Right answers, %, of {effects['revolutions'] // (len(rows) - 1)} places for each effect."
    parts.append(headed(effects, text, table(["effect", *OF_EFFECTS], rows)))
    mixed = results["mixture"]
    keys = ["right", "sure", "sure_right", "auroc", "missed", "false"]
    header = ["right", "sure", "right of the sure", "AUROC", "openings missed", "openings false"]
    text = f"3000 places, %. Of the {mixed['cells']} cells of the other tables of this command, the weakest is {mixed['weakest_cell']} %."
    parts.append(headed(mixed, text, table(header, [[mixed[key] for key in keys]])))
    flights = results["corridors"]
    rows = [[name, flights["revolutions"][name], flights["differ"][name], flights["percent"][name]] for name in flights["revolutions"]]
    text = (
        f"Revolutions whose count is not that of most around them. Of {flights['labelled']} that a person labelled, "
        f"{flights['labelled_right']} are counted as labelled."
    )
    parts.append(headed(flights, text, table(["recording", "revolutions", "differ", "%"], rows)))
    flown = results["maps"]
    drifts = list(next(iter(flown["exact"].values())))
    rows = [
        [family, *by_drift.values(), *(flown["steady"][family][figure] for figure in ("junctions", "passages", "count", "flicker"))]
        for family, by_drift in flown["exact"].items()
    ]
    header = ["flights", *drifts, "right in junctions", "in passages", "count right", "flicker"]
    text = "Maps that are exact by the drift of the odometry; of the steady answer, %: [flights.md](flights.md#how-right-maps-are)."
    parts.append(headed(flown, text, table(header, rows)))
    rule = {key: value for key, value in results["tolerance"].items() if key not in ("title", "command", "commit")}
    parts.append(headed(results["tolerance"], "Right answers, % of the development scenes.", table(list(rule), [list(rule.values())])))
    times = results["speed"]
    rows = [[family, ms, times["ratio"][family]] for family, ms in times["default_ms"].items()]
    text = "Processor time of a revolution with `default`, and how many times as much scikit-learn's `SpectralClustering` takes."
    parts.append(headed(times, text, table(["family", "ms", "times"], rows)))
    recorded = results["recording"]
    rows = [[preset, level, mb, recorded["ms"][preset][level]] for preset, of in recorded["mb"].items() for level, mb in of.items()]
    text = "Ten minutes at 10 Hz, 360 beams; the time is that of the recording thread, for a revolution."
    parts.append(headed(recorded, text, table(["preset", "`recording.detail`", "MB", "ms"], rows)))
    return "".join(parts)


def headed(section: dict, text: str, shown: str) -> str:
    if len(section["command"]) == 1:
        return f"\n## {section['title']}\n\n{text}\nAt commit {section['commit']}, by `{section['command'][0]}`\n\n{shown}"
    commands = "\n".join(section["command"])
    return f"\n## {section['title']}\n\n{text}\nAt commit {section['commit']}, by\n\n```\n{commands}\n```\n\n{shown}"


def table(header: list[str], rows: list[list]) -> str:
    cell = lambda value: "-" if value is None else str(value)  # noqa: E731
    line = lambda cells: "| " + " | ".join(map(cell, cells)) + " |\n"  # noqa: E731
    return line(header) + "|" + "---|" * len(header) + "\n" + "".join(map(line, rows))


if __name__ == "__main__":
    sys.exit(main())
