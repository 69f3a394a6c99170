"""Prints the tables of docs/study.md from the folders of its sweeps, or from the tables in docs/study. Standard library only.

    python3 tools/study/tables.py FOLDER [KEEP]

With KEEP the rows of all runs are written there as tables.
"""

import csv
import functools
import math
import random
import statistics
import sys
from pathlib import Path

SHUFFLES = 20_000
FALSE_ALARM = 0.05

# What plain DLA on the plane has, and the order of the table that shows it.
DLA = 1.71
ORDER = ["mass-radius", "gyration", "sandbox", "correlation", "boxes"]

# Measures that one lichen is compared to another by: name, whether it is a length.
MEASURES = [
    ("elements", False),
    ("radius_of_gyration", True),
    ("effective_radius", True),
    ("density", False),
    ("circularity", False),
    ("branch_width", True),
    ("lobe_width", True),
    ("tips", False),
    ("roughness", False),
    ("growth_exponent", False),
    ("dimension_mass_radius", False),
    ("dimension_gyration", False),
    ("dimension_sandbox", False),
    ("dimension_correlation", False),
    ("dimension_outline", False),
    ("surface_dimension_mass_radius", False),
    ("surface_dimension_gyration", False),
    ("surface_dimension_sandbox", False),
    ("surface_dimension_correlation", False),
]


def rows(place):
    """Of a table, of the one in the folder of a sweep, or of those in folders of several."""
    if not place.is_dir():
        tables = [place.with_suffix(".csv")]
    elif (place / "results.csv").is_file():
        tables = [place / "results.csv"]
    else:
        tables = sorted(place.glob("*/results.csv"), reverse=True)
    tables = [table for table in tables if table.is_file()]
    found = []
    for table in tables:
        with open(table, newline="") as file:
            found += csv.DictReader(file)
    return found


def keep(folder, into):
    """Writes the rows of each sweep to a table, but for the seconds that they took and the folder of the mesh."""
    for name in ["grid", "copy", "scan", "steps", "steps-6000", "law", "presets"]:
        data = rows(folder / name)
        if not data:
            continue
        fields = [field for field in data[0] if field != "seconds_grow"]
        for row in data:
            row["mesh"] = Path(row["mesh"]).name
        with open(into / f"{name}.csv", "w", newline="") as file:
            table = csv.DictWriter(file, fields, extrasaction="ignore", lineterminator="\n")
            table.writeheader()
            table.writerows(data)


def value(row, name, is_length=False):
    """A measure, lengths in element radii; NaN where the lichen has none."""
    text = row[name]
    x = float(text) if text else math.nan
    return x / float(row["radius"]) if is_length else x


def numbers(some, name, is_length=False):
    found = [value(row, name, is_length) for row in some]
    return [x for x in found if not math.isnan(x)]


def ranks(xs):
    """Ranks from 0, ties sharing their mean."""
    ordered = sorted(xs)
    return [(ordered.index(x) + len(ordered) - 1 - ordered[::-1].index(x)) / 2 for x in xs]


def correlation(xs, ys):
    mx, my = statistics.fmean(xs), statistics.fmean(ys)
    xy = sum((x - mx) * (y - my) for x, y in zip(xs, ys))
    xx, yy = sum((x - mx) ** 2 for x in xs), sum((y - my) ** 2 for y in ys)
    return xy / math.sqrt(xx * yy) if xx * yy > 0 else 0.0


def trend(data, across, within, name, is_length):
    """Mean of Spearman's rank correlation of a measure with one axis, over the values of the other,
    and the share of shufflings within these values that come as far in either direction."""
    strata = []
    for fixed in sorted({row[within] for row in data}):
        some = [row for row in data if row[within] == fixed]
        pairs = [(float(row[across].rstrip("r")), value(row, name, is_length)) for row in some]
        pairs = [p for p in pairs if not math.isnan(p[1])]
        if len({x for x, _ in pairs}) > 1:
            strata.append([ranks(side) for side in zip(*pairs)])
    found = statistics.fmean(correlation(x, y) for x, y in strata)
    shuffle = random.Random(1)
    as_far = 0
    for _ in range(SHUFFLES):
        for x, _ in strata:
            shuffle.shuffle(x)
        as_far += abs(statistics.fmean(correlation(x, y) for x, y in strata)) >= abs(found)
    return found, (as_far + 1) / (SHUFFLES + 1)


def chance(p):
    """As the tables have it: shuffling cannot tell smaller ones."""
    least = 2 / SHUFFLES
    return f"{p:.2g}" if p > least else f"< {least:.0e}".replace("e-0", "e-")


# What decides a lichen, besides where it stops.
RECIPE = "seed version mesh_hash radius curvature_radius bias gain min_stick at launch kill join law steps boundary".split()


def check_repeats(folder):
    """Ends where one recipe has made two lichens: then some are of another build."""
    made = {}
    for row in rows(folder / "grid") + rows(folder / "presets"):
        recipe = tuple(row[name] for name in [*RECIPE, "stop_reach"])
        earlier = made.setdefault(recipe, row)
        if earlier["elements"] != row["elements"]:
            sys.exit(f"{earlier['cell']} and {row['cell']} differ, seed {row['seed']}: grown by different builds")


def grid_table(data, name, is_length, digits):
    """Means with their standard errors; of dimensions also the mean of the errors that each fit states."""
    across = sorted({row["axis_L"] for row in data}, key=lambda L: float(L[:-1]))
    down = sorted({row["axis_B"] for row in data}, key=float)
    print(f"\n| {name}{' / r' if is_length else ''} | " + " | ".join(f"L = {L}" for L in across) + " |")
    print("| --- |" + " --- |" * len(across))
    for B in down:
        cells = []
        for L in across:
            some = numbers([r for r in data if (r["axis_L"], r["axis_B"]) == (L, B)], name, is_length)
            if not some:
                cells.append("-")
                continue
            spread = statistics.stdev(some) / math.sqrt(len(some)) if len(some) > 1 else math.nan
            cell = f"{statistics.fmean(some):.{digits}f} ± {spread:.{digits}f}"
            stated = f"{name}_error"
            if stated in data[0]:
                errors = numbers([r for r in data if (r["axis_L"], r["axis_B"]) == (L, B)], stated)
                cell += f" ({statistics.fmean(errors):.2f})"
            cells.append(cell)
        print(f"| B = {B} | " + " | ".join(cells) + " |")


def grid(folder):
    data = rows(folder)
    print("## Figure 9-4 on the rock\n")
    print("| measure | against | rank correlation | p |")
    print("| --- | --- | --- | --- |")
    for name, is_length, axis, other in [
        ("lobe_width", True, "axis_L", "axis_B"),
        ("branch_width", True, "axis_L", "axis_B"),
        ("roughness", False, "axis_B", "axis_L"),
        ("dimension_outline", False, "axis_B", "axis_L"),
        ("dimension_mass_radius", False, "axis_B", "axis_L"),
        ("dimension_sandbox", False, "axis_B", "axis_L"),
        ("dimension_correlation", False, "axis_B", "axis_L"),
        ("circularity", False, "axis_B", "axis_L"),
        ("branch_width", True, "axis_B", "axis_L"),
    ]:
        found, p = trend(data, axis, other, name, is_length)
        print(f"| {name} | {axis[5:]} | {found:+.2f} | {chance(p)} |")
    shown = [
        ("lobe_width", True, 1),
        ("branch_width", True, 1),
        ("roughness", False, 3),
        ("dimension_outline", False, 3),
        ("dimension_mass_radius", False, 3),
        ("dimension_sandbox", False, 3),
        ("circularity", False, 3),
        ("elements", False, 0),
    ]
    for name, is_length, digits in shown:
        grid_table(data, name, is_length, digits)
    tell_of_none(data, [name for name, _, _ in shown])


def difference(a, b):
    """Of means, and the share of relabellings that come as far (Fisher's permutation test)."""
    found = statistics.fmean(b) - statistics.fmean(a)
    both, n = a + b, len(a)
    shuffle = random.Random(1)
    as_far = 0
    for _ in range(SHUFFLES):
        shuffle.shuffle(both)
        as_far += abs(statistics.fmean(both[n:]) - statistics.fmean(both[:n])) >= abs(found) * (1 - 1e-12)
    return found, (as_far + 1) / (SHUFFLES + 1)


def beyond(edge, shift, freedom):
    """Chance that Student's t of so many degrees of freedom is beyond the edge on either side, where its numerator is
    shifted by so many standard errors: the normal integral over all sizes that the estimated error may have."""
    normal = statistics.NormalDist(shift)
    log_scale = math.log(2) + freedom / 2 * math.log(freedom / 2) - math.lgamma(freedom / 2)
    reach = 8 / math.sqrt(2 * freedom)
    least, steps = max(0.0, 1 - reach), 1000
    width = (1 + reach - least) / steps
    chance = 0.0
    for step in range(steps):
        size = least + (step + 0.5) * width
        density = math.exp(log_scale + (freedom - 1) * math.log(size) - freedom * size**2 / 2)
        chance += width * density * (1 - normal.cdf(edge * size) + normal.cdf(-edge * size))
    return chance


def where(rises, aim):
    """Where a function that rises comes to a value, between 0 and 50."""
    low, high = 0.0, 50.0
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if rises(middle) < aim else (low, middle)
    return high


@functools.cache
def standard_errors(freedom):
    """How many of them a difference has to be for a t test to see it nine times in ten, at the false alarm of one in
    these measures: by noncentral t, as a permutation test of means goes over into that test."""
    edge = where(lambda x: -beyond(x, 0, freedom), -FALSE_ALARM / len(MEASURES))
    return where(lambda shift: beyond(edge, shift, freedom), 0.9)


def seen(a, b):
    """The difference that is seen nine times in ten."""
    error = math.sqrt(statistics.variance(a) / len(a) + statistics.variance(b) / len(b))
    return standard_errors(len(a) + len(b) - 2) * error


def tell_of_none(data, names):
    """Names the measures that some lichens have no answer for: tables are of those that have one."""
    missing = {name: len(data) - len(numbers(data, name)) for name in names}
    some = [f"{name} {count}" for name, count in missing.items() if count]
    if some:
        print(f"\nOf {len(data)} lichens without an answer: " + ", ".join(some) + ".")


def compare(folder, axis, title):
    data = rows(folder)
    sides = list(dict.fromkeys(row[axis] for row in data))
    strata = sorted({row["axis_B"] for row in data}, key=float)
    for B in strata:
        some = [row for row in data if row["axis_B"] == B]
        print(f"\n## {title}, B = {B}\n")
        print(f"| measure | {sides[0]} | {sides[1]} | difference | p | seen 9 times in 10 from |")
        print("| --- | --- | --- | --- | --- | --- |")
        for name, is_length in MEASURES:
            a, b = (numbers([r for r in some if r[axis] == side], name, is_length) for side in sides)
            if min(len(a), len(b)) < 3 or statistics.variance(a + b) == 0:
                continue
            mean, (found, p) = statistics.fmean(a), difference(a, b)
            share = lambda x: f"{100 * x / abs(mean):+.1f} %"
            print(
                f"| {name}{' / r' if is_length else ''} | {mean:.4g} | {statistics.fmean(b):.4g} "
                f"| {share(found)} | {chance(p)} | {share(seen(a, b)).lstrip('+')} |"
            )
        print(f"\nA p below {FALSE_ALARM / len(MEASURES):.4f} would be a difference.")
        tell_of_none(some, [name for name, _ in MEASURES])


def presets(folder):
    data = rows(folder)
    print("\n## The presets\n")
    print("| preset | L | B | elements | branch width / r | lobe width / r | tips | roughness | dimension of the outline | dimension (mass-radius) | circularity |")
    print("|" + " --- |" * 11)
    for name in dict.fromkeys(row["axis_preset"] for row in data):
        some = [row for row in data if row["axis_preset"] == name]
        mean = lambda m, length=False: statistics.fmean(numbers(some, m, length) or [math.nan])
        length = value(some[0], "curvature_radius", True)
        print(
            f"| `{name}` | {length:.0f}r | {float(some[0]['bias']):g} | {mean('elements'):.0f} "
            f"| {mean('branch_width', True):.1f} | {mean('lobe_width', True):.1f} | {mean('tips'):.0f} | {mean('roughness'):.3f} "
            f"| {mean('dimension_outline'):.2f} | {mean('dimension_mass_radius'):.2f} | {mean('circularity'):.2f} |"
        )
    tell_of_none(data, [name for name, _ in MEASURES])


def surfaces(file):
    data = rows(file)
    names = list(dict.fromkeys(row["surface"] for row in data))
    print("\n## Plain DLA over surfaces\n")
    print("| method | way | " + " | ".join(names) + " |")
    print("|" + " --- |" * (2 + len(names)))
    for method, way in sorted({(row["method"], row["way"]) for row in data}, key=lambda m: (m[1], ORDER.index(m[0]))):
        cells = []
        for name in names:
            some = [r for r in data if (r["surface"], r["method"], r["way"]) == (name, method, way)]
            found, errors = numbers(some, "dimension"), numbers(some, "error")
            spread = statistics.stdev(found) / math.sqrt(len(found))
            truths = sum(abs(d - DLA) <= error for d, error in zip(found, errors))
            cells.append(f"{statistics.fmean(found):.3f} ± {spread:.3f} ({statistics.fmean(errors):.3f}, {truths})")
        way = "along the surface" if way == "surface" else "through space"
        print(f"| {method} | {way} | " + " | ".join(cells) + " |")


def main():
    out = Path(sys.argv[1])
    check_repeats(out)
    if len(sys.argv) > 2:
        keep(out, Path(sys.argv[2]))
    grid(out / "grid")
    surfaces(out / "dimensions.csv")
    compare(out / "copy", "axis_steps", "Far steps on a coarser copy against exact ones, boulder")
    compare(out / "scan", "axis_steps", "The same on a scan")
    compare(out / "steps", "axis_steps", "Large steps against small ones, rock")
    compare(out / "steps-6000", "axis_steps", "Large steps against small ones, 6,000 elements")
    compare(out / "law", "axis_law", "The two laws of motion, rock")
    presets(out / "presets")


main()
