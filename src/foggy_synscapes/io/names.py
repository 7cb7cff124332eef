"""Names of files that come from files."""


def check_name(name: str) -> None:
    """Raise ValueError for a name that is absolute, empty or climbs out of its folder.

    >>> check_name("img/rgb/1.png")
    """
    parts = name.split("/")
    if not name or name.startswith("/") or "\\" in name or any(part in ("", ".", "..") for part in parts):
        raise ValueError(f"unsafe member name {name!r}")
