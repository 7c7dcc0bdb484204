"""Materials, laminates and failure criteria."""
