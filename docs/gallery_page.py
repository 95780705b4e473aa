"""A page of the gallery: one mechanism, every number computed by the library when it is made."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import gallery_pictures

import pmjac_pin as pj
from pmjac_pin.pictures.figures import save_figure, save_pages
from pmjac_pin.pictures.mode_sheet import plot_modes
from pmjac_pin.words.blocks import Table
from pmjac_pin.words.markdown import markdown_table
from pmjac_pin.words.pages import blocks_of

MATRICES = {
    "K": "K = ∂η/∂θ: the loops by the motors",
    "K_star": "K\\* = ∂η/∂φ: the loops by the passive joints",
    "Jv_star": "J_v\\*: the tool's velocity by the passive joints",
    "Jw_star": "J_ω\\*: its angular velocity by them",
    "J_eq": "J_eq = J − J\\* K\\*⁻¹ K: the tool by the motors alone",
}
WIDE = 7  # columns: more of them are folded away
SEED = 0
#: Working modes of these take longer than all else of their pages.
LONG_WORKING_MODES = ("agile_eye", "delta", "ur5")
#: Of whom a slice is drawn, too: of the others it takes longer (`pmjac workspace`, `pmjac locus`).
WORKSPACES = ("five_bar", "planar_3rpr", "serial_2r")
LOCI = ("ankle", "five_bar", "humanoid_ankle", "planar_3rpr", "planar_3rrr")
CELLS = 31  # of a slice, along each side
DRAWN_MODES = 16  # more are not drawn here
DOTS = 90  # per inch


def write_page(name: str, pages: Path, scenes: Path, references: tuple[str, ...]) -> str:
    """Write one mechanism's page, pictures and scene; return its description."""
    mechanism = pj.load(name)
    pj.static_scene(mechanism.home, **_quantities(mechanism)).save(scenes / f"{name}.html")
    save_figure(gallery_pictures.portrait(mechanism.home), pages / f"{name}_small.png", DOTS)
    parts = (
        _head(mechanism),
        _picture(mechanism, pages),
        _mobility(mechanism),
        _matrices(mechanism),
        _assembly_modes(mechanism, pages),
        _working_modes(mechanism),
        _map(mechanism, pages),
        _slices(mechanism, pages),
        _references(references),
    )
    text = "\n".join(line for part in parts for line in part)
    (pages / f"{name}.md").write_text(text, encoding="utf-8")
    return mechanism.spec.description


def _quantities(mechanism: pj.Mechanism) -> dict[str, bool]:
    rows = mechanism.spec.tool.rows or ("vx",)
    linear = any(row.startswith("v") for row in rows)
    return {"linear": linear, "angular": not linear}


def _head(mechanism: pj.Mechanism) -> Iterator[str]:
    yield f"# {mechanism.name}\n"
    yield f"{mechanism.spec.description}.\n"
    yield f'`pj.load("{mechanism.name}")`, `pmjac view {mechanism.name}`\n'
    yield (
        f'<iframe src="scenes/{mechanism.name}.html" title="{mechanism.name} in three dimensions" '
        'loading="lazy" style="width: 100%; height: 420px; border: 1px solid #d5d9de"></iframe>\n'
    )
    yield "*The closed machine at home with its ellipsoid: drag to turn, wheel to zoom.*\n"


def _picture(mechanism: pj.Mechanism, pages: Path) -> Iterator[str]:
    quantity = "linear" if _quantities(mechanism)["linear"] else "angular"
    file = f"{mechanism.name}.png"
    save_figure(pj.plot(mechanism.home, quantity), pages / file, DOTS)
    yield f"![{mechanism.name} beside the {quantity} velocities of its tool]({file})\n"


def _mobility(mechanism: pj.Mechanism) -> Iterator[str]:
    found = pj.check(mechanism)
    mobility = found.mobility
    rows = {
        "degrees of freedom of the cut tree": mobility.freedoms,
        "loop equations": mobility.rows,
        "of them independent": mobility.rank,
        "**mobility**, by rank": mobility.mobility,
        "Grübler–Kutzbach, in space": mobility.gruebler,
        "each loop counted in its joints' own group": mobility.gruebler_in_groups,
        "motors": len(mechanism.actuated),
        "idle passive motions": found.actuation.idle if found.actuation else None,
    }
    yield "## Mobility\n"
    yield "| | |\n|---|---:|"
    for words, count in rows.items():
        if count is not None:
            yield f"| {words} | {count} |"
    yield "\n" + _evidence(found.evidence)


def _matrices(mechanism: pj.Mechanism) -> Iterator[str]:
    home = mechanism.home
    jacobian, singularity = home.jacobian(), home.singularity()
    yield "## Matrices at home\n"
    for name, words in MATRICES.items():
        table = jacobian.table(name)
        if not table.rows or not table.columns:
            continue
        size = f"{len(table.rows)} × {len(table.columns)}"
        folded = len(table.columns) > WIDE
        yield (
            f"<details><summary>{words.replace(chr(92), '')}, {size}</summary>\n"
            if folded
            else f"{words}, {size}:\n"
        )
        yield table.markdown()
        yield "\n</details>\n" if folded else ""
    if mechanism.spec.loops:
        yield (
            f"The pose is {singularity.kind}; the smallest singular value of the dimensionless "
            f"K\\* is {singularity.smallest:.3g}, relative.\n"
        )


def _tables(value: object) -> Iterator[str]:
    for block in blocks_of(value):
        if isinstance(block, Table):
            yield markdown_table(block) + "\n"


def _assembly_modes(mechanism: pj.Mechanism, pages: Path) -> Iterator[str]:
    modes = pj.assembly_modes(mechanism, mechanism.home.actuated, rng=SEED)
    yield "## Assembly modes\n"
    ways = _counted(len(modes), "way")
    yield f"At the motors of home there {ways} to put it together within its joints' limits.\n"
    yield from _tables(modes)
    yield _evidence(modes.evidence)
    if 1 < len(modes) <= DRAWN_MODES:
        for sheet in save_pages(plot_modes(modes), pages / f"{mechanism.name}_modes.png", DOTS):
            yield f"![The assembly modes]({sheet.name})\n"


def _working_modes(mechanism: pj.Mechanism) -> Iterator[str]:
    yield "## Working modes\n"
    if mechanism.name in LONG_WORKING_MODES:
        yield "They take longer than all else here and are left out; `pj.working_modes` has them.\n"
        return
    rows = mechanism.spec.tool.rows
    task = pj.Task.of(list(rows)) if rows else None
    modes = pj.working_modes(mechanism, mechanism.home.tool_pose(), task=task, rng=SEED)
    choices = _counted(len(modes), "choice")
    yield f"For the tool as it is at home there {choices} of motor values within limits.\n"
    yield from _tables(modes)
    yield _evidence(modes.evidence)


def _map(mechanism: pj.Mechanism, pages: Path) -> Iterator[str]:
    file = f"{mechanism.name}_map.png"
    save_figure(gallery_pictures.draw_map(mechanism), pages / file, DOTS)
    motors = " and ".join(mechanism.actuated[:2])
    held = " while the others stay" if len(mechanism.actuated) > 2 else ""
    yield "## Map\n"
    yield f"![What {motors} reach]({file})\n"
    yield (
        f"*What {motors} reach{held}, from home (the ring) on its assembly mode, and how near to a "
        "singularity.*\n"
    )


def _slices(mechanism: pj.Mechanism, pages: Path) -> Iterator[str]:
    name = mechanism.name
    if name in WORKSPACES:
        found = pj.workspace(mechanism, ("x", "y"), cells=CELLS, measure="dexterity")
        save_figure(pj.plot_workspace(found), pages / f"{name}_workspace.png", DOTS)
        yield "## Workspace\n"
        yield f"![What the tool reaches in x and y]({name}_workspace.png)\n"
        yield f"{found.area:.4g} m² of the plane, on one working mode. {_evidence(found.evidence)}"
    if name in LOCI:
        locus = pj.singularity_locus(mechanism, mechanism.actuated[:2], cells=CELLS)
        save_figure(pj.plot_locus(locus), pages / f"{name}_locus.png", DOTS)
        yield "## Singularity locus\n"
        yield f"![Where it is singular]({name}_locus.png)\n"
        yield _evidence(locus.evidence)


def _references(references: tuple[str, ...]) -> Iterator[str]:
    yield "## References\n"
    for reference in references or ("Made for this catalogue.",):
        yield f"- {reference}"
    yield ""


def _evidence(evidence: pj.Evidence) -> str:
    words = str(evidence).replace("*", "\\*").replace("[", "\\[")
    return f"Rests on {words}.\n"


def _counted(count: int, thing: str) -> str:
    return f"is {count} {thing}" if count == 1 else f"are {count} {thing}s"
