"""A scene becomes a body under its model, in code units."""
