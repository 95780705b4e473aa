"""The machines that libraries are asked about, what is known of them, and how answers are told."""

from __future__ import annotations

import ast
import re
import types
from pathlib import Path

import numpy as np

LENGTHS, CRANK = {"l0": 4.0, "l1": 1.0, "l2": 3.0, "l3": 3.5}, 1.0
#: Of these lengths the crank gets only to where coupler and rocker are in line, at SHORT_ENDS.
SHORT, BEYOND = {"l0": 4.0, "l1": 3.0, "l2": 2.5, "l3": 2.0}, 2.0
SHORT_NEAR = 1.2  # rad, not far from there
SHORT_ENDS = float(np.arccos((4.0**2 + 3.0**2 - (2.5 + 2.0) ** 2) / (2 * 4.0 * 3.0)))
QUESTIONS = {
    "close": "closes the loop at a crank angle",
    "beyond": "at an angle that no pose has",
    "rate": "rocker's rate by the crank's",
    "singular": "where the mode ends",
    "modes": "ways to assemble it",
    "mobility": "Bennett's mobility",
    "simulate": "steps it in time, with contacts",
}
#: What would be in the name of a function that answers it.
WORDS = {
    "close": "loop|closure",
    "rate": "equivalent|passive",
    "singular": "singularit|toggle_?p|dead_?cent",
    "modes": "assembl|homotop|all_?branches",
    "mobility": "mobility",
    "simulate": "simulat|contact",
}


def rocker(crank: float) -> float:
    """Return the rocker's angle: two circles meet, on the side of the model's home."""
    l0, l1, l2, l3 = LENGTHS.values()
    tip = l1 * np.exp(1j * crank) - l0
    along = (abs(tip) ** 2 + l3**2 - l2**2) / (2 * abs(tip) * l3)
    return float(np.angle(tip) - np.arccos(along))


def rocker_rate(crank: float) -> float:
    """Return its derivative: crank and rocker move the coupler's ends alike along it."""
    l0, l1, _, l3 = LENGTHS.values()
    angle = rocker(crank)
    coupler = np.angle(l0 + l3 * np.exp(1j * angle) - l1 * np.exp(1j * crank))
    return float(l1 * np.sin(crank - coupler) / (l3 * np.sin(angle - coupler)))


def error(found: float, known: float) -> str:
    """Say how far off an angle or a rate is."""
    return f"to {max(abs(found - known), 2e-16):.0e}"


def none(module: types.ModuleType, question: str) -> str:
    """Say that no public name of a library has the words of a question, or which ones have."""
    words = re.compile(WORDS[question], re.IGNORECASE)
    names = sorted(name for name in _names(module) if words.search(name))
    return f"? {', '.join(names[:3])}" if names else "none"


def own_lines(module: types.ModuleType, question: str, told: str) -> str:
    """Say what own lines found, unless public names have the words of the question."""
    names = none(module, question)
    return f"by own lines, {told}" if names == "none" else names


def _names(module: types.ModuleType) -> set[str]:
    """Return the public names of a module, and those that all files of its package define."""
    found = set(dir(module))
    for folder in map(Path, getattr(module, "__path__", [])):
        for file in (*folder.rglob("*.py"), *folder.rglob("*.pyi")):
            tree = ast.parse(file.read_text(encoding="utf-8"))
            kinds = (ast.FunctionDef, ast.ClassDef)
            found |= {file.stem} | {node.name for node in ast.walk(tree) if isinstance(node, kinds)}
    return {name for name in found if not name.startswith("_")}
