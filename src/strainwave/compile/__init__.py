"""All of Numba: kernels, the methods of models inside them, lanes, the cache."""
