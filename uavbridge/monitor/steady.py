"""A console that lasts: whoever reads it may go away, the mission flies on."""

from __future__ import annotations

import os

from rich.console import Console


class SteadyConsole(Console):
    """Falls silent when the reader of a pipe is gone, where rich would end the process."""

    def on_broken_pipe(self) -> None:
        self.quiet = True
        with open(os.devnull, "wb") as nowhere:  # for those who write there without us
            os.dup2(nowhere.fileno(), self.file.fileno())
