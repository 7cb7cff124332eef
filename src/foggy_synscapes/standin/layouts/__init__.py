"""The stand-ins in the real layouts, one module each: a dataset gets one by a module that assigns STAND_IN."""

from foggy_synscapes.registry import Registry
from foggy_synscapes.standin.layouts.layout import StandIn

STAND_INS: Registry[StandIn] = Registry("standin.layouts", "STAND_IN", "stand-in")
