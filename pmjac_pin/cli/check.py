"""``pmjac check``."""

from __future__ import annotations

from msgspec.structs import asdict

from pmjac_pin.cli.options import Choice, NameOption
from pmjac_pin.cli.output import Json, Output, Verdict
from pmjac_pin.studies.check.diagnosis_maker import check
from pmjac_pin.words.diagnosis_tables import diagnosis_blocks


def check_command(
    mechanism: NameOption, /, *, choice: Choice = Choice(), json: Json = False
) -> Verdict:
    """Show what a model is made of and what is wrong with it; exit status 1 for an error."""
    parameters, keywords = choice.parameters(), choice.reading.keywords()
    diagnosis = check(mechanism, parameters=parameters, **keywords)
    output: Output = asdict(diagnosis) if json else diagnosis_blocks(diagnosis)
    return Verdict(output, 1 if diagnosis.severity == "error" else 0)
