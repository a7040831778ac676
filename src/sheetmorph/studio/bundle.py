"""Where three.js comes from: the bundle that NiceGUI carries, so that nothing is fetched."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from sheetmorph.core.errors import InputError

PLACE = "elements/scene/dist/index.js"
INSTALL = 'pip install "sheetmorph[studio]"'


def three_js() -> Path:
    """The file of three.js with its orbit controls, as a JavaScript module.

    Raises:
        InputError: NiceGUI is not installed, or does not have it.
    """
    spec = find_spec("nicegui")
    if spec is None or spec.origin is None:
        raise InputError(f"the studio needs more packages; install them with: {INSTALL}")
    file = Path(spec.origin).parent / PLACE
    if not file.is_file():
        raise InputError(f"this release of NiceGUI carries no three.js; {INSTALL}", file=file)
    return file
