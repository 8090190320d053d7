"""Finding vehicles, docks and the package's assets by name."""

import difflib
from pathlib import Path
from xml.etree import ElementTree

import marine_mj.assets
import marine_mj.models
from marine_mj.errors import ModelError


def _folders() -> list[Path]:
    """Folders that hold models: the user's ./models first, then the package's."""
    return [Path("models"), Path(marine_mj.models.__file__).parent]


def model_names() -> list[str]:
    """Names of all models that can be found, sorted."""
    names = {
        path.stem
        for folder in _folders()
        if folder.is_dir()
        for path in folder.glob("*/*.xml")
        if path.stem == path.parent.name and not path.stem.startswith("_")
    }
    return sorted(names)


def find_model(name: str) -> Path:
    """MJCF file of a vehicle or dock.

    Args:
        name: `scout` (looked up in ./models and in the package), a folder, or an MJCF file.

    Raises:
        ModelError: there is none; the message lists those that exist.
    """
    path = Path(name)
    candidates = [folder / name / f"{name}.xml" for folder in _folders()]
    candidates += [path] if path.suffix == ".xml" else [path / f"{path.name}.xml"]
    for candidate in candidates:
        if candidate.is_file():
            return candidate.resolve()
    names = model_names()
    near = difflib.get_close_matches(name, names, 1, 0.6)
    hint = f"did you mean {near[0]!r}? " if near else ""
    raise ModelError(
        f"unknown vehicle {name!r}; {hint}there are {', '.join(names)}, any other needs the path "
        "of its folder or MJCF file"
    )


def find_asset(name: str | Path) -> Path | None:
    """File of that path, or of that name in the package's assets; None if there is neither."""
    for path in (Path(name), assets_folder() / name):
        if path.is_file():
            return path.resolve()
    return None


def assets_folder() -> Path:
    """Folder of the package's assets: wave databases and hull meshes."""
    return Path(str(marine_mj.assets.__file__)).parent


def attached_models(xml: Path) -> list[Path]:
    """Files of the models that an MJCF file attaches (`<asset><model file=...>`)."""
    tree = _tree(xml)
    models = () if tree is None else tree.iter("model")
    return [(xml.parent / str(model.get("file"))).resolve() for model in models]


def is_dock(xml: Path) -> bool:
    """Whether an MJCF file has no free joint: docks are attached to a vehicle."""
    tree = _tree(xml)
    if tree is None:
        return False
    if tree.find(".//freejoint") is not None:
        return False
    return all(joint.get("type") != "free" for joint in tree.iter("joint"))


def _tree(xml: Path) -> ElementTree.Element | None:
    """Root element of an MJCF file; None when it is not XML, which is MuJoCo's to tell."""
    try:
        return ElementTree.parse(xml).getroot()
    except ElementTree.ParseError:
        return None
