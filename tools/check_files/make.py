"""Grows and exports what the checks open: make.py THALLUS ROCK.obj FOLDER."""

import sys

from common import make

make(*sys.argv[1:])
