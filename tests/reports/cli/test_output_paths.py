"""Where outputs go: default names, refused places, inputs that stay as they are."""

from tests.reports.cli.command_line import FAST, SMALL, body, fails, run


def test_outputs_that_cannot_be_written_are_refused_before_any_work(mesh_file, tmp_path):
    fails(run("scan", mesh_file, "-o", mesh_file / "sub" / "s.npz"), "folder")
    fails(run("scan", mesh_file, "-o", tmp_path / "s.txt"), ".npz or .ply")
    fails(run("scan", mesh_file, "-o", tmp_path), ".npz")
    fails(run("scan", mesh_file, "-o", tmp_path / "s.npz", "--preview", tmp_path / "p.doc"), ".png")
    fails(run("run", "quick", "-o", mesh_file), "folder")
    assert list(tmp_path.iterdir()) == []


def test_outputs_have_default_names_in_the_current_folder(mesh_file, scan_file, here):
    assert run("scan", mesh_file, *SMALL, "-t", "0.3").exit_code == 0
    assert (here / "body.scan.npz").is_file()
    assert run("match", "body.scan.npz", scan_file, *FAST).exit_code == 0
    assert (here / "body-body.map.npz").is_file()
    assert run("symmetry", "body.scan.npz", *FAST).exit_code == 0
    assert (here / "body.symmetry.npz").is_file()


def test_an_input_is_never_overwritten(mesh_file, scan_file, here):
    scan = here / "scan.npz"
    scan.write_bytes(scan_file.read_bytes())
    before = scan.read_bytes()
    link, hard = here / "link.npz", here / "hard.npz"
    link.symlink_to(scan)
    hard.hardlink_to(scan)
    for out in (scan, "scan.npz", link, hard):
        fails(run("match", scan, scan_file, "-o", out), "is the input", "-o")
        fails(run("match", scan_file, scan, "-o", out), "is the input")
        fails(run("symmetry", scan, "-o", out), "is the input")
    mesh = here / "mesh.ply"
    mesh.write_bytes(mesh_file.read_bytes())
    fails(run("scan", mesh, "-o", mesh, *SMALL), "is the input")
    assert scan.read_bytes() == before
    assert mesh.read_bytes() == mesh_file.read_bytes()
    folder = here / "poses"
    folder.mkdir()
    body().export(folder / "rest.ply")
    fails(run("datasets", folder, "-o", folder), "is the input")
