"""Settings that are one TOML file: read, written, packaged by name."""

import tomllib
from importlib import resources
from pathlib import Path
from typing import ClassVar, Self

from marine_mj import toml
from marine_mj.errors import ScenarioError
from marine_mj.settings import Settings


class SettingsFile(Settings):
    """Base of settings that fill a TOML file.

    Attributes:
        kind: what one is called in messages; packaged ones lie in the package's folder `KINDs`.
    """

    kind: ClassVar[str] = "settings"

    @classmethod
    def packaged(cls) -> dict[str, Path]:
        """Packaged files by name."""
        folder = Path(str(resources.files("marine_mj") / f"{cls.kind}s"))
        return {path.stem: path for path in sorted(folder.glob("*.toml"))}

    @classmethod
    def find(cls, name: str | Path) -> Path:
        """TOML file of that path, or the packaged one of that name.

        Raises:
            ScenarioError: no such file or packaged one; the message lists these.
        """
        if Path(name).is_file():
            return Path(name)
        packaged = cls.packaged()
        if str(name) not in packaged:
            raise ScenarioError(
                f"{cls.kind} {str(name)!r} is neither a file nor a packaged {cls.kind}; "
                f"packaged: {', '.join(packaged)}"
            )
        return packaged[str(name)]

    @classmethod
    def from_toml(cls, text: str, where: str = "") -> Self:
        """Settings from TOML text.

        Args:
            text: content of the file.
            where: what it belongs to, for messages; default: the kind.

        Raises:
            ScenarioError: not valid TOML, an unknown key, or a value that is not allowed.
        """
        where = where or cls.kind
        try:
            values = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise ScenarioError(f"{where} is not valid TOML: {error}") from None
        return cls.parse(values, where)

    @classmethod
    def load(cls, name: str | Path) -> Self:
        """Settings from a TOML file, or packaged ones by their name.

        Raises:
            ScenarioError: see `find` and `from_toml`.
        """
        path = cls.find(name)
        return cls.from_toml(path.read_text(encoding="utf-8"), f"{cls.kind} {path.name}")

    def to_toml(self) -> str:
        """TOML text that `from_toml` reads back to equal settings."""
        return toml.dump(self.model_dump())
