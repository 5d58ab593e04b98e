"""Packaging for pip (offline tools) and for colcon as an ament_python package (the node as well).

``pip install .`` is for those who work off line, so it brings all that the command line needs. colcon installs nothing:
what the node needs is in package.xml, and the README names what has no rosdep key.
"""

import re
from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

NAME = "damper_estimator"
ROOT = Path(__file__).resolve().parent
VERSION = re.search(r'__version__ = "(.+)"', (ROOT / NAME / "__init__.py").read_text(encoding="utf-8")).group(1)
ROS_PACKAGE = ElementTree.parse(ROOT / "package.xml").getroot()

# What the node imports besides ROS; numba, among the others, makes it faster, and mcap makes it record.
NODE = [
    "numpy>=1.26,<3",
    "scipy>=1.11,<2",
    "pyyaml>=6.0,<7",
    "rosbags>=0.11,<0.12",
]
OFFLINE = [
    "mcap>=1.2,<2",
    "zstandard>=0.22,<1",
    "plotly>=6.0,<8",
    "jinja2>=3.1,<4",
    "numba>=0.59,<1",
]
EXTRAS = {
    "evolutionary": ["pymoo>=0.6.1,<0.7"],
    "studio": ["dash>=4.1,<5"],
    "fleet": ["distributed>=2024.8,<2027", "pyarrow>=15.0,<27"],
    "test": [
        "pytest>=8.0,<10",
        "pytest-xdist>=3.5,<4",
        "hypothesis>=6.100,<7",
        "playwright>=1.45,<2",
        "fmpy>=0.3.20,<1",
    ],
}
EXTRAS["all"] = [needed for name, extra in EXTRAS.items() if name != "test" for needed in extra]


def installed_beside(folder: str, pattern: str = "**/*") -> list[tuple[str, list[str]]]:
    """The files of ``folder`` as data files that keep their place under ``share/damper_estimator``."""
    files = sorted(path.relative_to(ROOT) for path in (ROOT / folder).glob(pattern) if path.is_file())
    return [(f"share/{NAME}/{path.parent}", [str(path)]) for path in files if "__pycache__" not in path.parts]


setup(
    name=NAME,
    version=VERSION,
    description=ROS_PACKAGE.findtext("description"),
    long_description=(ROOT / "README.md").read_text(encoding="utf-8"),
    long_description_content_type="text/markdown",
    license=ROS_PACKAGE.findtext("license"),
    maintainer=ROS_PACKAGE.findtext("maintainer"),
    project_urls={url.get("type"): url.text for url in ROS_PACKAGE.iter("url")},
    classifiers=[
        "Development Status :: 4 - Beta",
        "Environment :: Console",
        "Intended Audience :: Science/Research",
        "Operating System :: POSIX :: Linux",
        "Programming Language :: Python :: 3",
        "Topic :: Scientific/Engineering :: Physics",
    ],
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={"": ["*.html", "*.css", "*.js", "*.yaml", "assets/*", "fmi/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        # `make man` writes the pages; they are no part of the package that colcon builds.
        ("share/man/man1", sorted(map(str, Path("man").glob("*.1")))),
        *installed_beside("bags", "*.mcap"),
        *installed_beside("config"),
        *installed_beside("launch"),
        *installed_beside("msg_defs/msg"),
    ],
    python_requires=">=3.11",
    install_requires=NODE + OFFLINE,
    extras_require=EXTRAS,
    entry_points={
        "console_scripts": [
            f"damper-estimator = {NAME}.cli.main:main",
            f"estimator_node = {NAME}.node.main:main",
            f"controller_node = {NAME}.node.main:controller",
        ]
    },
    zip_safe=False,
)
