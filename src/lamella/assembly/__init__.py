"""From blocks to one residual and one matrix in the independent coordinates."""
