"""Pictures, animations, plots and report pages."""
