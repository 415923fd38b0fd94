"""The notebooks' tools."""
