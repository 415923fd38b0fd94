"""The words of command lines: the parser in two languages, exit codes, errors as sentences."""
