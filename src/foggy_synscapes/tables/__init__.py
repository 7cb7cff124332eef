"""Tables: frames of numbers in, text out. Rounding and bold marks, LaTeX, Markdown, HTML."""
