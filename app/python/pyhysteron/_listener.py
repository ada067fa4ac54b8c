"""Lines and progress of work in the native module, for people."""

from __future__ import annotations

from typing import Any

__all__ = ["Listener"]


class Listener:
    """Prints the lines of a verb, and draws its progress with tqdm where that is installed."""

    def __init__(self, verbose: bool, progress: bool) -> None:
        self._is_verbose = verbose
        self._bars: dict[int, Any] = {}
        self._tqdm: Any = None
        if progress:
            try:
                from tqdm.auto import tqdm

                self._tqdm = tqdm
            except ImportError:
                pass

    def line(self, text: str) -> None:
        """A line of the result."""
        if self._is_verbose:
            print(text)

    def progress(
        self, number: int, of: str, length: int, position: int, message: str, is_finished: bool
    ) -> None:
        """How far part `number` of the work is: `position` of `length`, which is 0 where nobody knows."""
        if self._tqdm is None:
            return
        if number not in self._bars:
            self._bars[number] = self._tqdm(total=length or None, unit=" " + of, leave=True)
        bar = self._bars[number]
        if bar is None:
            return
        bar.total = length or None
        bar.update(position - bar.n)
        if message:
            bar.set_postfix_str(message, refresh=False)
        if is_finished:
            bar.close()
            self._bars[number] = None
