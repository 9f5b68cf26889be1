"""One question each: which probes, which methods, which table."""
