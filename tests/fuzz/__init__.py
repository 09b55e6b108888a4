"""A campaign of mutated files against every reader.

For any file, a reader answers with its content or with one line: no
traceback, no crash, no hang, and no memory beyond a multiple of the file. A
minute of it runs in the suite; `python -m tests.fuzz --hours 2` runs on.
"""
