"""Pages to look at: one HTML file each, with all that it shows, opened from disk; their looks are in templates/."""
