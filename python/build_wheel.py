"""Builds the wheel (PEP 517): CMake builds and installs the component `python`, whose folder is packed.

    python3 -m build --wheel --no-isolation

From a checkout of the repository, with the packages of the groups build, core and python of packages.txt. The setting
`-C build-dir=FOLDER` takes a CMake build folder that is there; `-C cmake-args=...` gives CMake options of its own.
"""
import os
import re
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

from wheel.wheelfile import WheelFile

ROOT = Path(__file__).resolve().parents[1]
SUMMARY = "Spatial questions about triangle meshes: closest features, signed distances, rays, contact, octrees"


def version():
    return re.search(r"project\(proxima VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]


def tag():
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = re.sub(r"[-.]", "_", sysconfig.get_platform())
    return f"{python}-{python}-{platform}"


def cmake(*arguments):
    subprocess.run(["cmake", *map(str, arguments)], check=True, stdout=sys.stderr)


def built(settings):
    """A build folder with the module in it."""
    if "build-dir" in settings:
        return Path(settings["build-dir"])
    folder = ROOT / "build" / "wheel"
    given = settings.get("cmake-args", "")
    cmake("-S", ROOT, "-B", folder, "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_UNITY_BUILD=ON", "-DCMAKE_UNITY_BUILD_BATCH_SIZE=12",
          "-DPROXIMA_PRECOMPILE_HEADERS=ON", "-DPROXIMA_BUILD_TESTS=OFF", "-DPROXIMA_BUILD_APPS=OFF",
          "-DPROXIMA_BUILD_PYTHON=ON", "-DPROXIMA_REQUIRE_PYTHON=ON", f"-DPython_EXECUTABLE={sys.executable}",
          *(given.split() if isinstance(given, str) else given))
    cmake("--build", folder, "--target", "proxima_python", "--parallel", str(os.cpu_count()))
    return folder


def metadata():
    readme = (ROOT / "README.md").read_text()
    return (f"Metadata-Version: 2.1\nName: proxima\nVersion: {version()}\nSummary: {SUMMARY}\nLicense: MIT\n"
            "Requires-Python: >=3.9\nRequires-Dist: numpy\nDescription-Content-Type: text/markdown\n\n" + readme)


def write_info(folder):
    """What a wheel says about itself. Gives its folder's name."""
    info = Path(folder, f"proxima-{version()}.dist-info")
    info.mkdir()
    (info / "METADATA").write_text(metadata())
    (info / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: proxima\nRoot-Is-Purelib: false\nTag: {tag()}\n")
    (info / "LICENSE").write_text((ROOT / "LICENSE").read_text())
    return info.name


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    return write_info(metadata_directory)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    name = f"proxima-{version()}-{tag()}.whl"
    with tempfile.TemporaryDirectory() as work:
        cmake("--install", built(config_settings or {}), "--prefix", work, "--component", "python", "--strip")
        write_info(work)
        with WheelFile(str(Path(wheel_directory, name)), "w") as wheel:
            wheel.write_files(work)
    return name


def build_sdist(sdist_directory, config_settings=None):
    name = f"proxima-{version()}"
    archive = Path(sdist_directory, f"{name}.tar.gz")
    with tempfile.TemporaryDirectory() as work:
        info = Path(work, "PKG-INFO")
        info.write_text(metadata())
        subprocess.run(["git", "-C", str(ROOT), "archive", f"--prefix={name}/", f"--add-file={info}", "-o", str(archive.resolve()),
                        "HEAD"], check=True)
    return archive.name


def get_requires_for_build_wheel(config_settings=None):
    return []


get_requires_for_build_sdist = get_requires_for_build_wheel
