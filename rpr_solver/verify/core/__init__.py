"""The trusted core: what is read, with which numbers, and the few tests that decide; the rest proposes."""
