"""Parts of tools/docs.py, a module each with `main(given, prog)`."""
