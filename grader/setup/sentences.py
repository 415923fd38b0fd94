"""The two languages of the tools that run before any package is there.

Elsewhere sentences live in `messages/`; reading those needs a package on Python 3.10.
"""

from __future__ import annotations

import os
import sys

from grader.setup.folding import put


def in_language(french: str, english: str) -> str:
    """Return the sentence in the language of the person at the terminal (MRT_LANG)."""
    return english if os.environ.get("MRT_LANG", "fr").startswith("en") else french


def tell(french: str, english: str) -> None:
    """Print a sentence on stderr, in the person's language."""
    put(in_language(french, english), sys.stderr)
