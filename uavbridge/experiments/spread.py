"""Who does the work: this process, several, or a Dask cluster. The numbers are the same."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

from uavbridge.errors import ConfigError, UavbridgeError


class Spread(Protocol):
    """Does ``work`` on every task; yields (place of the task, result) as they are done."""

    def __call__(
        self, work: Callable[[Any], Any], tasks: Sequence[Any], /
    ) -> Iterator[tuple[int, Any]]: ...


@dataclass(frozen=True, slots=True)
class Here:
    """One task after the other in this process."""

    def __call__(
        self, work: Callable[[Any], Any], tasks: Sequence[Any]
    ) -> Iterator[tuple[int, Any]]:
        for place, task in enumerate(tasks):
            yield place, work(task)


@dataclass(frozen=True, slots=True)
class Processes:
    """A pool of fresh processes; an interrupt ends them all, and so does the death of this one."""

    workers: int

    def __call__(
        self, work: Callable[[Any], Any], tasks: Sequence[Any]
    ) -> Iterator[tuple[int, Any]]:
        others = set(multiprocessing.active_children())
        pool = ProcessPoolExecutor(
            min(self.workers, max(len(tasks), 1)),
            mp_context=multiprocessing.get_context("spawn"),
            initializer=_end_with_parent,
        )
        done = False
        try:
            with _no_interrupt():  # workers are started here, and inherit it
                places = {pool.submit(work, task): place for place, task in enumerate(tasks)}
            for future in as_completed(places):
                yield places[future], future.result()
            done = True
        finally:
            if not done:
                for child in set(multiprocessing.active_children()) - others:
                    child.terminate()
            pool.shutdown(wait=True, cancel_futures=True)


@dataclass(frozen=True, slots=True)
class Dask:
    """An existing Dask cluster, by the address of its scheduler.

    Raises:
        ConfigError: the extra ``dask`` is not installed, or the address makes no sense.
        UavbridgeError: the scheduler does not answer.
    """

    address: str
    timeout_s: float = 10.0

    def __call__(
        self, work: Callable[[Any], Any], tasks: Sequence[Any]
    ) -> Iterator[tuple[int, Any]]:
        try:
            distributed: Any = importlib.import_module("distributed")
        except ImportError as error:
            raise ConfigError("--dask needs the extra: pip install 'uavbridge[dask]'") from error
        try:
            client = distributed.Client(self.address, timeout=self.timeout_s, set_as_default=False)
        except ValueError as error:
            raise ConfigError(f"--dask {self.address}: {error}") from error
        except OSError as error:
            raise UavbridgeError(f"no Dask scheduler answers at {self.address}") from error
        with client:
            futures = client.map(work, tasks, pure=False)
            places = {future.key: place for place, future in enumerate(futures)}
            try:
                for future in distributed.as_completed(futures, loop=client.loop):
                    yield places[future.key], future.result()
            finally:
                client.cancel(futures)


def choose(workers: int, dask: str | None = None) -> Spread:
    """The spread for a number of workers, or for a Dask scheduler's address.

    Raises:
        ConfigError: fewer than one worker.
    """
    if dask is not None:
        return Dask(dask)
    if workers < 1:
        raise ConfigError(f"--workers must be at least 1, not {workers}")
    return Here() if workers == 1 else Processes(workers)


def _end_with_parent() -> None:
    """In a worker: end at once when the parent is gone, were it killed in the middle of a task."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def wait() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


@contextmanager
def _no_interrupt() -> Iterator[None]:
    """Hold back Ctrl-C; it comes afterwards, and never to processes started meanwhile.

    The mask is for those; here numpy's threads may take the signal, so its handler waits too.
    """
    held: list[int] = []
    aside = threading.current_thread() is threading.main_thread()
    handler = signal.signal(signal.SIGINT, lambda *_: held.append(1)) if aside else None
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        if aside:
            signal.signal(signal.SIGINT, handler)
        if held:
            signal.raise_signal(signal.SIGINT)
