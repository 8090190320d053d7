"""Finding vehicle and dock folders: packaged ones, those in ./models, or any path."""

import difflib
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from xml.etree import ElementTree

from marine_mj.errors import ModelError


@dataclass(frozen=True)
class ModelFolder:
    """A folder with one vehicle or dock.

    Attributes:
        name: of the folder and of its XML file.
        xml: path of the XML file.
        is_dock: it has no free joint: it is attached to a vehicle.
    """

    name: str
    xml: Path
    is_dock: bool


def model_roots() -> list[Path]:
    """Folders that are searched for models: ./models first, then the packaged ones."""
    packaged = Path(str(resources.files("marine_mj.models")))
    local = Path.cwd() / "models"
    return [local, packaged] if local.is_dir() and local != packaged else [packaged]


def models() -> dict[str, ModelFolder]:
    """Every model folder by name; a folder in ./models hides a packaged one of the same name."""
    found: dict[str, ModelFolder] = {}
    for root in reversed(model_roots()):
        for folder in sorted(p for p in root.iterdir() if p.is_dir()):
            xml = folder / f"{folder.name}.xml"
            if xml.is_file() and not folder.name.startswith("_"):
                found[folder.name] = ModelFolder(folder.name, xml, _is_dock(xml))
    return found


def find_model(name: str | Path) -> Path:
    """Path of the XML file of a model.

    Args:
        name: name of a model folder, or path of a folder or XML file.

    Raises:
        ModelError: there is none; the message lists what exists.
    """
    path = Path(name)
    if path.is_file() and path.suffix == ".xml":
        return path.resolve()
    if path.is_dir() and (path / f"{path.resolve().name}.xml").is_file():
        return (path / f"{path.resolve().name}.xml").resolve()
    available = models()
    if str(name) in available:
        return available[str(name)].xml
    near = difflib.get_close_matches(str(name), available, 1)
    hint = f" Did you mean {near[0]!r}?" if near else ""
    raise ModelError(
        f"model {str(name)!r} does not exist.{hint} Available: {', '.join(available) or 'none'}; "
        f"or give the path of a folder NAME that holds NAME.xml "
        f"(searched in {', '.join(str(r) for r in model_roots())})"
    )


def _is_dock(xml: Path) -> bool:
    """Whether an XML file has no free joint."""
    try:
        tree = ElementTree.parse(xml)
    except ElementTree.ParseError:
        return False
    if tree.find(".//freejoint") is not None:
        return False
    return all(joint.get("type") != "free" for joint in tree.iter("joint"))
