"""Features of the page, one module each."""
