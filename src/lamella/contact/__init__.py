"""Contact with friction between shells and obstacles of simple shape."""
