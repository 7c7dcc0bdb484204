"""Constraints between coordinate vectors."""
