"""Notes the commit in what is built, and gives all files its time: a commit gives one wheel everywhere.

The commit is that of git, or of the sdist that is built; where there is neither, as in a container, the
environment variable SOURCE_COMMIT may name it. All else is in pyproject.toml.
"""

from __future__ import annotations

import gzip
import os
import runpy
import tarfile
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

HERE = Path(__file__).parent
SOURCE = runpy.run_path(str(HERE / "service" / "commit.py"))
NOTE: str = os.environ.get("SOURCE_COMMIT") or SOURCE["note_of"](HERE) or ""


def note(folder: Path) -> None:
    """Write what is known into a package that is being built."""
    if NOTE:
        (folder / "service" / SOURCE["FILE"]).write_text(f"{NOTE}\n", encoding="ascii")


class BuildPy(build_py):
    """The step that copies the modules."""

    def run(self) -> None:
        """Copy them, and note the commit; a checkout that is installed as it is asks git."""
        super().run()
        if not self.editable_mode:
            note(Path(self.build_lib))


class Sdist(sdist):
    """The step that packs the source."""

    def make_release_tree(self, base_dir: str, files: list[str]) -> None:
        """Collect the files, and note the commit."""
        super().make_release_tree(base_dir, files)
        note(Path(base_dir))

    def make_archive(self, base_name: str, *_: object, base_dir: str, **__: object) -> str:
        """Pack the source; of time, owner and order of the files, only what the commit says is in it."""
        name = f"{base_name}.tar.gz"
        time = int(os.environ.get("SOURCE_DATE_EPOCH", "0"))

        def neutral(entry: tarfile.TarInfo) -> tarfile.TarInfo:
            entry.mtime, entry.uid, entry.gid, entry.uname, entry.gname = time, 0, 0, "", ""
            entry.mode = 0o755 if entry.isdir() or entry.mode & 0o100 else 0o644
            return entry

        with (
            gzip.GzipFile(name, "wb", compresslevel=9, mtime=time) as packed,
            tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as archive,
        ):
            for path in sorted([Path(base_dir), *Path(base_dir).rglob("*")]):
                archive.add(path, recursive=False, filter=neutral)
        return name


os.umask(0o022)  # what is written has the modes that it has everywhere
if time := NOTE.partition(" ")[2]:
    os.environ.setdefault("SOURCE_DATE_EPOCH", time)
setup(cmdclass={"build_py": BuildPy, "sdist": Sdist})
