"""Bodies and the points, edges and frames on them."""
