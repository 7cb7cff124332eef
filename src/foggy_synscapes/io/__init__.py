"""Files: reading and writing images, shards, tables and run records. Knows no formula."""
