"""Checks what Chromium made of the page of a sweep: check.py FOLDER PAGE CELL FRAME..."""

import csv
import html
import json
import pathlib
import re
import statistics
import sys
from html.parser import HTMLParser


class Tags(HTMLParser):
    """Tags with their attributes, and the text in elements that have an id."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.texts, self.inside = [], {}, []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.tags.append((tag, attributes))
        if tag not in ("meta", "img", "line", "circle", "path", "polyline"):
            self.inside.append((tag, attributes.get("id")))

    def handle_endtag(self, tag):
        while self.inside and self.inside.pop()[0] != tag:
            pass

    def handle_data(self, data):
        for _, name in self.inside:
            if name:
                self.texts[name] = self.texts.get(name, "") + data

    def count(self, tag, **wanted):
        matches = lambda found: all(found.get(k.rstrip("_")) == v for k, v in wanted.items())
        return sum(tag == t and matches(found) for t, found in self.tags)


def pictures(page):
    return sum(t == "img" and a.get("src", "").startswith("data:image/jpeg") for t, a in page.tags)


def check_page(page, rows):
    cells = len({row["cell"] for row in rows})
    assert page.count("button", class_="cell") == cells == 12, page.count("button", class_="cell")
    assert pictures(page) == cells, pictures(page)
    for tag, attributes in page.tags:
        for name in ("src", "href"):
            assert not re.match(r"(https?:)?//", attributes.get(name) or ""), (tag, attributes)
    assert page.count("svg") >= 20, page.count("svg")
    assert page.count("dialog") == 1 and not any("open" in a for t, a in page.tags if t == "dialog")


def check_cell(cell, rows):
    opened = [a for t, a in cell.tags if t == "dialog" and "open" in a]
    assert opened, "the link to a cell opens it"
    assert pictures(cell) == len({row["cell"] for row in rows}) + 1, "its picture is in it too"
    assert cell.texts["cell-title"] == "L = 10r, B = 0.9, join = touch", cell.texts["cell-title"]
    command = html.unescape(cell.texts["cell-command"])
    for part in ("thallus grow ", "--curvature-radius=10.0r", "--bias=0.9", "--join=touch", "--seed=1"):
        assert part in command, (part, command)
    assert "--only L=10r_B=0.9_join=touch" in cell.texts["cell-only"], cell.texts["cell-only"]
    mine = [row for row in rows if row["cell"] == "L=10r_B=0.9_join=touch"]
    for row in mine:
        number = f"{float(row['elements']):,.0f}"
        assert number in cell.texts["cell-numbers"], number


def check_hover(found, rows):
    """The numbers of the fourth cell, while the pointer is on it, where they can be read."""
    told = found["told"]
    assert not told["hidden"] and found["forgotten"], found
    mine = [float(row["elements"]) for row in rows if row["cell"] == "L=5r_B=0.9_join=pack"]
    assert "L = 5r, B = 0.9, join = pack" in told["text"], told
    assert f"{statistics.fmean(mine):,.1f} ± {statistics.stdev(mine):.1f}" in told["text"], told
    left, right = told["sides"]
    assert 0 <= left and right <= found["width"], found


def check_frame(path, rows):
    title = re.search(r"<title>(.*?)</title>", pathlib.Path(path).read_text(), re.S).group(1)
    found = json.loads(html.unescape(title))
    assert found["scrolls"] <= found["width"], found
    assert not found["wide"], found
    assert found["opened"] and found["closed"] and found["loaded"], found
    left, right = found["dialog"]
    assert 0 <= left and right <= found["width"], found
    check_hover(found, rows)
    return found["width"]


folder, page, cell, *frames = sys.argv[1:]
rows = list(csv.DictReader(open(pathlib.Path(folder) / "results.csv")))
check_page(Tags(pathlib.Path(page).read_text()), rows)
check_cell(Tags(pathlib.Path(cell).read_text()), rows)
widths = [check_frame(frame, rows) for frame in frames]
print(f"the page of a sweep: {len(rows)} runs, fits {', '.join(map(str, widths))} pixels")
