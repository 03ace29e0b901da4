"""The files of this checkout that its checks read."""
import pathlib
import shutil
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[1]
C_FAMILY = {".cpp", ".hpp", ".c", ".h"}


def source_files(root=ROOT):
    """Every file under version control or new to it, relative to root; in a checkout without git, every file that is
    not in a folder made by a build."""
    listed = subprocess.run(["git", "-C", str(root), "ls-files", "-z", "--cached", "--others",
                             "--exclude-standard"], capture_output=True, text=True, check=False) \
        if (root / ".git").exists() and shutil.which("git") else None
    if listed and listed.returncode == 0:
        names = map(pathlib.PurePosixPath, filter(None, listed.stdout.split("\0")))
    else:
        names = (pathlib.PurePosixPath(path.relative_to(root)) for path in root.rglob("*"))
        names = (name for name in names
                 if not name.parts[0].startswith("build") and name.parts[0] not in ("out", ".git")
                 and "__pycache__" not in name.parts)
    return sorted(name for name in names if (root / name).is_file())
