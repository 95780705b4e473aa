"""``pmjac modes``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, TypeAlias

from cyclopts import Parameter

from pmjac_pin.cli.options import At, Choice, NameOption, output_option, parsed_values
from pmjac_pin.cli.output import Json, Output
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.pictures.figures import check_figure_file, save_pages
from pmjac_pin.pictures.mode_sheet import modes_figures
from pmjac_pin.studies.homotopy.parameter_homotopy import parameter_homotopy
from pmjac_pin.studies.modes.find import assembly_modes
from pmjac_pin.words.blocks import Block, Verbatim
from pmjac_pin.words.modes_report import ModesReport, make_modes_report
from pmjac_pin.words.modes_tables import modes_blocks

Given: TypeAlias = Sequence[float] | Mapping[str, float]


@Parameter(name="*")
@dataclass(frozen=True)
class Search:
    """How long to search, and what to make of what is found."""

    no_limits: Annotated[bool, Parameter(help="Let joints go beyond their limits.")] = False
    seed: Annotated[int, Parameter(help="Of the random starts (default: 0).")] = 0
    unseen: Annotated[
        float, Parameter(help="Largest share of starts that may lead elsewhere (default: 0.002).")
    ] = 2e-3
    confidence: Annotated[float, Parameter(help="Of that bound (default: 0.99).")] = 0.99
    most_starts: Annotated[
        int, Parameter(help="Starts after which to give up on it (default: 200000).")
    ] = 200_000
    no_proof: Annotated[bool, Parameter(help="Leave it at the search's statistics.")] = False
    homotopy: Annotated[
        bool,
        Parameter(
            help="Count all complex solutions, too: seconds, or longer with many passive joints."
        ),
    ] = False
    operation_modes: Annotated[
        bool, Parameter(help="And tell which of them hang together: longer.")
    ] = False

    def report(self, mechanism: Mechanism, values: Given) -> ModesReport:
        """Return the closed poses at these motor values, and what is known of them."""
        homotopy = None
        limits = mechanism.spec.enforce_limits and not self.no_limits
        if self.homotopy or self.operation_modes:
            homotopy = parameter_homotopy(mechanism, rng=self.seed)
        modes = assembly_modes(
            mechanism,
            values,
            rng=self.seed,
            limits=limits,
            unseen=self.unseen,
            confidence=self.confidence,
            most_starts=self.most_starts,
            proof=not self.no_proof,
            homotopy=homotopy,
        )
        together = homotopy if self.operation_modes else None
        return make_modes_report(
            mechanism,
            values,
            modes,
            limits=limits,
            solutions=None if homotopy is None else homotopy.at(values),
            operation_modes=None if together is None else together.operation_modes(rng=self.seed),
        )


def modes_command(
    mechanism: NameOption,
    /,
    *,
    at: At = None,
    from_: Annotated[
        str | None,
        Parameter(name="--from", help="In place of --at: a pose with these motor values."),
    ] = None,
    choice: Choice = Choice(),
    search: Search = Search(),
    json: Json = False,
    output: Annotated[
        str | None, output_option("Draw the modes, too: a .png, .pdf or .svg.")
    ] = None,
) -> Output:
    """Find all closed poses at these motor values, and say what is known of their number."""
    if output is not None:
        check_figure_file(output)  # before what may take minutes
    loaded = choice.load(mechanism)
    values = _motor_values(loaded, at, from_)
    report = search.report(loaded, values)
    drawn: list[Block] = []
    if output is not None:
        drawn = [Verbatim(str(path)) for path in save_pages(modes_figures(report), output)]
    return report.told() if json else [*modes_blocks(report), *drawn]


def _motor_values(mechanism: Mechanism, at: str | None, pose: str | None) -> Given:
    if at is None:
        values: list[float] = mechanism.pose("home" if pose is None else pose).actuated.tolist()
        return values
    if pose is not None:
        raise ArgumentError("--at and --from both give motor values; take one of them")
    return parsed_values("--at", at)
