"""Simulate a campaign of many flights on the workers of a Dask cluster.

All options except those below are passed to `squid campaign`, and the results equal its results bit for bit: workers
simulate parts with that command. Existing results are not computed again.
"""

from __future__ import annotations

import argparse
import logging
import shutil
import signal
import sys
import tempfile
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from itertools import islice
from multiprocessing import resource_tracker
from pathlib import Path
from types import FrameType

import cloudpickle
from distributed import Client, Future, LocalCluster, as_completed
from distributed.scheduler import KilledWorker
from fly import build, master
from fly.stages import StageError

from squid_campaign import worker
from squid_campaign.ways import ByCommand, ByFmus, CampaignError, Command, Part
from squid_campaign.worker import Files

AHEAD = 3
"""Parts a core that the scheduler knows of at a time: enough that no core waits for the next."""
ANSWER = 5.0
"""How long a scheduler may take to answer (s)."""
FIRST_WORKER = 60.0
"""How long its first worker may take to come (s)."""


def main() -> int:
    """Simulate the missing flights, and print the statistics of all results."""
    arguments, words = parser().parse_known_args()
    # Dask's log messages about an error are replaced by our message.
    logging.disable()
    try:
        with tempfile.TemporaryDirectory() as records:
            words += ["--records", records] if arguments.fmu else []
            command = Command(squid_command(arguments.squid), words)
            asked = command.ask()
            if asked["missing"]:
                way = ByFmus(command, asked, Path(records)) if arguments.fmu else ByCommand(command, asked)
                with cluster(arguments) as client:
                    fly_all(client, way, asked)
            command.run(aloud=True)
    except (CampaignError, StageError) as error:
        print(f"squid_campaign: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        words = "interrupted; what was flown is kept, and the same command goes on from here."
        print(f"squid_campaign: {words}", file=sys.stderr)
        return 130
    return 0


def squid_command(given: str | None) -> str:
    """Return the given command, or else that on the PATH or that of this checkout."""
    found = given or shutil.which("squid") or str(build.squid())
    # The working directory of a worker differs.
    return str(Path(found).absolute()) if Path(found).is_file() else found


def parser() -> argparse.ArgumentParser:
    """Return the parser of the options that are not for `squid campaign`."""
    top = argparse.ArgumentParser(prog="squid_campaign", description=__doc__, allow_abbrev=False)
    where = top.add_mutually_exclusive_group(required=True)
    where.add_argument("--scheduler", metavar="ADDRESS", help="that of a cluster, such as tcp://host:8786")
    where.add_argument("--workers", metavar="N", type=int, help="a cluster of so many processes, here")
    top.add_argument(
        "--fmu",
        action="store_true",
        help="fly the FMUs of the design; a worker then needs FMPy and distributed alone",
    )
    top.add_argument(
        "--squid",
        help="the command squid, here and on each worker (default: that on the PATH, or that of this checkout)",
    )
    return top


@contextmanager
def cluster(arguments: argparse.Namespace) -> Iterator[Client]:
    """Yield a client of the requested cluster."""
    if arguments.scheduler is None and arguments.workers < 1:
        raise CampaignError(f"--workers is {arguments.workers}; it must be at least 1.")
    try:
        if arguments.scheduler is None:
            with uninterrupted():
                own = LocalCluster(
                    n_workers=arguments.workers,
                    threads_per_worker=1,
                    dashboard_address=None,
                    silence_logs=logging.CRITICAL,
                )
            with own, Client(own) as client:
                yield client
        else:
            with Client(arguments.scheduler, timeout=ANSWER) as client:
                yield client
    except (OSError, ValueError, TimeoutError, CancelledError) as reason:
        where = arguments.scheduler or "of the workers here"
        raise CampaignError(
            f"the scheduler {where} does not answer ({type(reason).__name__}); what was flown is kept."
        ) from None


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Hold Ctrl-C back; processes started meanwhile, and their children, never receive it: we end them."""
    if not hasattr(signal, "pthread_sigmask"):
        # Not available on Windows.
        yield
        return
    # Otherwise the first process would start it, which lets Ctrl-C through again.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def interruptible() -> Iterator[Callable[[], None]]:
    """Hold the first Ctrl-C back until the function that is yielded is called, which raises it.

    Raised at an arbitrary point, it may hit a destructor of Dask, in which Python ignores it. The second one is raised
    at once.
    """
    pressed = []

    def hear(number: int, _: FrameType | None) -> None:
        signal.signal(signal.SIGINT, before)
        pressed.append(number)

    def check() -> None:
        if pressed:
            raise KeyboardInterrupt

    before = signal.getsignal(signal.SIGINT)
    # An ignored signal, as in the background of a shell, stays ignored.
    if before is signal.default_int_handler:
        signal.signal(signal.SIGINT, hear)
    try:
        yield check
    except SystemExit:
        # The command received it, too.
        check()
        raise
    finally:
        signal.signal(signal.SIGINT, before)


def fly_all(client: Client, way: ByCommand | ByFmus, asked: dict) -> None:
    """Simulate the missing parts, some at a time, and store each as soon as it is finished.

    Dask repeats the part of a lost worker on another one.
    """
    # Workers need not have these modules.
    cloudpickle.register_pickle_by_value(worker)
    cloudpickle.register_pickle_by_value(master)
    name = f"squid-{uuid.uuid4().hex}"
    try:
        client.wait_for_workers(1, timeout=FIRST_WORKER)
    except TimeoutError:
        raise CampaignError("the scheduler has no workers; start one with `dask worker ADDRESS`.") from None
    client.register_plugin(Files(name, way.files()), name=name)
    todo = iter([(first, last) for first, last in asked["missing"]])
    flying: dict[str, Part] = {}
    running = as_completed()

    def fill() -> None:
        """Submit further parts to the scheduler."""
        room = AHEAD * max(1, sum(client.nthreads().values())) - len(flying)
        for part in islice(todo, max(0, room)):
            future = client.submit(way.task(name, part), key=f"{name}-{part[0]}")
            flying[future.key] = part
            running.add(future)

    try:
        with interruptible() as check:
            fill()
            for future in running:
                part = flying.pop(future.key)
                way.keep(part, flown(future, part))
                del future
                check()
                fill()
    finally:
        with suppress(Exception):
            client.unregister_worker_plugin(name)


def flown(future: Future, part: Part) -> bytes:
    """Return the result of a worker; raise an error if it failed."""
    try:
        return future.result()
    except KilledWorker:
        reason = "each worker that was given them was lost"
    except CancelledError:
        # The connection to the scheduler is lost.
        raise
    except Exception as error:
        reason = str(error)
    raise CampaignError(f"flights {part[0]} to {part[1]}: {reason}")


if __name__ == "__main__":
    sys.exit(main())
