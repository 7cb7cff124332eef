"""What params are made of: sections of settings, each with its meaning, unit and source where it is defined.

From here come the comments of a resolved params file, the JSON Schema and docs/parameters.md; so each fact stands once.
"""

from dataclasses import dataclass
from types import UnionType
from typing import Annotated, Any, ClassVar, Union, get_args, get_origin, get_type_hints

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, GetJsonSchemaHandler, ValidationInfo, field_validator
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue

from foggy_synscapes.betas import beta_name


class Section(BaseModel):
    """A part of the params file: unknown keys are errors, values do not change after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    inline: ClassVar[bool] = False
    """Whether it is written on one line where it fits there."""
    whole: ClassVar[bool] = False
    """Whether an overlay that states it replaces all of it, because its keys stand for each other."""

    @field_validator("*", mode="before")
    @classmethod
    def _of_its_own_kind(cls, value: Any, info: ValidationInfo) -> Any:
        """YAML tells numbers, texts and truth values apart; pydantic would take "8" for a number and 1 for true."""
        annotation = cls.model_fields[info.field_name or ""].annotation
        kinds = {annotation, *get_args(annotation)}
        if kinds & {int, float} and str not in kinds and isinstance(value, bool | str):
            raise ValueError(f"should be a number, without quotes, and with a point where it has an exponent (1.0e-3); got {value!r}")
        if int in kinds and float not in kinds and isinstance(value, float):
            raise ValueError(f"should be a whole number, written without a point; got {value!r}")
        if bool in kinds and not isinstance(value, bool) and not (value is None and type(None) in kinds):
            raise ValueError(f"should be true or false; got {value!r}")
        return value


@dataclass(frozen=True)
class Range:
    """The range of a type that a pattern or a check of its own limits, in words for docs."""

    words: str

    def __get_pydantic_json_schema__(self, core: Any, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {**handler(core), "range": self.words}


def setting(
    meaning: str,
    *,
    default: Any = ...,
    unit: str | None = None,
    published: str | None = None,
    source: str | None = None,
    key: str | None = None,
    merged: bool | None = None,
    **limits: Any,
) -> Any:
    """A field of a section.

    meaning : what it decides, in words that may follow its value
    default : only where a file, with the packaged defaults, may leave it out
    published : the value in the paper or in its authors' code, where one is known; source : where that stands
    key : of a mapping whose keys the user names, what stands for one in docs, e.g. "ROW"
    merged : of such a mapping, whether an overlay states single keys of it, instead of replacing it whole
    limits : constraints of pydantic, such as `ge=0`
    """
    facts: dict[str, Any] = {"unit": unit, "published": published, "source": source, "key": key, "merged": merged}
    extra = {name: fact for name, fact in facts.items() if fact is not None}
    return Field(default=default, description=meaning, json_schema_extra=extra or None, **limits)


def facts_of(field: FieldInfo) -> dict[str, Any]:
    """What `setting` was told of a field beside its meaning: unit, published, source, key, merged."""
    return field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}


def members(annotation: Any) -> list[Any]:
    """The alternatives of a union, or the one type, without None.

    >>> members(int | None)
    [<class 'int'>]
    """
    parts = get_args(annotation) if get_origin(annotation) in (Union, UnionType) else (annotation,)
    return [part for part in parts if part is not type(None)]


def section_in(annotation: Any) -> type[Section] | None:
    """The section that a field of this type is, or may be; None where it is something else."""
    found = [part for part in members(annotation) if isinstance(part, type) and issubclass(part, Section)]
    return found[0] if found else None


def open_section(model: type[Section]) -> type[Section] | None:
    """What the keys of a section hold that are none of its fields, where it takes such keys."""
    if model.model_config["extra"] != "allow":
        return None
    return get_args(get_type_hints(model)["__pydantic_extra__"])[1]


def section_at(model: type[Section], key: str) -> type[Section] | None:
    """The section below a key of a section; None where there is another kind of value, or no such key."""
    for name, field in model.model_fields.items():
        if key == (field.alias or name):
            return section_in(field.annotation)
    return open_section(model)


def is_merged(model: type[Section], key: str) -> bool:
    """Whether the mapping below a key of a section is merged key by key."""
    fields = [field for name, field in model.model_fields.items() if key == (field.alias or name)]
    return any(facts_of(field).get("merged") for field in fields)


def sections(annotation: Any) -> list[type[Section]]:
    """All sections that a field of this type may hold, also in lists and mappings."""
    found = []
    for part in members(annotation):
        if isinstance(part, type) and issubclass(part, Section):
            found.append(part)
        else:
            found += [each for inner in get_args(part) for each in sections(inner)]
    return found


Count = Annotated[int, Field(ge=1)]


def _canonical_beta(text: str) -> str:
    name = beta_name(text)
    if name != text:
        raise ValueError(f"beta {text!r}: write {name!r}, as the folder spells it, so that no two betas share a folder")
    return text


Beta = Annotated[str, AfterValidator(_canonical_beta), Range("> 0, quoted")]
