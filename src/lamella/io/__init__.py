"""Model files, result files and ParaView's files: what is read and written."""
