"""The history of a run: sums over the bodies against time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from matpoint.errors import did_you_mean
from matpoint.fields import Floats

if TYPE_CHECKING:
    import pandas


class History(Mapping[str, Floats]):
    """Sums over the bodies at the times of the history: the columns of history.csv as arrays of shape (rows,)."""

    def __init__(self, columns: dict[str, Floats], units: dict[str, str]) -> None:
        self._columns = columns
        self.units = units
        """Unit of each column."""

    def __getitem__(self, name: str) -> Floats:
        if name not in self._columns:
            raise KeyError(f'the history has no column "{name}"{did_you_mean(str(name), list(self._columns))}')
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return f"<history: {len(next(iter(self._columns.values())))} rows, {len(self)} columns>"

    def to_pandas(self) -> pandas.DataFrame:
        """A DataFrame with the times as index. Raises ImportError without the package pandas."""
        import pandas

        return pandas.DataFrame(dict(self._columns)).set_index("time")

    def _repr_png_(self) -> bytes:
        from matpoint import plot

        return plot.png_of(plot.energies(self))
