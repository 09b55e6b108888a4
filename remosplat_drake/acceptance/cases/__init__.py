"""The fault campaign's cases, one file for each theme: `CASES` of each."""
