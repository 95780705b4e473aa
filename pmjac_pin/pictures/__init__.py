"""Pictures: figures and drawings."""
