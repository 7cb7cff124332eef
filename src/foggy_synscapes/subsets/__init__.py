"""The kinds of training and validation list, one module each: a new one is a module that assigns KIND."""

from foggy_synscapes.registry import Registry
from foggy_synscapes.subsets.kind import Kind

KINDS: Registry[Kind] = Registry("subsets", "KIND", "kind of row")
