"""Parameter studies: one model run at many values of its parameters, on the cores of a machine or on a cluster."""
