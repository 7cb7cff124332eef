"""One module per word: paths in, paths out. A stage calls cores and knows no formula."""
