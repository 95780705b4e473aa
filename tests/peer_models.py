"""Closed-chain models that other projects publish: data for tests, not part of the repository."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

_BESIDE = Path(__file__).parents[2] / "shared" / "peer_models"
FOLDER = Path(os.environ.get("PMJAC_PEER_MODELS", _BESIDE))


def peer_model(path):
    """Return the path of a model, or skip the test where the folder is missing."""
    if not FOLDER.is_dir():
        pytest.skip(f"the peer models are not at {FOLDER}; PMJAC_PEER_MODELS says where they are")
    return FOLDER / path
