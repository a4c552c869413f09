"""docs/images/debug.gif: a question put to `crosscut debug --view`, with what the prompt and the viewer show. Started by
`lab/make pictures`."""

import sys
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests/foreign"))

from screenshot import Viewer  # noqa: E402
from screenshots import BAR_PX, IMAGES  # noqa: E402

WIDTH, PAGE_PX, PROMPT_PX = 1080, 620, 150
COMMANDS = (
    "seek 107",
    "hold",
    "set spectral.zero_tolerance=1e-8",
    "differs",
    "unset spectral.zero_tolerance",
    "set report.min_returns=3",
    "differs",
)
LINES, LINE_PX, LETTERS = 6, 22, 118
GROUND, TYPED, ANSWERED = (13, 13, 13), (230, 160, 60), (210, 210, 210)
TYPED_MS, ANSWERED_MS, LAST_MS = 900, 2800, 6000
COLOURS = 96


def main(crosscut: str):
    command = [crosscut, "debug", str(ROOT / "recordings/tee.mcap"), "--preset", "paper", "--view"]
    frames, shown_ms, lines = [], [], []
    with Viewer.beside(command, f"{WIDTH}x{PAGE_PX + BAR_PX}") as viewer:
        page = page_of(viewer)
        for command in COMMANDS:
            lines.append((TYPED, f"> {command}"))
            frames.append(frame(page, lines))
            answer = viewer.ask(command)
            lines += [(ANSWERED, cut(line)) for line in answer.splitlines()]
            page = page_of(viewer)
            frames.append(frame(page, lines))
            shown_ms += [TYPED_MS, ANSWERED_MS]
    shown_ms[-1] = LAST_MS
    path = IMAGES / "debug.gif"
    # One palette for all frames, so that what does not change is not stored again.
    sheet = Image.new("RGB", (WIDTH, frames[0].height * len(frames)))
    for at, picture in enumerate(frames):
        sheet.paste(picture, (0, at * picture.height))
    palette = sheet.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=2, dither=Image.Dither.NONE)
    first, *others = (picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in frames)
    first.save(path, save_all=True, append_images=others, duration=shown_ms, loop=0, optimize=True)
    print(f"{path.relative_to(ROOT)}, {path.stat().st_size / 1e3:.0f} KB")


def page_of(viewer: Viewer) -> Image.Image:
    """What the viewer shows, without the bar on top, which has badges of the machine that draws."""
    viewer.settle()
    path = ROOT / "target/screenshots/debug.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    viewer.save(path)
    page = Image.open(path).convert("RGB")
    return page.crop((0, BAR_PX, page.width, page.height))


def frame(page: Image.Image, lines: list[tuple[tuple, str]]) -> Image.Image:
    """The page, and below it the last lines of the prompt."""
    picture = Image.new("RGB", (WIDTH, page.height + PROMPT_PX), GROUND)
    picture.paste(page, (0, 0))
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(16)
    for at, (colour, line) in enumerate(lines[-LINES:]):
        draw.text((14, page.height + 8 + at * LINE_PX), line, fill=colour, font=font)
    return picture


def cut(line: str) -> str:
    """Long lines end with a sign that there is more."""
    return line if len(line) <= LETTERS else line[: LETTERS - 1] + "…"


if __name__ == "__main__":
    main(sys.argv[1])
