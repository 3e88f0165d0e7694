"""The parts of the report, in order: name on the command line -> module with TITLE and make(maker) -> Section."""
import importlib

from names import NAMES

PARTS = {name: importlib.import_module(name) for name in NAMES}
