"""Contact laws from measurements: files, fits, validation, and numbers of laws from single quantities."""
