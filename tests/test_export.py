"""Exported files, read again by our own readers, are the same machine."""

from __future__ import annotations

import pytest
from exported import FORMATS, MACHINES, PEERS, path_of, round_trip, same
from mechanisms import CATALOGUE, loaded, mostly_slow
from peer_models import peer_model

import pmjac_pin as pj

# What a format cannot say, and which would do.
REFUSED = {
    ("free base that is driven", "sdf"): "no joint that moves any way, as 'root' does; mjcf or",
    ("free base that is passive", "sdf"): "no joint that moves any way, as 'root' does; mjcf or",
    ("free base that is driven", "urdf-plus"): "no motor that turns any way, as 'root' does; mjcf",
    ("ball base that is driven", "urdf-plus"): "no motor that turns any way, as 'root' does; mjcf",
    ("planar base that is driven", "mjcf"): "no planar motor, as 'root' is; extended-urdf or toml",
    ("planar base that is driven", "sdf"): "no planar motor, as 'root' is; extended-urdf or toml",
    ("planar base that is driven", "urdf-plus"): "no planar motor, as 'root' is; extended-urdf",
}
QUICK = ("UniversalLoop from wall", "screws", "names of SDFormat's")


@pytest.mark.parametrize("to", FORMATS)
@pytest.mark.parametrize("name", mostly_slow(CATALOGUE, ("three_rps_ss",)))
def test_the_catalogue_comes_back(name, to, tmp_path):
    exported, again = round_trip(loaded(name), to, tmp_path)
    assert exported.evidence.kind == "tolerance"
    same(loaded(name), again, exported)


@pytest.mark.parametrize("to", FORMATS)
@pytest.mark.parametrize("name", mostly_slow(MACHINES, QUICK))
def test_odd_machines_come_back_or_are_refused(name, to, tmp_path):
    mechanism = MACHINES[name]()
    if (why := REFUSED.get((name, to))) is not None:
        with pytest.raises(pj.ArgumentError, match=why):
            pj.export(mechanism, to=to, file=path_of(tmp_path, to))
        assert not list(tmp_path.iterdir())
        return
    exported, again = round_trip(mechanism, to, tmp_path)
    same(mechanism, again, exported, 1e-10 if name.startswith("random") else 1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("to", FORMATS)
@pytest.mark.parametrize(("path", "given"), PEERS.items())
def test_published_models_come_back(path, given, to, tmp_path):
    mechanism = pj.load(peer_model(path), **given)
    exported, again = round_trip(mechanism, to, tmp_path)
    same(mechanism, again, exported)
