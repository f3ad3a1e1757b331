"""Files and documents that others wrote, or may read."""
