"""Derivatives of outputs by parameters: solutions are differentiated with their exact matrices, residuals by differences."""
