"""Whether a Dask scheduler of these versions answers at an address, told within seconds."""

import asyncio
import logging
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

from datasets_gen.records import InputError

if TYPE_CHECKING:
    from distributed.security import Security

ANSWER_WITHIN = 6.0
"""Seconds in which a scheduler must say what it is; Dask waits for ever for a peer that is silent."""

CONNECT_WITHIN = 4.0
"""Seconds of these for the connection."""

SAME = ("distributed", "python")
"""What the scheduler must have in the same version; workers are asked for the rest."""


def check_scheduler(address: str, security: "Security", here: Mapping[str, str]) -> None:
    """Check that a scheduler listens at an address.

    Parameters
    ----------
    address
    security
        Certificates of this process.
    here
        Versions of this process, by name.

    Raises
    ------
    InputError
        If nothing answers in time, what answers is no scheduler, or it has other versions.
    """
    _check_address(address)
    log = logging.getLogger("asyncio")
    before = log.level
    log.setLevel(logging.CRITICAL)  # of a connection that is broken off
    try:
        with ThreadPoolExecutor(1) as thread:  # notebooks have a running event loop in this one
            who, versions = thread.submit(asyncio.run, _answer(address, security)).result()
        kind, there = str(who["type"]), _versions(versions)
    except TimeoutError as error:
        raise _nobody(address, f"no answer in {ANSWER_WITHIN:g} s") from error
    except OSError as error:
        raise _nobody(address, " ".join(str(error).split(">: ")[-1].split())) from error
    except Exception as error:  # the reader of another protocol's bytes raises anything
        raise _nobody(address, "what answers there is something else") from error
    finally:
        log.setLevel(before)
    if kind != "Scheduler":
        raise InputError(
            f"{address!r} is a {kind} of Dask, no scheduler; give the address `dask scheduler` prints"
        )
    for name in SAME:
        if there.get(name) != here.get(name):
            raise InputError(
                f"the scheduler at {address!r} has {name} {there.get(name, 'missing')}, this process has "
                f"{here.get(name)}; install the same versions everywhere"
            )


def _check_address(address: str) -> None:
    from distributed.comm.addressing import parse_address, parse_host_port

    try:
        parse_host_port(parse_address(address)[1])
    except ValueError as error:
        raise InputError(
            f"{address!r} is no address of a scheduler ({error}); give tls://HOST:PORT or tcp://HOST:PORT"
        ) from error


def _nobody(address: str, why: str) -> InputError:
    tls = "" if address.startswith("tls://") else "; one with TLS has an address tls://HOST:PORT"
    return InputError(f"no Dask scheduler answers at {address!r} ({why}): start `dask scheduler` there{tls}")


async def _answer(address: str, security: "Security") -> tuple[Any, Any]:
    return await asyncio.wait_for(_ask(address, security), ANSWER_WITHIN)


async def _ask(address: str, security: "Security") -> tuple[Any, Any]:
    """Identity and versions of the peer, in plain values: nothing that it sends is unpickled."""
    from distributed.comm import connect
    from distributed.core import send_recv

    arguments = security.get_connection_args("client")
    comm = await connect(address, timeout=CONNECT_WITHIN, **arguments)
    plain = ("msgpack",)
    try:
        who = await send_recv(comm, op="identity", reply=True, serializers=plain, deserializers=plain)
        versions = await send_recv(comm, op="versions", reply=True, serializers=plain, deserializers=plain)
        return who, versions
    finally:
        comm.abort()


def _versions(answer: Any) -> dict[str, str]:
    """Versions by name, of what Dask answers to the question for them."""
    python = str(answer["host"]["python"]).split(".")
    return {**answer["packages"], "python": ".".join(python[:3])}
