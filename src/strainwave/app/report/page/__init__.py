"""A drive as one HTML file that computes: the project's own kernels in WebAssembly, its numbers and its sentences."""
