"""For scripts that need more than a run of the program does."""
import importlib.util
import os
import subprocess


def modules(*names):
    """Installs the packages of scripts/install --tools where one of these modules is missing; it says why where it cannot."""
    if any(importlib.util.find_spec(name) is None for name in names):
        subprocess.run([os.path.join(os.path.dirname(os.path.abspath(__file__)), 'install'), '--tools'], check=False)
        importlib.invalidate_caches()
