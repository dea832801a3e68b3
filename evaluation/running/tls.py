"""Certificates of a Dask cluster: made for one run on this machine, or files for one that runs already."""

import ssl
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from datasets_gen.records import InputError

if TYPE_CHECKING:
    from distributed.security import Security


@dataclass(frozen=True)
class TlsFiles:
    """PEM files with which this process and a running scheduler know each other.

    Attributes
    ----------
    ca : str or Path
        Certificate of the authority that signed the scheduler's and the workers' certificates.
    cert : str or Path
        Certificate of this process.
    key : str, Path or None
        Its private key; None if `cert` holds it too.
    """

    ca: str | Path
    cert: str | Path
    key: str | Path | None = None


def certificate_of_this_run() -> "Security":
    """A key and a certificate that exist in the memory of this run's processes only.

    Raises
    ------
    InputError
        If the library that makes them is missing.
    """
    from distributed.security import Security

    try:
        return Security.temporary()
    except ImportError as error:
        raise InputError("a local cluster needs a package: pip install cryptography") from error


def security_of(address: str, files: TlsFiles | None) -> "Security":
    """What a client needs to talk to a scheduler: the files given, else those of Dask's own configuration.

    Parameters
    ----------
    address
        Of the scheduler.
    files

    Raises
    ------
    InputError
        If files are given for an address without TLS, missing for one with TLS, or not usable.
    """
    from distributed.security import Security

    encrypted = address.startswith("tls://")
    if files is not None and not encrypted:
        raise InputError(
            f"certificates are for a scheduler at tls://HOST:PORT, not {address!r}; start it with TLS"
        )
    try:
        found = Security() if files is None else _from_files(files)
        arguments = found.get_connection_args("client")
    except (OSError, ssl.SSLError, ValueError) as error:
        named = "Dask's configuration" if files is None else ", ".join(map(repr, _names(files)))
        raise InputError(f"the certificates of {named} cannot be used ({error}); give PEM files") from error
    if encrypted and arguments["ssl_context"] is None:
        raise InputError(
            f"{address!r} needs certificates: give --tls-ca, --tls-cert and --tls-key (tls= in Python)"
        )
    return found


def _from_files(files: TlsFiles) -> "Security":
    from distributed.security import Security

    for name in _names(files):
        if not Path(name).is_file():
            raise InputError(f"no certificate file {name!r}; give a PEM file")
    key = None if files.key is None else str(files.key)
    return Security(
        require_encryption=True,
        tls_ca_file=str(files.ca),
        tls_client_cert=str(files.cert),
        tls_client_key=key,
    )


def _names(files: TlsFiles) -> list[str]:
    return [str(each) for each in (files.ca, files.cert, files.key) if each is not None]
