"""Temperature fields of plates and what heats and cools them."""
