"""`python -m foggy_synscapes` is the command `foggy`."""

import sys

from foggy_synscapes.cli import main

sys.exit(main())
