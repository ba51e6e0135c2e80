"""What is raised where no core is needed, and the nearest name for messages."""

from __future__ import annotations

import difflib


class ResultsError(Exception):
    """A results folder, or what is asked of it, is wrong; the text says what and what would be right."""


def did_you_mean(name: str, known: list[str]) -> str:
    """'; did you mean "x"?' or nothing."""
    nearest = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    return f'; did you mean "{nearest[0]}"?' if nearest else ""


def shown(value: object, most: int = 80) -> str:
    """The value as it would be written, in one line and shortened, for messages."""
    try:
        text = " ".join(repr(value).split())
        if isinstance(value, str):
            text = f'"{text[1:-1]}"'
    except Exception:  # somebody else's repr
        text = f"<{type(value).__name__}>"
    return text if len(text) <= most else text[: most - 3] + "..."
