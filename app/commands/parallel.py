"""Where `joblib` runs its tasks: processes of this machine (loky), a Dask or a Ray cluster."""

from __future__ import annotations

import logging
import signal
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import Literal

from ...core.errors import InputError

Backend = Literal["loky", "dask", "ray"]
CONNECT_SECONDS = 10  # for a Dask scheduler to answer


def parallel_backend(
    backend: Backend, scheduler: str | None, jobs: int | None, ready: Callable[[], object]
) -> AbstractContextManager[None]:
    """What `joblib.Parallel` uses within the context; a local cluster ends with it.

    Args:
        scheduler: the address of a running cluster; by default one is started on this machine.
        jobs: worker processes; by default one for each core.
        ready: is called where the work will be done, and raises InputError if it cannot be.

    Raises:
        InputError: the backend is not installed, or no cluster answers at this address.
    """
    if backend == "dask":
        return _dask(scheduler, jobs, ready)
    if scheduler is None:
        ready()
    return _ray(scheduler, jobs) if backend == "ray" else _loky()


@contextmanager
def _loky() -> Iterator[None]:
    import joblib

    # Ctrl-C reaches every process of a terminal. The command ends the workers itself; each would
    # print a traceback of its own. (The initializer is one that imports nothing first.)
    with joblib.parallel_config(
        "loky",
        inner_max_num_threads=1,
        initializer=signal.signal,
        initargs=(signal.SIGINT, signal.SIG_IGN),
    ):
        yield


@contextmanager
def _dask(scheduler: str | None, jobs: int | None, ready: Callable[[], object]) -> Iterator[None]:
    import joblib

    try:
        import distributed
    except ImportError as error:
        raise _not_installed("dask") from error
    with ExitStack() as stack:
        try:
            cluster: object = scheduler or stack.enter_context(
                distributed.LocalCluster(
                    n_workers=jobs or joblib.cpu_count(),
                    threads_per_worker=1,
                    memory_limit=None,  # for a task whose worker was killed joblib waits for ever
                    dashboard_address=None,
                    silence_logs=logging.ERROR,
                )
            )
            client = stack.enter_context(distributed.Client(cluster, timeout=CONNECT_SECONDS))
        except (OSError, ValueError) as error:
            raise _no_cluster("Dask", scheduler, error) from error
        # For ever, too, for a task that no worker can unpickle for want of this package.
        try:
            client.run(ready)
        except InputError:
            raise
        except Exception as error:  # whatever a worker answers
            raise InputError(
                f"the workers of {scheduler or 'the Dask cluster'} cannot run this: {error}; do "
                "they have the same version of rnnpb-explorer?"
            ) from error
        stack.enter_context(joblib.parallel_config("dask"))
        yield


@contextmanager
def _ray(scheduler: str | None, jobs: int | None) -> Iterator[None]:
    import joblib

    try:
        import ray
        from ray.util.joblib import register_ray
    except ImportError as error:
        raise _not_installed("ray") from error
    try:
        ray.init(
            address=scheduler or "local",
            num_cpus=None if scheduler else jobs,
            include_dashboard=None if scheduler else False,
            log_to_driver=False,
            logging_level=logging.ERROR,
        )
    except (OSError, ValueError, RuntimeError) as error:
        raise _no_cluster("Ray", scheduler, error) from error
    try:
        register_ray()
        with joblib.parallel_config("ray"):
            yield
    finally:
        ray.shutdown()


def _not_installed(backend: str) -> InputError:
    return InputError(
        f"--backend {backend}: {backend} is not installed; pip install 'rnnpb-explorer[{backend}]'"
    )


def _no_cluster(name: str, scheduler: str | None, error: Exception) -> InputError:
    where = f"--scheduler {scheduler}" if scheduler else "a cluster on this machine"
    return InputError(f"{where}: no {name} cluster could be reached or started: {error}")
