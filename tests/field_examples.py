"""Paths and examples of the fields of a file."""

from strainwave.files.fields.kinds import Either, Items
from strainwave.files.fields.rows import Fields, Group, rows_of


def examples(cls, before=""):
    """Path and example of every field that has one, items of lists as "lines[].order"."""
    for key, row in rows_of(cls).items():
        path, kind = f"{before}{key}", row.kind
        if row.example:
            yield path, row.example
        if isinstance(kind, Items):
            path, kind = f"{path}[]", kind.item
        kind = kind.group if isinstance(kind, Either) else kind
        for one in getattr(kind, "ways", (kind,)):
            if isinstance(one, Fields) and issubclass(one.cls, Group):
                yield from examples(one.cls, f"{path}.")
