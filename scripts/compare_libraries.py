"""Ask neighbouring libraries the same questions about one machine: the table of paper.md.

    pip install . drake mujoco pin-pink daqp pylinkage crocoddyl sympy
    python scripts/compare_libraries.py

Every cell is what a library answered in this run, about a planar four-bar whose answers are known
in closed form, and about Bennett's linkage, whose mobility is 1. Where a library has no function
for a question but what one needs to write it, the lines stand in the folder beside this, and their
result is told as "by own lines". Where no public name of a library has the words of a question
(`compared/known.py`), looked for in all Python files and stubs of its package, that is "none".
What a cell of "simulate" says beside a name is written by hand. A library that is not installed has
no column.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import sys
from collections.abc import Mapping

from compared.known import QUESTIONS, WORDS

#: By the name that it is installed by: the module that asks it.
LIBRARIES = {
    "pmjac_pin": "with_pmjac_pin",
    "pin": "with_pinocchio",
    "mujoco": "with_mujoco",
    "drake": "with_drake",
    "pin-pink": "with_pink",
    "pylinkage": "with_pylinkage",
    "crocoddyl": "with_crocoddyl",
    "sympy": "with_sympy",
}


def main() -> None:
    """Print the table in Markdown."""
    columns: dict[str, Mapping[str, str]] = {}
    for package, module in LIBRARIES.items():
        try:
            version = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            print(f"{package} is not installed", file=sys.stderr)
            continue
        columns[f"{package} {version}"] = importlib.import_module(f"compared.{module}").answers()
    print("| | " + " | ".join(columns) + " |")
    print("|---|" + "---|" * len(columns))
    for key, question in QUESTIONS.items():
        print(f"| {question} | " + " | ".join(column[key] for column in columns.values()) + " |")
    words = "; ".join(
        f"{QUESTIONS[key]}: {words.replace('|', ', ')}" for key, words in WORDS.items()
    )
    print(f"\nnone: no public name has one of these words in it. {words}")


if __name__ == "__main__":
    main()
