"""`SplatRecord`: a record of how a scene's splat was made."""

import dataclasses as dc
import json
from collections.abc import Iterable
from pathlib import Path

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.strict_json import parse_json
from remosplat_drake.reconstruction.report.quality import DistanceQuality


@dc.dataclass(frozen=True)
class SplatRecord:
    """A record of how a scene's splat was made, with its distance errors.

    Attributes:
        scene: Name of the scene.
        family: Family of the scene.
        origin: Origin of the splat, "trained" or "refined"
            (`SplatRecipe.origin`).
        recipe: All settings of the recipe, by name.
        version: Version of this package that made the splat.
        count: Number of splats.
        capture_seconds: Time to render the views and place the initial discs
            [s].
        fit_seconds: Time to train or refine the discs [s].
        quality: Errors of measured distances, by the name of the oracle.
        error: Error text if making the splat failed; empty otherwise.
    """

    scene: str
    family: str
    origin: str
    recipe: dict
    version: str
    count: int = 0
    capture_seconds: float = 0.0
    fit_seconds: float = 0.0
    quality: dict[str, DistanceQuality] = dc.field(default_factory=dict)
    error: str = ""


def write_record(splat_file: Path, record: SplatRecord) -> None:
    """Writes a record beside its splat.

    Raises:
        FileError: The folder cannot be written.
    """
    write_records(splat_file.with_suffix(".json"), [record])


def read_record(splat_file: Path) -> SplatRecord | None:
    """Reads the record beside a splat; None if there is no record.

    Raises:
        FileError: The file exists but does not contain a record.
    """
    return next(iter(read_records(splat_file.with_suffix(".json"))), None)


def write_records(path: Path, records: Iterable[SplatRecord]) -> None:
    """Writes records to a file, each as one line of JSON.

    Raises:
        FileError: The file cannot be written.
    """
    lines = [json.dumps(dc.asdict(r), sort_keys=True) + "\n" for r in records]
    write_atomically(path, "".join(lines))


def read_records(path: Path) -> list[SplatRecord]:
    """Reads the records that `write_records` wrote; empty without a file.

    Raises:
        FileError: The file exists but does not contain records.
    """
    try:
        lines = path.read_text().splitlines()
        return [_from_fields(parse_json(line, path)) for line in lines]
    except FileNotFoundError:
        return []
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise FileError(
            path, f"does not contain records of splats ({error}); remove it"
        ) from error


def _from_fields(fields: dict) -> SplatRecord:
    quality = {
        oracle: DistanceQuality(**numbers)
        for oracle, numbers in fields.pop("quality").items()
    }
    return SplatRecord(quality=quality, **fields)
