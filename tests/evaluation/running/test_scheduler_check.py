"""Wrong peers at --scheduler are told within seconds, and a right one is taken."""

import socket
import threading
import time
from importlib import import_module

import pytest

from datasets_gen import InputError
from evaluation.running.environment import versions
from evaluation.running.scheduler_check import check_scheduler
from evaluation.running.tls import TlsFiles, certificate_of_this_run, security_of

ANSWERS = {
    "silent": None,
    "closes": b"",
    "ssh": b"SSH-2.0-OpenSSH_9.2\r\n",
    "http": b"HTTP/1.1 400 Bad Request\r\n\r\n",
    "zeros": bytes(4096),
    "ones": b"\xff" * 4096,
}


@pytest.fixture
def peer():
    """Starts servers that answer every connection with some bytes, or with nothing; gives their address."""
    ended, sockets = threading.Event(), []

    def start(answer):
        server = socket.create_server(("127.0.0.1", 0))
        sockets.append(server)

        def serve():
            while not ended.is_set():
                try:
                    connection, _ = server.accept()
                except OSError:
                    return
                sockets.append(connection)
                if answer is not None:
                    connection.sendall(answer)
                    if not answer:
                        connection.close()

        threading.Thread(target=serve, daemon=True).start()
        return f"tcp://127.0.0.1:{server.getsockname()[1]}"

    yield start
    ended.set()
    for each in sockets:
        each.close()


def refusal(address):
    """What is said of an address, and the seconds it took."""
    import_module("distributed")  # which takes seconds where others compute
    start = time.perf_counter()
    with pytest.raises(InputError) as error:
        check_scheduler(address, security_of(address, None), versions())
    assert "\n" not in str(error.value)
    return str(error.value), time.perf_counter() - start


@pytest.mark.parametrize("kind", ANSWERS)
def test_a_peer_that_is_no_dask_is_refused_within_seconds(kind, peer):
    said, seconds = refusal(peer(ANSWERS[kind]))
    assert said.startswith("no Dask scheduler answers at")
    assert "start `dask scheduler`" in said
    assert seconds < 10


def test_nobody_listens():
    said, seconds = refusal("tcp://127.0.0.1:1")
    assert said.startswith("no Dask scheduler answers at 'tcp://127.0.0.1:1'")
    assert seconds < 10


@pytest.mark.parametrize("address", ["", "nonsense", "tcp://127.0.0.1", "/tmp/scheduler.json"])
def test_what_is_no_address(address):
    said, seconds = refusal(address)
    assert "is no address of a scheduler" in said
    assert seconds < 2


@pytest.fixture(scope="module")
def clusters():
    """A cluster without TLS and one with."""
    from distributed import LocalCluster

    common = {"n_workers": 1, "processes": False, "dashboard_address": "127.0.0.1:0"}
    with (
        LocalCluster(protocol="tcp://", host="127.0.0.1", **common) as plain,
        LocalCluster(
            protocol="tls://", host="127.0.0.1", security=certificate_of_this_run(), **common
        ) as safe,
    ):
        yield plain, safe


def test_a_scheduler_of_these_versions_is_taken(clusters):
    for cluster in clusters:
        check_scheduler(cluster.scheduler_address, cluster.security, versions())


def test_a_scheduler_of_other_versions_is_refused(clusters):
    address = clusters[0].scheduler_address
    for name in ("distributed", "python"):
        with pytest.raises(InputError, match=f"has {name} .*, this process has 1.0; install the same"):
            check_scheduler(address, security_of(address, None), {**versions(), name: "1.0"})


def test_a_worker_is_no_scheduler(clusters):
    said, _ = refusal(clusters[0].workers[0].address)
    assert "is a Worker of Dask, no scheduler" in said


def test_another_protocol_or_certificate_is_refused(clusters):
    plain, safe = (cluster.scheduler_address for cluster in clusters)
    said, _ = refusal(safe.replace("tls://", "tcp://"))
    assert "one with TLS has an address tls://" in said
    own = certificate_of_this_run()
    for address in (safe, plain.replace("tcp://", "tls://")):
        with pytest.raises(InputError, match="no Dask scheduler answers"):
            check_scheduler(address, own, versions())


def test_it_can_be_asked_where_an_event_loop_runs(clusters):
    """In a notebook."""
    import asyncio

    plain = clusters[0]

    async def cell():
        check_scheduler(plain.scheduler_address, plain.security, versions())

    asyncio.run(cell())


@pytest.fixture
def files(tmp_path):
    """The certificate and key of a cluster, as files."""
    made = certificate_of_this_run()
    (tmp_path / "ca.pem").write_text(made.tls_ca_file)
    (tmp_path / "key.pem").write_text(made.tls_client_key)
    return TlsFiles(tmp_path / "ca.pem", tmp_path / "ca.pem", tmp_path / "key.pem")


def test_certificates_from_files(files):
    from distributed import LocalCluster

    found = security_of("tls://127.0.0.1:1", files)
    found.tls_scheduler_cert = found.tls_worker_cert = str(files.cert)
    found.tls_scheduler_key = found.tls_worker_key = str(files.key)
    with LocalCluster(
        n_workers=0, protocol="tls://", security=found, dashboard_address="127.0.0.1:0"
    ) as cluster:
        address = cluster.scheduler_address
        check_scheduler(address, security_of(address, files), versions())


def test_certificates_that_cannot_be_used(files, tmp_path):
    from dataclasses import replace

    with pytest.raises(InputError, match="needs certificates: give --tls-ca"):
        security_of("tls://127.0.0.1:1", None)
    with pytest.raises(InputError, match="certificates are for a scheduler at tls://"):
        security_of("tcp://127.0.0.1:1", files)
    with pytest.raises(InputError, match=r"no certificate file '.*none.pem'"):
        security_of("tls://127.0.0.1:1", replace(files, ca=tmp_path / "none.pem"))
    (tmp_path / "bad.pem").write_text("no certificate")
    with pytest.raises(InputError, match="cannot be used") as error:
        security_of("tls://127.0.0.1:1", replace(files, cert=tmp_path / "bad.pem"))
    assert "\n" not in str(error.value)
