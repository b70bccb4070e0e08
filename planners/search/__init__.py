"""Search planners: one module each, kernels with leading batch axes under thin adapters."""
