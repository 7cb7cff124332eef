"""Where results come from: run records, read backwards."""
