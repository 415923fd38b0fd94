"""results.json, and all that is made from it alone: terminal, page, JUnit, history."""
