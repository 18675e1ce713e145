"""Methods whose resolution is a number of terms: assumed modes, power series, Chebyshev."""
