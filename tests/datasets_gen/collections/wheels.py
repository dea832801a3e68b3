"""Small packages laid out like those whose files are read, for machines that do not have them."""


def install(monkeypatch, root, wheel, version=None):
    """Lay an empty package, with its metadata and licences, on the import path; returns its folder."""
    package = root / wheel.package
    package.mkdir(parents=True)
    (package / "__init__.py").touch()
    name = wheel.distribution.replace("-", "_")
    info = root / f"{name}-{wheel.version}.dist-info"
    (info / "licenses").mkdir(parents=True)
    (info / "licenses" / "LICENSE").write_text("You may.\n", encoding="utf-8")
    found = version or wheel.version
    (info / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {wheel.distribution}\nVersion: {found}\n", encoding="utf-8"
    )
    monkeypatch.syspath_prepend(root)
    monkeypatch.setenv("MEDIALBENCH_CACHE", str(root / "cache"))
    return package
