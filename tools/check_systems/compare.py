"""Whether two builds of the program write the same bytes: compare.py MESHES PROGRAM OTHER [--rounded].

MESHES is the repository's folder of that name. A program may be a script that starts one built for another system
in an emulator. Both are called by the same words, each in a copy of the meshes. Ends with 1 where what is written
differs, or a command fails. With --rounded, for another kind of processor, pictures may differ by what its vectors
round: how much is told, and a share of pixels up to MOST, each by up to PALEST of 255, is let pass; the colours of a
GIF go by all of its pixels. Left out are times and what threads shared, and levels of detail and decimated skins: a
C++ library makes these, which compilers round differently too.
"""

import csv
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageSequence

COMMANDS = """
grow meshes/rock.obj -o rock
grow meshes/boulder.glb -o boulder --elements 20000 --preview 0
grow meshes/branch.glb -o branch --elements 5000 --preset fruticose --at random --mask opaque
grow meshes/slab.stl -o slab --colonies 5 --cover 0.2 --slope 60 --preview 0
grow meshes/plane.obj -o plane --elements 5000 --law brownian --preview 0
grow --resume slab --cover 0.25 --threads 2 --preview 0
export rock -o rock.ply
export rock -o rock.csv
export rock -o rock.parquet
export rock -o rock.usda
export rock -o rock.glb
skin branch -o skin.glb --apothecia 3r
skin branch -o skin.obj --areoles 6r
skin rock -o skin.ply
animate branch -o film.usda --frames 3
animate branch -o film.glb --frames 3 --what curves
animate branch -o film.gif --frames 3 --what picture --width 160
bake boulder -o maps --size 256
analyze branch --plots plots
sweep meshes/rock.obj -o sweep --elements 300 --axis bias=0.1,0.5 --seeds 2 --size 160x120
render boulder -o picture.png --size 320x240
"""

# Of a sweep the table says in text what the page and the other table do.
TIMES = ("report.json", "report.html", "results.parquet")
PICTURES = (".png", ".gif")
MOST = 0.005
PALEST = 32


def run(program: str, folder: Path) -> bool:
    def succeeds(command: str) -> bool:
        ran = subprocess.run([program, *command.split()], cwd=folder, capture_output=True, text=True)
        if ran.returncode != 0:
            print(f"{program} {command}: ended with {ran.returncode}: {ran.stderr.strip()}")
        return ran.returncode == 0

    return all([succeeds(command) for command in COMMANDS.strip().splitlines()])


def files(folder: Path) -> set[Path]:
    return {path.relative_to(folder) for path in folder.rglob("*") if path.is_file()}


def frames(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        return np.stack([np.asarray(frame.convert("RGBA"), int) for frame in ImageSequence.Iterator(image)])


def rows(path: Path) -> list[dict]:
    """A sweep's table, without the times."""
    with path.open(newline="") as table:
        return [{key: row[key] for key in row if key != "seconds_grow"} for row in csv.DictReader(table)]


def are_alike(one: Path, other: Path, rounded: bool) -> bool:
    """Two files of one name, that are not for times."""
    if one.name == "results.csv":
        return rows(one) == rows(other)
    if one.read_bytes() == other.read_bytes():
        return True
    if not rounded or one.suffix not in PICTURES:
        return False
    drawn = [frames(path) for path in (one, other)]
    if drawn[0].shape != drawn[1].shape:
        return False
    apart = abs(drawn[0] - drawn[1]).max(axis=-1)
    share = (apart > 0).mean()
    print(f"{one.name}: {share:.3%} of the pixels differ, by {apart.max()} of 255 at most")
    return apart.max() <= PALEST and (share <= MOST or one.suffix == ".gif")


def main(meshes: str, *words: str) -> bool:
    rounded = words[-1] == "--rounded"
    programs = words[:-1] if rounded else words
    with tempfile.TemporaryDirectory() as work:
        folders = [Path(work, name) for name in ("one", "other")]
        for folder in folders:
            shutil.copytree(meshes, folder / "meshes")
        done = [run(program, folder) for program, folder in zip(programs, folders, strict=True)]
        one, other = map(files, folders)
        differing = [f"{name}: only one has it" for name in sorted(one ^ other)]
        for name in sorted(name for name in one & other if name.name not in TIMES):
            if not are_alike(*(folder / name for folder in folders), rounded):
                differing.append(f"{name}: differs")
        print(*differing, f"{len(one & other)} files of both", sep="\n")
        return all(done) and not differing


if __name__ == "__main__":
    sys.exit(not main(*sys.argv[1:]))
