"""The on-disk layouts of the datasets, one module each, and their label encodings."""
