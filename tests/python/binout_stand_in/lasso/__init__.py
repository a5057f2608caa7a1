"""A stand-in for lasso-python."""
